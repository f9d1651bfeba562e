"""Random alphabets, automata and control problems, drawn small and quickly from a ``random.Random``.

The same seed gives the same model.  Small draws give small models, so that Hypothesis, which stands in for
the ``random.Random`` in :mod:`thenar.testing.strategies`, shrinks to readable counterexamples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from random import Random

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.expressions import Constant, Value, parse
from thenar.model.extended import (
    Condition,
    Edge,
    ExtendedAutomaton,
    ExtendedProblem,
    Variable,
    disables,
    invariant,
    needs,
)
from thenar.model.problem import Problem

__all__ = [
    "PLANT",
    "SPEC",
    "Shape",
    "extended_by_chance",
    "numbered_alphabet",
    "problem_by_chance",
    "random_alphabet",
    "random_automaton",
    "random_extended_problem",
    "random_problem",
]


@dataclass(frozen=True, slots=True)
class Shape:
    """What a random automaton looks like: chances in percent.

    ``controllable`` and ``uncontrollable``: that a state has a transition with such an event;
    ``at_first``: the same for uncontrollable events of the initial state;
    ``onward``: that a state leads on to the next one, the first by a controllable event if there is one;
    ``marked``: that a state other than the initial one is marked.
    """

    controllable: int
    uncontrollable: int
    at_first: int
    onward: int
    marked: int


# Tuned, with the chances in random_problem, on some thousand problems.  Plants that wait for a controllable
# event before others come leave room for control: with all chances alike, nineteen of twenty problems are
# empty or trivial.
PLANT = Shape(controllable=50, uncontrollable=40, at_first=5, onward=85, marked=20)
SPEC = Shape(controllable=50, uncontrollable=75, at_first=75, onward=90, marked=85)
UNMARKED_START = 5  # chance in percent that the initial state is not marked


def random_alphabet(rng: Random, *, max_events: int = 8) -> Alphabet:
    """Draw 1 to ``max_events`` events: ``c0, c1, ...`` controllable, ``u0, u1, ...`` uncontrollable.

    >>> random_alphabet(Random(5))
    Alphabet(u0!, u1!, u2!, c3, c4, c5)
    """
    return numbered_alphabet([_chance(rng, 30) for _ in range(_many(rng, 1, max_events))])


def numbered_alphabet(uncontrollable: Sequence[bool]) -> Alphabet:
    """Return one event for each entry: ``numbered_alphabet([False, True])`` is c0, u1!."""
    return Alphabet(Event(f"{'u' if u else 'c'}{k}", controllable=not u) for k, u in enumerate(uncontrollable))


def random_automaton(
    rng: Random, alphabet: Alphabet, *, max_states: int = 4, shape: Shape = PLANT, name: str = ""
) -> Automaton:
    """Draw an automaton with 1 to ``max_states`` states over the whole of ``alphabet``.

    It may block, have states out of reach, or events without any transition, which it forbids.

    >>> list(random_automaton(Random(5), Alphabet(["a", "b"])).transitions())
    [('0', 'a', '1'), ('0', 'b', '0'), ('1', 'b', '2'), ('2', 'a', '0')]
    """
    states = [str(k) for k in range(_many(rng, 1, max_states))]
    marked = [q for q in states if (_chance(rng, shape.marked) if q != "0" else not _chance(rng, UNMARKED_START))]
    targets: dict[tuple[str, str], str] = {}
    for k, q in enumerate(states):
        for e in alphabet:
            chance = shape.controllable if e.controllable else shape.uncontrollable if k else shape.at_first
            if _chance(rng, chance):
                targets[q, e.name] = rng.choice(states)
        onward = [e.name for e in alphabet if e.controllable or k] or alphabet.names
        if onward and _chance(rng, shape.onward):
            targets[q, rng.choice(onward)] = states[(k + 1) % len(states)]
    return Automaton.from_transitions(
        [(q, e, target) for (q, e), target in targets.items()],
        initial="0",
        marked=marked,
        events=alphabet,
        alphabet=alphabet.names,
        states=states,
        name=name,
    )


def random_problem(
    rng: Random, *, max_events: int = 8, max_plants: int = 3, max_specs: int = 3, max_states: int = 4
) -> Problem:
    """Draw a problem of plants with shared and private events, and specs over some of the plants' events.

    ``max_events`` bounds the events of the whole problem, ``max_states`` the states of each automaton.
    By default one problem in five has no supervisor; in two of five there are states to avoid, for a third of
    these because of uncontrollable events; in one of five it is enough to obey the specs, and one in six
    needs no control at all.

    >>> random_problem(Random(6))
    Problem: 3 plants, 2 specs, 8 events (3 uncontrollable)
    """
    alphabet = random_alphabet(rng, max_events=max_events)
    n_plants, n_specs = _many(rng, 1, max_plants), _many(rng, 0, max_specs)
    return problem_by_chance(alphabet, [rng] * n_plants, [rng] * n_specs, max_states=max_states)


def problem_by_chance(
    alphabet: Alphabet, plants: Sequence[Random], specs: Sequence[Random], *, max_states: int = 4
) -> Problem:
    """Draw a problem over ``alphabet`` with one source of chance for each plant and each spec."""
    parts = [[e for e in alphabet if _chance(rng, 40)] for rng in plants]
    for k, event in enumerate(alphabet):
        if not any(event in part for part in parts):
            parts[k % len(parts)].append(event)
    return Problem(
        [
            random_automaton(rng, alphabet.restrict(e.name for e in part), max_states=max_states, name=f"G{k}")
            for k, (rng, part) in enumerate(zip(plants, parts, strict=True), 1)
        ],
        [
            random_automaton(
                rng,
                Alphabet(e for e in alphabet if _chance(rng, 45)),
                max_states=max_states,
                shape=SPEC,
                name=f"E{k}",
            )
            for k, rng in enumerate(specs, 1)
        ],
        alphabet=alphabet,
    )


# -- extended automata ---------------------------------------------------------------------------------------


def random_extended_problem(
    rng: Random,
    *,
    max_events: int = 6,
    max_plants: int = 3,
    max_specs: int = 2,
    max_variables: int = 2,
    max_states: int = 4,
) -> ExtendedProblem:
    """Draw a problem of automata with guards and updates, variables of 2 to 4 values, and conditions.

    By default one problem in three has no supervisor; in two of five there is one and there are states to avoid;
    one in five needs no control.  Half of them have several initial states, in two of five the plant or the
    specification has a choice between edges.

    >>> random_extended_problem(Random(4))
    ExtendedProblem: 2 plants, 0 specs, 2 variables, 3 conditions, 3 events (1 uncontrollable)
    """
    alphabet = random_alphabet(rng, max_events=max_events)
    n_plants, n_specs = _many(rng, 1, max_plants), rng.randint(0, max_specs)
    return extended_by_chance(
        alphabet, [rng] * n_plants, [rng] * n_specs, rng, max_variables=max_variables, max_states=max_states
    )


def extended_by_chance(
    alphabet: Alphabet,
    plants: Sequence[Random],
    specs: Sequence[Random],
    rng: Random,
    *,
    max_variables: int = 2,
    max_states: int = 4,
) -> ExtendedProblem:
    """Draw a problem with one source of chance for each plant and each spec, and ``rng`` for what extends them."""
    plain = ExtendedProblem.of(problem_by_chance(alphabet, plants, specs, max_states=max_states))
    variables = [_random_variable(rng, f"v{k}") for k in range(_many(rng, 0, max_variables))]
    owned: dict[str, list[Variable]] = {a.name: [] for a in plain.automata}
    for v in variables:
        automata = plain.specs if plain.specs and _chance(rng, 30) else plain.plants
        owned[rng.choice(automata).name].append(v)
    updated = [v for a in plain.plants for v in owned[a.name]]
    in_plants, anywhere = _Words(rng, plain.plants, updated), _Words(rng, plain.automata, variables)
    extended_plants = [_extended(rng, a, owned[a.name], in_plants) for a in plain.plants]
    extended_specs = [_extended(rng, a, owned[a.name], anywhere) for a in plain.specs]
    physics = [invariant(in_plants.mostly_true())] * _chance(rng, 12) + [
        _random_need(rng, alphabet, anywhere)
    ] * _chance(rng, 15)
    rules = [invariant(anywhere.mostly_true()) for _ in range(2) if _chance(rng, 30)]
    rules += [_random_need(rng, alphabet, anywhere) for _ in range(2) if _chance(rng, 25)]
    return ExtendedProblem(
        [*extended_plants, *physics],
        [*extended_specs, *rules],
        variables=variables,
        initial=anywhere.mostly_true() if _chance(rng, 5) else "true",
        marked=anywhere.mostly_true() if _chance(rng, 10) else "true",
        alphabet=alphabet,
    )


def _random_variable(rng: Random, name: str) -> Variable:
    low = -1 if _chance(rng, 20) else 0
    numbers: Sequence[Value] = range(low, low + rng.randint(2, 4))
    names: Sequence[Value] = ("red", "green", "blue")[: rng.randint(2, 3)]
    values = tuple(rng.choice([numbers, numbers, numbers, (False, True), names]))
    initial = tuple(v for k, v in enumerate(values) if k == 0 or _chance(rng, 8))
    marked = tuple(v for v in values if v == values[0] or not _chance(rng, 8))
    return Variable(name, values, initial, marked)


class _Words:
    """Random truths about ``automata`` and ``variables``."""

    def __init__(self, rng: Random, automata: Sequence[ExtendedAutomaton], variables: Sequence[Variable]) -> None:
        self.rng, self.automata, self.variables = rng, automata, variables

    def truth(self, depth: int = 1) -> str:
        """Return a truth that may be true about as often as false."""
        rng = self.rng
        if depth and _chance(rng, 30):
            return f"(({self.truth(depth - 1)}) {rng.choice(['and', 'or', '=='])} ({self.truth(depth - 1)}))"
        if self.variables and _chance(rng, 70):
            v = rng.choice(self.variables)
            value = Constant(rng.choice(v.values))
            if isinstance(value.value, bool):
                return v.name if value.value else f"not {v.name}"
            if isinstance(value.value, str):
                return f"{v.name} {rng.choice(['==', '!='])} {value}"
            term = rng.choice([v.name, v.name, v.name, f"{v.name} % 2", f"2 * {v.name} - 1", f"({v.name} + 3) // 2"])
            return f"{term} {rng.choice(['<=', '>=', '==', '!='])} {value}"
        a = rng.choice(self.automata)
        return f"{a.name}[{rng.choice(a.states)!r}]"

    def mostly_true(self) -> str:
        """Return a truth that says that two things do not hold together, or that one does not."""
        return f"not ({self.truth()})" if _chance(self.rng, 30) else f"not ({self.truth()} and {self.truth()})"


def _random_need(rng: Random, alphabet: Alphabet, words: _Words) -> Condition:
    # an uncontrollable event that may not happen somewhere often leaves no supervisor
    event = rng.choice(alphabet.names)
    if not alphabet[event].controllable and _chance(rng, 50):
        event = rng.choice(alphabet.names)
    return needs(event, words.truth()) if _chance(rng, 50) else disables(words.truth(), event)


def _extended(rng: Random, automaton: ExtendedAutomaton, own: Sequence[Variable], words: _Words) -> ExtendedAutomaton:
    """Return ``automaton`` with some guards, updates of its ``own`` variables, choices and initial states more."""
    edges: list[Edge] = []
    for edge in automaton.edges:
        twins = [edge]
        if _chance(rng, 12):
            twins.append(replace(edge, target=rng.randrange(len(automaton.states))))
        for twin in twins:
            guard = parse(words.truth() if _chance(rng, 15) else "true")
            updates = tuple((v.name, parse(_new_value(rng, v))) for v in own if _chance(rng, 50))
            edges.append(replace(twin, guard=guard, updates=updates))
    initial = tuple(first or _chance(rng, 6) for first in automaton.initial)
    return replace(automaton, edges=tuple(edges), initial=initial)


def _new_value(rng: Random, v: Variable) -> str:
    value = str(Constant(rng.choice(v.values)))
    if isinstance(v.values[0], bool):
        return rng.choice([f"not {v.name}", value])
    if isinstance(v.values[0], str):
        return rng.choice([value, value, f"{value} if {v.name} == {v.values[0]} else {v.name}"])
    steps = [f"{v.name} + 1", f"{v.name} - 1", f"({v.name} + 1) % {len(v.values)}", f"-{v.name}"]
    return rng.choice([*steps[:2], *steps, value])


def _many(rng: Random, low: int, high: int) -> int:
    """Draw from ``low`` to ``high``, rather more than less."""
    return max(rng.randint(low, high), rng.randint(low, high))


def _chance(rng: Random, percent: int) -> bool:
    # 0, to which Hypothesis shrinks, means no
    return rng.randrange(100) >= 100 - percent
