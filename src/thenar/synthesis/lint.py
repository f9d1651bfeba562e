"""What looks wrong in a problem although it can be solved: likely slips of the pen, found on the states reached."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import Mistake, did_you_mean
from thenar.explicit.exploration import ticker
from thenar.explicit.rows import row_offsets, sources
from thenar.model.automaton import Automaton
from thenar.model.expressions import TRUE, Constant
from thenar.model.extended import Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.limits import Limits, Progress
from thenar.model.problem import Problem
from thenar.symbolic.encode import Encoding, EventRelation
from thenar.symbolic.levels import Part
from thenar.symbolic.synthesis import reach

__all__ = ["lint"]


def lint(
    problem: Problem | ExtendedProblem, *, limits: Limits | None = None, progress: Progress | None = None
) -> list[Mistake]:
    """Return what is suspicious in ``problem``, in the order of its parts; an empty list if nothing is.

    Every automaton should have a state.  Plants and specifications run together, without a supervisor, and of the
    states that they reach it is said

    * that none of them is marked
    * which states of an automaton are not among them
    * which events never happen: no automaton has them, one that has them has no transition with them, the plants
      cannot do them, or can but the specifications never allow them
    * which updates would take a variable out of its range, and an example where: such a transition is impossible,
      as if its guard were false

    Of each automaton alone it is said that it marks no state, of a specification from which of its states it cannot
    reach a marked one of its own (it is not trim), and which of its events no plant has, so that a slip of the pen
    there makes it wait for nothing.  In a plain problem each automaton should share an event with another one, and
    a specification with a plant.

    One saturation, a walk over its diagram, and a few set operations for each event and update.  Raises LimitReached
    at one of ``limits``.

    >>> from thenar.model.extended import Variable
    >>> tap = ExtendedAutomaton.from_edges("TAP", [("on", "drip", "on", "", {"level": "level + 1"})],
    ...     initial="on", marked=["on"])
    >>> for mistake in lint(ExtendedProblem([tap], variables=[Variable("level", range(10))])):
    ...     print(mistake)
    automaton 'TAP': on -drip-> on: level := level + 1 leaves 0..9, for example where level == 9; there ...
    """
    if nowhere := [Mistake(f"automaton {a.name!r}", "has no states") for a in problem.automata if not len(a.states)]:
        return nowhere
    encoding = Encoding(problem, ticker(limits, progress), limits=limits)
    reachable = reach(encoding)
    found = []
    where = f"problem {problem.name!r}" if problem.name else "problem"
    if not reachable:
        return [Mistake(where, "no state satisfies the initial conditions of all parts")]
    if not reachable & encoding.marked:
        found.append(Mistake(where, "no marked state is ever reached"))
    taken = _values(encoding, reachable)
    for k, automaton in enumerate((*problem.plants, *problem.specs)):
        found += _alone(problem, automaton, is_spec=k >= len(problem.plants))
        never = [encoding.parts[k].labels[v] for v in np.flatnonzero(~taken[k]).tolist()]
        if never:
            found.append(Mistake(f"automaton {automaton.name!r}", f"never reaches its state {_listed(never)}"))
    known = {e.name: e for e in encoding.events}
    for event in problem.alphabet:
        e = known.get(event.name)
        if e is None:
            found.append(Mistake(f"event {event.name!r}", "no automaton has it"))
        elif not reachable & e.allowed:
            found.append(Mistake(f"event {event.name!r}", f"never happens: {_why_never(problem, e, reachable)}"))
    if isinstance(problem, ExtendedProblem):
        for automaton in problem.automata:
            found += [
                m for edge in automaton.edges if edge.updates for m in _overflow(encoding, reachable, automaton, edge)
            ]
    return found


def _values(encoding: Encoding, states: kernel.Set) -> list[NDArray[np.bool_]]:
    """Return for each part which of its values it has in ``states``; there are some."""
    size = np.array([0, *(encoding.parts[k].size for k in encoding.order[::-1])])  # of each level; 0 is below them all
    levels, children = states.dump()
    level = np.concatenate(([0, 0], levels)).astype(np.int64)  # of each node
    owner = np.repeat(level[2:], size[level[2:]])
    value = np.arange(len(children)) - np.repeat(row_offsets(size[level[2:]])[:-1], size[level[2:]])
    into, from_ = np.append(level[children], level[-1]), np.append(owner, len(size))  # the last one leads to the top
    real = np.append(children != 0, True)
    # a branch that passes levels by leaves them free
    passed = np.zeros(len(size) + 1, np.int64)
    np.add.at(passed, into[real] + 1, 1)
    np.add.at(passed, from_[real], -1)
    taken = np.repeat(np.cumsum(passed)[:-1] > 0, size)
    taken[row_offsets(size)[owner[real[:-1]]] + value[real[:-1]]] = True
    by_level = np.split(taken, np.cumsum(size)[:-1])
    return [by_level[encoding.level[k]] for k in range(len(encoding.parts))]


def _why_never(problem: Problem | ExtendedProblem, event: EventRelation, reachable: kernel.Set) -> str:
    """Say who keeps ``event`` from ever happening: an automaton that always does, else all of its kind."""
    possible = bool(reachable & event.possible)
    for automaton in problem.specs if possible else problem.plants:
        if event.name in automaton.alphabet and automaton.alphabet.index(event.name) not in _used(automaton):
            return f"automaton {automaton.name!r} has it in its alphabet, but no transition with it"
    return "the specifications forbid it wherever it could" if possible else "the plants can do it in no state reached"


def _alone(
    problem: Problem | ExtendedProblem, automaton: Automaton | ExtendedAutomaton, *, is_spec: bool
) -> Iterator[Mistake]:
    """Say what is wrong with ``automaton`` whatever the others do."""
    where = f"automaton {automaton.name!r}"
    if len(automaton.marked) and not any(automaton.marked):
        yield Mistake(where, "marks none of its states, and so no state of the whole is marked")
    elif is_spec and (stuck := _not_trim(automaton)):
        names = _listed(stuck)
        yield Mistake(where, f"is not trim: from its state {names} it reaches no marked state of its own")
    others = [a for a in problem.automata if a is not automaton]
    partners = problem.plants if is_spec else others
    if isinstance(problem, Problem) and others and not any(_meet(automaton, a) for a in partners):
        yield Mistake(where, f"shares no event with {'a plant' if is_spec else 'another automaton'}")
    elif is_spec:
        of_plants = list(dict.fromkeys(e for a in problem.plants for e in a.alphabet.names))
        for name in automaton.alphabet.names:
            if name not in of_plants:
                yield Mistake(where, f"speaks of event {name!r}, which no plant has{did_you_mean(name, of_plants)}")


def _not_trim(automaton: Automaton | ExtendedAutomaton) -> list[str]:
    """Return the states that ``automaton`` can enter, by itself, and from which it reaches no marked one.

    Guards are taken to be true.
    """
    if isinstance(automaton, Automaton):
        initial = [] if automaton.is_empty else [automaton.initial]
        arcs = list(zip(sources(automaton).tolist(), automaton.targets.tolist(), strict=True))
    else:
        initial = [q for q, first in enumerate(automaton.initial) if first]
        arcs = [(e.source, e.target) for e in automaton.edges]
    marked = [q for q, is_marked in enumerate(automaton.marked) if is_marked]
    wrong = _closure(initial, arcs) - _closure(marked, [(target, source) for source, target in arcs])
    return [automaton.states[q] for q in sorted(wrong)]


def _closure(start: Iterable[int], arcs: Iterable[tuple[int, int]]) -> set[int]:
    """Return the states of ``start``, and those that lead on from there."""
    onward: dict[int, list[int]] = {}
    for source, target in arcs:
        onward.setdefault(source, []).append(target)
    todo, found = list(start), set(start)
    while todo:
        new = set(onward.get(todo.pop(), ())) - found
        found |= new
        todo += new
    return found


def _used(automaton: Automaton | ExtendedAutomaton) -> set[int]:
    """Return the positions of the events that have a transition."""
    if isinstance(automaton, Automaton):
        return set(np.unique(automaton.events).tolist())
    return {edge.event for edge in automaton.edges}


def _meet(automaton: Automaton | ExtendedAutomaton, other: Automaton | ExtendedAutomaton) -> bool:
    return any(event in other.alphabet for event in automaton.alphabet.names)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(repr(q) for q in names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")


def _overflow(encoding: Encoding, reachable: kernel.Set, automaton: ExtendedAutomaton, edge: Edge) -> Iterator[Mistake]:
    """Say of each update of ``edge`` where its guard holds and the new value is none of the variable's."""
    if not edge.updates:
        return
    source = np.arange(len(automaton.states)) == edge.source
    here = reachable & encoding.literal(encoding.number[automaton.name], source) & encoding.predicate(edge.guard)
    arrow = f"{automaton.states[edge.source]} -{automaton.alphabet[edge.event].name}-> {automaton.states[edge.target]}"
    for variable, value in edge.updates:
        lost = here - encoding.happens(Edge(edge.source, edge.event, edge.target, TRUE, ((variable, value),)))
        if not lost:
            continue
        row = encoding.first(lost)
        read = sorted(encoding.support(value))
        example = ", ".join(_holds(encoding.parts[k], row[k]) for k in read)
        where = f"for example where {example}; there the transition is impossible" if read else "and so is impossible"
        leaves = f"{variable} := {value} leaves {_range(encoding.parts[encoding.number[variable]])}"
        yield Mistake(f"automaton {automaton.name!r}", f"{arrow}: {leaves}, {where}")


def _holds(part: Part, value: int) -> str:
    return f"{part.name} == {part.labels[value]}" if part.values else f"{part.name}.{part.labels[value]}"


def _range(part: Part) -> str:
    values = part.values
    if isinstance(values[0], int) and list(values) == list(range(values[0], values[0] + len(values))):
        return f"{values[0]}..{values[-1]}"
    return ", ".join(str(Constant(v)) for v in values)
