"""Invariants of the plants as guards: a module can say that no event leads to a state, not that there is no such."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from math import prod

from thenar.errors import InputError
from thenar.io.foreign.waters.looks import asked_by, never_both, true_for
from thenar.model.expressions import (
    FALSE,
    TRUE,
    At,
    Constant,
    Expression,
    Name,
    Operation,
    Value,
    conjunction,
    shortened,
)
from thenar.model.extended import Edge, ExtendedAutomaton, ExtendedProblem

__all__ = ["guards_of", "holds_at_first"]

MAX_WAYS = 2_000  # in which automata take part in one event together
MAX_STARTS = 100_000  # initial states that are looked at


def guards_of(problem: ExtendedProblem, predicate: Expression) -> Iterator[tuple[str, Expression]]:
    """Yield the events that may make ``predicate``, which holds before, false, and where they do not.

    In what an event does, ``predicate`` is about the states entered and the values after it: it is worked out for
    each way in which the plants that it is about take part in the event.  Raises InputError if a plant may choose
    between edges that no guards tell apart, and for more than 2,000 ways.
    """
    parts = predicate.operands if isinstance(predicate, Operation) and predicate.operator == "and" else (predicate,)
    asked = asked_by(predicate)
    names = {leaf.name for leaf in asked if isinstance(leaf, Name)}
    for event in problem.alphabet.names:
        choices = []
        for a in problem.plants:
            if event not in a.alphabet:
                continue
            edges = [e for e in a.edges if e.event == a.alphabet.index(event)]
            own = [leaf for leaf in asked if isinstance(leaf, At) and leaf.automaton == a.name]
            if own or any(v in names for e in edges for v, _ in e.updates):
                choices.append(_options(problem, a, edges, own, names, predicate))
        if prod(map(len, choices)) > MAX_WAYS:
            what = f"the plant's invariant {shortened(str(predicate))!r} depends on more than {MAX_WAYS:,} ways"
            raise InputError(f"{what} in which automata take part in {event!r}; make it one of the specifications")
        clauses = []
        for ways in product(*choices):
            effects = {leaf: value for _, effect in ways for leaf, value in effect.items()}
            entered = [(_with(part, effects), part) for part in parts]
            after = conjunction(new for new, part in entered if new != part)  # what does not change holds already
            if after != TRUE:
                here = conjunction(where for where, _ in ways)
                clauses.append(_simple(Operation("or", (_simple(Operation("not", (here,))), after))))
        if clauses:
            yield event, conjunction(clauses)


Option = tuple[Expression, Mapping[At | Name, Expression]]
"""Where an automaton takes an edge, and what the states and variables that are asked for are afterwards."""


def _options(
    problem: ExtendedProblem,
    a: ExtendedAutomaton,
    edges: Sequence[Edge],
    own: Sequence[At],
    names: set[str],
    predicate: Expression,
) -> list[Option]:
    groups: dict[tuple[object, ...], list[Edge]] = {}
    effects: dict[tuple[object, ...], Mapping[At | Name, Expression]] = {}
    for e in edges:
        effect: dict[At | Name, Expression] = {at: Constant(a.states[e.target] == at.state) for at in own}
        effect |= {Name(v): x for v, x in e.updates if v in names}
        key = tuple(effect.items())
        groups.setdefault(key, []).append(e)
        effects[key] = effect
    domains = {v.name: v.values for v in problem.variables}
    for q in dict.fromkeys(e.source for e in edges):
        leaving = [(k, e.guard) for k, group in enumerate(groups.values()) for e in group if e.source == q]
        if not never_both(leaving, domains):
            what = f"automaton {a.name!r} may choose by {a.alphabet[edges[0].event].name!r} whether it stays true"
            raise InputError(f"the plant's invariant {shortened(str(predicate))!r}: {what}; add guards")
    return [
        (_any(conjunction([At(a.name, a.states[e.source]), e.guard]) for e in groups[key]), effect)
        for key, effect in effects.items()
    ]


def holds_at_first(problem: ExtendedProblem, predicate: Expression) -> bool:
    """Return whether ``predicate`` holds wherever the automata and variables that it is about may start."""
    asked = asked_by(predicate)
    owners = list(dict.fromkeys(leaf.automaton if isinstance(leaf, At) else leaf.name for leaf in asked))
    starts: dict[str, Sequence[Value]] = {v.name: v.initial for v in problem.variables}
    starts |= {a.name: [q for q, first in zip(a.states, a.initial, strict=True) if first] for a in problem.automata}
    if prod(len(starts[name]) for name in owners) > MAX_STARTS:
        return False
    for chosen in product(*(starts[name] for name in owners)):
        place = dict(zip(owners, chosen, strict=True))
        known = [(place[x.automaton] == x.state,) if isinstance(x, At) else (place[x.name],) for x in asked]
        if not true_for(predicate, asked, known).all():
            return False
    return True


# -- expressions ---------------------------------------------------------------------------------------------


def _with(expression: Expression, values: Mapping[At | Name, Expression]) -> Expression:
    """Return ``expression`` with other expressions in the place of states and variables."""
    if isinstance(expression, Operation):
        return _simple(Operation(expression.operator, tuple(_with(x, values) for x in expression.operands)))
    return expression if isinstance(expression, Constant) else values.get(expression, expression)


def _any(parts: Iterator[Expression]) -> Expression:
    listed = tuple(parts)
    return listed[0] if len(listed) == 1 else Operation("or", listed)


def _simple(operation: Operation) -> Expression:
    """Return ``operation`` without truths that are known."""
    operands = operation.operands
    match operation.operator:
        case "not" if operands[0] in (TRUE, FALSE):
            return FALSE if operands[0] == TRUE else TRUE
        case "and" | "or" as operator:
            neutral, zero = (TRUE, FALSE) if operator == "and" else (FALSE, TRUE)
            if zero in operands:
                return zero
            kept = tuple(x for x in operands if x != neutral)
            return neutral if not kept else kept[0] if len(kept) == 1 else Operation(operator, kept)
        case "if" if operands[0] in (TRUE, FALSE):
            return operands[1] if operands[0] == TRUE else operands[2]
    return operation
