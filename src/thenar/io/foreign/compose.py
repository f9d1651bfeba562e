"""From automata with forbidden states, as Supremica draws them, to a problem."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.expressions import At, Expression, Operation
from thenar.model.extended import Condition, ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem
from thenar.model.variables import Variable

__all__ = ["Component", "composed", "without"]

Part: TypeAlias = Automaton | ExtendedAutomaton


@dataclass(frozen=True, slots=True)
class Component:
    """An automaton, whether it is a plant or a specification, and which of its states must not be entered."""

    automaton: Part
    is_plant: bool
    forbidden: tuple[int, ...] = ()


def composed(
    components: Sequence[Component],
    *,
    name: str,
    description: str,
    alphabet: Alphabet,
    variables: Iterable[Variable] = (),
    rules: Sequence[Expression] = (),
    initial: Expression | None = None,
    marked: Expression | None = None,
) -> Problem | ExtendedProblem:
    """Return the problem of ``components``; it is an extended one if it has to be.

    Without a plant among them, all are taken as plants: a supervisor, or specifications, in a file of their own.
    In a plain problem a plant with forbidden states becomes the plant and a specification, the plant without them;
    forbidden states of a specification are left away.  In an extended one an invariant says that they are not
    entered.  ``rules`` are further invariants, ``initial`` and ``marked`` predicates of the problem.

    >>> plant = Automaton.from_transitions(["a -go-> b -go-> c"], initial="a", marked=["b"], name="G")
    >>> problem = composed([Component(plant, True, (2,))], name="", description="", alphabet=plant.alphabet)
    >>> problem.specs
    (Automaton 'G without forbidden states': 2 states (1 marked), 1 transition, 1 event,)
    """
    if not any(c.is_plant for c in components):
        components = [replace(c, is_plant=True) for c in components]
    domains = tuple(variables)
    plain = not domains and not rules and initial is None and marked is None
    if plain and all(isinstance(c.automaton, Automaton) for c in components):
        return _plain(components, name, description, alphabet)
    conditions = [Condition(rule) for rule in rules]
    for c in components:
        a = c.automaton
        for q in c.forbidden:
            conditions.append(Condition(Operation("not", (At(a.name, a.states[q]),)), None, f"{a.name}: forbidden"))
    options = {k: e for k, e in (("initial", initial), ("marked", marked)) if e is not None}
    return ExtendedProblem(
        [c.automaton for c in components if c.is_plant],
        [*(c.automaton for c in components if not c.is_plant), *conditions],
        variables=domains,
        name=name,
        alphabet=alphabet,
        description=description,
        **options,
    )


def _plain(components: Sequence[Component], name: str, description: str, alphabet: Alphabet) -> Problem:
    plants: list[Automaton] = []
    specs: list[Automaton] = []
    taken = {c.automaton.name for c in components}
    for c in components:
        a = c.automaton
        assert isinstance(a, Automaton)
        if c.is_plant:
            plants.append(a)
        elif c.forbidden:
            specs.append(without(a, c.forbidden))
        else:
            specs.append(a)
    for c in components:
        if c.is_plant and c.forbidden and isinstance(c.automaton, Automaton):
            title = f"{c.automaton.name} without forbidden states"
            while title in taken:
                title += "_"
            taken.add(title)
            says = f"No forbidden state of {c.automaton.name} is entered."
            specs.append(replace(without(c.automaton, c.forbidden), name=title, meaning=says))
    return Problem(plants, specs, name=name, alphabet=alphabet, description=description)


def without(automaton: Automaton, states: Sequence[int]) -> Automaton:
    """Return ``automaton`` without ``states`` and their transitions; it has none if the initial state is one of them.

    Its alphabet stays.  O(transitions).

    >>> ring = Automaton.from_transitions(["a -go-> b -go-> c -go-> a"], initial="a", marked=["a"])
    >>> without(ring, [1])
    Automaton: 2 states (1 marked), 1 transition, 1 event
    """
    kept = np.ones(automaton.n_states, np.bool_)
    kept[list(states)] = False
    if automaton.is_empty or not kept[automaton.initial]:
        return Automaton.empty(automaton.alphabet, automaton.name)
    number = np.cumsum(kept) - 1
    sources = np.repeat(np.arange(automaton.n_states), np.diff(automaton.offsets))
    inside = kept[sources] & kept[automaton.targets]
    offsets = np.zeros(int(kept.sum()) + 1, np.int64)
    np.cumsum(np.bincount(number[sources[inside]], minlength=len(offsets) - 1), out=offsets[1:])
    return replace(
        automaton,
        initial=int(number[automaton.initial]),
        offsets=offsets,
        events=automaton.events[inside],
        targets=number[automaton.targets[inside]].astype(np.int32),
        marked=automaton.marked[kept],
        states=automaton.states.take(np.flatnonzero(kept)),
    )
