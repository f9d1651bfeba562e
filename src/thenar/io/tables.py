"""From a problem to the tables of a model file: what is as in most files is left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.io.block import arrow_lines
from thenar.io.expressions import MAX_TEXT, written
from thenar.io.foreign.assemble import columns
from thenar.io.layout import Lines, Table, Tables, Value
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.expressions import TRUE, Constant, Expression, Operation
from thenar.model.extended import Condition, ExtendedAutomaton, ExtendedProblem
from thenar.model.names import every_name
from thenar.model.problem import Problem
from thenar.model.variables import Variable

__all__ = ["tables_of"]

LONG = 1_000  # entries from which on a list is written as one text: parsers are quicker with that, and so is the eye


def tables_of(problem: Problem | ExtendedProblem) -> Tables:
    """Return what a file says of ``problem``.

    Raises InputError for what it has no words for.

    >>> tables_of(Problem(Automaton.from_transitions(["dark -on-> lit"], initial="dark", name="LAMP"))).automata
    {'LAMP': {'kind': 'plant', 'initial': 'dark', 'transitions': ['dark -on-> lit']}}
    """
    if sum(not a.name for a in problem.automata) > 1:  # named ones differ, a problem sees to that
        raise InputError("two automata have no name; a model file tells automata by their names")
    heading: dict[str, Value] = {"name": problem.name, "description": problem.description}
    texts = _Texts()
    variables: dict[str, Table] = {}
    conditions: list[Table] = []
    if isinstance(problem, ExtendedProblem):
        for key, predicate in (("initial", problem.initial), ("marked", problem.marked)):
            heading[key] = "" if predicate == TRUE else texts.truth(predicate, key)
        variables = {v.name: _variable_table(v) for v in problem.variables}
        conditions = [_condition_table(c, "plant", texts) for c in problem.plant_conditions]
        conditions += [_condition_table(c, "spec", texts) for c in problem.spec_conditions]
    plants, specs = problem.plants, problem.specs
    return Tables(
        {key: value for key, value in heading.items() if value},
        {event.name: _event_table(event) for event in problem.alphabet},
        variables,
        {
            a.name: _automaton_table(a, kind, texts)
            for kind, parts in (("plant", plants), ("spec", specs))
            for a in parts
        },
        conditions,
    )


class _Texts:
    """Writes expressions, and stops where a reader would."""

    def __init__(self) -> None:
        self._characters = 0

    def truth(self, expression: Expression, where: str) -> str:
        text = written(expression, where)
        self._count(len(text))
        return text

    def value(self, expression: Expression, where: str) -> Value:
        if isinstance(expression, Constant) and not isinstance(expression.value, str):
            self._count(1)
            return expression.value
        return self.truth(expression, where)

    def _count(self, characters: int) -> None:
        self._characters += characters
        if self._characters > MAX_TEXT:
            raise InputError(f"expressions of more than {MAX_TEXT:,} characters together are too long for a model file")


def _event_table(event: Event) -> Table:
    table: dict[str, Value] = {}
    if not event.controllable:
        table["controllable"] = False
    if not event.observable:
        table["observable"] = False
    if event.forcible:
        table["forcible"] = True
    if event.meaning:
        table["meaning"] = event.meaning
    return table


def _variable_table(variable: Variable) -> Table:
    values = variable.values
    table: dict[str, Value] = {"values": list(values)}
    if values == (False, True) and isinstance(values[0], bool):
        table["values"] = "bool"
    elif not isinstance(values[0], bool | str) and values == tuple(range(values[0], values[0] + len(values))):
        table["values"] = f"{values[0]}..{values[-1]}"
    table["initial"] = variable.initial[0] if len(variable.initial) == 1 else list(variable.initial)
    if variable.marked != values:
        table["marked"] = variable.marked[0] if len(variable.marked) == 1 else list(variable.marked)
    return table


def _condition_table(condition: Condition, kind: str, texts: _Texts) -> Table:
    table: dict[str, Value] = {"kind": kind}
    if condition.name:
        table["name"] = condition.name
    where = f"condition {condition.name!r}" if condition.name else "a condition"
    predicate = condition.predicate
    if condition.event is None:
        table["invariant"] = texts.truth(predicate, where)
    else:
        table["event"] = condition.event
        where = where if condition.name else f"the condition on {condition.event!r}"
        if isinstance(predicate, Operation) and predicate.operator == "not":
            table["disabled_when"] = texts.truth(predicate.operands[0], where)
        else:
            table["needs"] = texts.truth(predicate, where)
    if condition.meaning:
        table["says"] = condition.meaning
    return table


# -- automata ------------------------------------------------------------------------------------------------


def _automaton_table(automaton: Automaton | ExtendedAutomaton, kind: str, texts: _Texts) -> Table:
    owner = f"automaton {automaton.name!r}" if automaton.name else "the automaton"
    states = automaton.states if isinstance(automaton, ExtendedAutomaton) else every_name(automaton.states)
    if not states:
        raise InputError(f"{owner} has no states, and a model file needs an initial one; there is nothing to write")
    if not all(states):
        raise InputError(f"{owner}: state {states.index('')} has an empty name; a model file needs one")
    if len(set(states)) < len(states):
        twice = next(q for q, times in Counter(states).items() if times > 1)
        raise InputError(f"{owner}: two states are called {twice!r}; a model file tells states by their names")
    table: dict[str, Value] = {"kind": kind}
    if automaton.meaning:
        table["says"] = automaton.meaning
    sources, events, targets = columns(automaton)
    ends = np.column_stack((sources, targets)).ravel()
    carried = np.bincount(events, minlength=len(automaton.alphabet))
    if isinstance(automaton, Automaton):
        initial = [automaton.initial]
        marked = np.flatnonzero(automaton.marked).tolist()
    else:
        initial = [q for q, first in enumerate(automaton.initial) if first]
        marked = [q for q, end in enumerate(automaton.marked) if end]
    table["initial"] = states[initial[0]] if len(initial) == 1 else [states[q] for q in initial]
    long = isinstance(automaton, Automaton) and automaton.n_transitions > LONG and _fit_lines(automaton, states)
    if marked:
        table["marked"] = _several([states[q] for q in marked], long)
    if not _mentioned_in_order(initial, ends, len(states)):
        table["states"] = _several(states, long)
    if blocked := [event.name for event, times in zip(automaton.alphabet, carried, strict=True) if not times]:
        table["alphabet"] = blocked
    if isinstance(automaton, ExtendedAutomaton) and _is_nondeterministic(automaton):
        table["nondeterministic"] = True
    if long and isinstance(automaton, Automaton):
        table["transitions"] = Lines(arrow_lines(automaton, states))
    elif len(ends):
        table["transitions"] = _transitions(automaton, states, owner, texts)
    return table


def _several(names: Sequence[str], long: bool) -> Value:
    return Lines([f"{name}\n" for name in names]) if long and len(names) > LONG else names


def _mentioned_in_order(initial: list[int], ends: NDArray[np.int64], n: int) -> bool:
    """Return whether the initial states, then the ends of the transitions, mention state 0 first, then 1, then 2..."""
    mentioned = np.concatenate((np.array(initial, np.int64), ends))
    highest = np.maximum.accumulate(mentioned)
    return mentioned[0] == 0 and bool((mentioned[1:] <= highest[:-1] + 1).all()) and int(highest[-1]) == n - 1


def _transitions(
    automaton: Automaton | ExtendedAutomaton, states: Sequence[str], owner: str, texts: _Texts
) -> Sequence[Value]:
    if isinstance(automaton, Automaton):
        triples = list(automaton.transitions())
    else:
        triples = [(states[e.source], automaton.alphabet[e.event].name, states[e.target]) for e in automaton.edges]
    arrows = all(map(_fits_arrow, states))
    entries: list[Value] = [f"{s} -{e}-> {t}" for s, e, t in triples] if arrows else [list(t) for t in triples]
    if isinstance(automaton, ExtendedAutomaton):
        entries = [_guarded(automaton, k, arrow, owner, texts) for k, arrow in enumerate(entries)]
    return entries


def _fits_arrow(state: str) -> bool:
    return state == state.strip() and "->" not in state


def _fit_lines(automaton: Automaton, states: Sequence[str]) -> bool:
    """Return whether a text in TOML's three single quotes can hold the transitions, each unmistakable on its line."""
    text, names = "\n".join(("", *states, "")), (*states, *automaton.alphabet.names)
    if any(odd in text for odd in ("->", " \n", "\n ")) or not all(map(str.isprintable, names)):
        return False
    return "'''" not in text and not any("'" in event for event in automaton.alphabet.names)


def _guarded(automaton: ExtendedAutomaton, k: int, arrow: Value, owner: str, texts: _Texts) -> Value:
    """Return edge ``k``: its arrow alone, or with what the edge needs and does."""
    edge = automaton.edges[k]
    if edge.guard == TRUE and not edge.updates:
        return arrow
    where = f"{owner}, {automaton.place(k)}"
    table: dict[str, Value] = {"arrow": arrow}
    if edge.guard != TRUE:
        table["when"] = texts.truth(edge.guard, where)
    if edge.updates:
        table["do"] = {variable: texts.value(value, where) for variable, value in edge.updates}
    return table


def _is_nondeterministic(automaton: ExtendedAutomaton) -> bool:
    """Return whether two edges of one state and event have no guards that could tell them apart."""
    seen: set[tuple[int, int, int, Expression, object]] = set()
    unguarded: set[tuple[int, int]] = set()
    for e in automaton.edges:
        whole = (e.source, e.event, e.target, e.guard, e.updates)
        if whole in seen or (e.guard == TRUE and (e.source, e.event) in unguarded):
            return True
        seen.add(whole)
        if e.guard == TRUE:
            unguarded.add((e.source, e.event))
    return False
