"""What looks wrong in a problem although it can be solved: likely slips of the pen, found on the states reached."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from thenar._native import kernel
from thenar.errors import Mistake
from thenar.explicit.exploration import ticker
from thenar.model.expressions import TRUE, Constant
from thenar.model.extended import Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.limits import Limits, Progress
from thenar.model.problem import Problem
from thenar.symbolic.encode import Encoding
from thenar.symbolic.levels import Part
from thenar.symbolic.synthesis import reach

__all__ = ["lint"]


def lint(
    problem: Problem | ExtendedProblem, *, limits: Limits | None = None, progress: Progress | None = None
) -> list[Mistake]:
    """Return what is suspicious in ``problem``, in the order of its parts; an empty list if nothing is.

    Plants and specifications run together, without a supervisor, and of the states that they reach it is said

    * that none of them is marked
    * which states of an automaton are not among them
    * which events never happen, and which the plants can do but the specifications never allow
    * which updates would take a variable out of its range, and an example where: such a transition is impossible,
      as if its guard were false

    One saturation, and a few set operations for each event and update.  Raises LimitReached at one of ``limits``.

    >>> from thenar.model.extended import Variable
    >>> tap = ExtendedAutomaton.from_edges("TAP", [("on", "drip", "on", "", {"level": "level + 1"})],
    ...     initial="on", marked=["on"])
    >>> for mistake in lint(ExtendedProblem([tap], variables=[Variable("level", range(10))])):
    ...     print(mistake)
    automaton 'TAP': on -drip-> on: level := level + 1 leaves 0..9, for example where level == 9; there ...
    """
    encoding = Encoding(problem, ticker(limits, progress), limits=limits)
    reachable = reach(encoding)
    found = []
    where = f"problem {problem.name!r}" if problem.name else "problem"
    if not reachable:
        return [Mistake(where, "no state satisfies the initial conditions of all parts")]
    if not reachable & encoding.marked:
        found.append(Mistake(where, "no marked state is ever reached"))
    for k, automaton in enumerate((*problem.plants, *problem.specs)):
        part = encoding.parts[k]
        hit = [bool(reachable & encoding.literal(k, np.arange(part.size) == v)) for v in range(part.size)]
        never = [part.labels[v] for v in range(part.size) if not hit[v]]
        if never:
            names = ", ".join(repr(q) for q in never[:5]) + (f" and {len(never) - 5} more" if len(never) > 5 else "")
            found.append(Mistake(f"automaton {automaton.name!r}", f"never reaches its state {names}"))
    known = {e.name: e for e in encoding.events}
    for event in problem.alphabet:
        e = known.get(event.name)
        if e is None:
            found.append(Mistake(f"event {event.name!r}", "no automaton has it"))
        elif not reachable & e.possible:
            found.append(Mistake(f"event {event.name!r}", "never happens: the plants can do it in no state reached"))
        elif not reachable & e.allowed:
            why = "never happens: the specifications forbid it wherever it could"
            found.append(Mistake(f"event {event.name!r}", why))
    if isinstance(problem, ExtendedProblem):
        for automaton in problem.automata:
            found += [
                m for edge in automaton.edges if edge.updates for m in _overflow(encoding, reachable, automaton, edge)
            ]
    return found


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
