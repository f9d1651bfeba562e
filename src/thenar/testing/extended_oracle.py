"""The slow, obvious twin of synthesis for extended automata: dictionaries and sets, each rule written down.

A state is a tuple: the name of one state of each plant, then of each specification, then one value of each
variable, in the order of the problem.  The cost grows with the square of the number of states: fine up to
some thousands.

What may happen in a state x, by definition:

* The *plants* can do event e if each plant that knows e has an edge for it whose guard is true at x, the
  plants' conditions on e are true at x, the updates give values that the variables can take, and the state
  that is entered satisfies the plants' invariants.
* The *specifications* allow e if each that knows e has an edge for it whose guard is true at x and whose
  updates give values that the variables can take, and the specifications' conditions on e are true at x.
* Guards, conditions and the right-hand sides of updates read the values that the variables have at x.
* Each choice of one edge in each automaton that knows e is a transition; so one event may lead to several
  states, and the plant chooses.
* x is *illegal* if it violates an invariant of the specifications, or if the plants can do an uncontrollable
  event there that the specifications do not allow.
* x is *marked* if all automata and all values are, and the problem's ``marked`` is true.

An event that no automaton knows never happens.  Where a spec's update leaves the range of its variable an
uncontrollable event makes the state illegal; where a plant's update does, the event cannot happen.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from thenar.model.expressions import At, Constant, Expression, Name, Operation
from thenar.model.extended import Condition, Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem

__all__ = ["Exploration", "State", "Supervision", "evaluate", "explore", "supcon"]

State = tuple[Any, ...]


@dataclass(frozen=True)
class Exploration:
    """All states that the plants and specifications reach together, before any control.

    * ``states``: breadth-first, the initial ones first
    * ``step[x][e]``: the states that event e may lead to from x; no entry if it cannot happen or is not allowed
    * ``possible[x]``: the events that the plants can do at x
    * ``illegal``: the states that violate a specification there and then
    """

    initial: tuple[State, ...]
    states: tuple[State, ...]
    step: Mapping[State, Mapping[str, tuple[State, ...]]]
    possible: Mapping[State, tuple[str, ...]]
    marked: frozenset[State]
    illegal: frozenset[State]

    @property
    def n_transitions(self) -> int:
        """The number of transitions (state, event, state)."""
        return sum(len(targets) for row in self.step.values() for targets in row.values())


@dataclass(frozen=True)
class Supervision:
    """What the largest supervisor leaves: the controlled system, as far as it is reached.

    * ``initial``: the initial states that survive; empty exactly if there is no supervisor
    * ``states``: those reached under control, breadth-first, the initial ones first
    * ``transitions``: (state, event, state), in the order of ``states`` and of the alphabet
    * ``enabled``, ``disabled``: of the controllable events that the plants can do in a state, those that the
      supervisor permits and those that it does not (the specifications' prohibitions included)
    * ``kept``: the greatest fixpoint itself, whether reached under control or not
    """

    initial: tuple[State, ...]
    states: tuple[State, ...]
    transitions: tuple[tuple[State, str, State], ...]
    enabled: Mapping[State, tuple[str, ...]]
    disabled: Mapping[State, tuple[str, ...]]
    marked: frozenset[State]
    kept: frozenset[State]

    def __bool__(self) -> bool:
        """Return whether there is a supervisor."""
        return bool(self.initial)

    @property
    def n_states(self) -> int:
        """The number of states that are reached under control."""
        return len(self.states)


def supcon(problem: Problem | ExtendedProblem) -> Supervision:
    """Return the largest controllable, nonblocking, legal behaviour of ``problem``.

    Start from the legal states.  A controllable event stays enabled in a state while *all* states that it may
    lead to remain.  Remove the states from which an uncontrollable event may lead to a removed state, and those
    from which no marked state can be reached by uncontrollable and enabled events, until none is left to
    remove.  Initial states that are removed are not entered.

    Fewer states never enable more events, so the step is monotone in the set of states: the result is the
    greatest fixpoint, and holds every set that is controllable, legal and nonblocking in itself.

    >>> from thenar.model.extended import ExtendedAutomaton, Variable, invariant
    >>> cup = ExtendedAutomaton.from_edges(
    ...     "CUP", [("up", "fill", "up", "true", {"n": "n + 1"}), ("up", "leak", "up", "n > 2", {"n": "n - 1"})],
    ...     initial="up", marked=["up"], uncontrollable=["leak"])
    >>> loop = supcon(ExtendedProblem([cup], [invariant("n != 2")], variables=[Variable("n", range(6))]))
    >>> loop.states, loop.disabled["up", 1]
    ((('up', 0), ('up', 1)), ('fill',))
    """
    lifted = ExtendedProblem.of(problem)
    system = explore(lifted)
    uncontrollable = {e.name for e in lifted.alphabet if not e.controllable}
    kept = set(system.states) - system.illegal
    while True:
        removed = {
            x
            for x in kept
            for e, targets in system.step[x].items()
            if e in uncontrollable and not kept.issuperset(targets)
        }
        removed |= kept - _coreachable(kept, system)
        if not removed:
            return _controlled(system, kept, uncontrollable)
        kept -= removed


def explore(problem: Problem | ExtendedProblem) -> Exploration:
    """Return what plants and specifications do together, illegal states and what comes after them included.

    >>> from thenar.library.classics import small_factory
    >>> len(explore(small_factory()).states)
    18
    """
    p = ExtendedProblem.of(problem)
    rules = _Rules(p)
    known = {e.name for a in p.automata for e in a.alphabet}
    events = [e for e in p.alphabet if e.name in known]
    initial = rules.initial()
    step: dict[State, dict[str, tuple[State, ...]]] = {}
    possible: dict[State, tuple[str, ...]] = {}
    illegal: set[State] = set()
    queue = list(initial)
    for x in queue:  # grows while it is read
        if x in step:
            continue
        step[x], can = {}, []
        if not rules.hold(p.spec_conditions, x):
            illegal.add(x)
        for e in events:
            moves = rules.plant_moves(e.name, x)
            if not moves:
                continue
            can.append(e.name)
            answers = rules.spec_moves(e.name, x)
            if answers:
                step[x][e.name] = tuple(dict.fromkeys(rules.merge(x, m, a) for m, a in product(moves, answers)))
                queue += step[x][e.name]
            elif not e.controllable:
                illegal.add(x)
        possible[x] = tuple(can)
    marked = frozenset(x for x in step if rules.is_marked(x))
    return Exploration(initial, tuple(step), step, possible, marked, frozenset(illegal))


def _coreachable(kept: set[State], system: Exploration) -> set[State]:
    """Return the states of ``kept`` from which a marked one is reached by events that stay in ``kept``."""
    reaching = kept & system.marked
    while more := {
        x
        for x in kept - reaching
        if any(kept.issuperset(targets) and not reaching.isdisjoint(targets) for targets in system.step[x].values())
    }:
        reaching |= more
    return reaching


def _controlled(system: Exploration, kept: set[State], uncontrollable: set[str]) -> Supervision:
    """Return the part of ``kept`` that is reached from the initial states in it."""
    initial = tuple(x for x in system.initial if x in kept)
    enabled: dict[State, tuple[str, ...]] = {}
    disabled: dict[State, tuple[str, ...]] = {}
    transitions: list[tuple[State, str, State]] = []
    queue = list(initial)
    for x in queue:
        if x in enabled:
            continue
        follows = {e: targets for e, targets in system.step[x].items() if kept.issuperset(targets)}
        enabled[x] = tuple(e for e in follows if e not in uncontrollable)
        disabled[x] = tuple(e for e in system.possible[x] if e not in follows)
        transitions += [(x, e, y) for e, targets in follows.items() for y in targets]
        queue += [y for targets in follows.values() for y in targets]
    reached = tuple(enabled)
    marked = system.marked.intersection(reached)
    return Supervision(initial, reached, tuple(transitions), enabled, disabled, marked, frozenset(kept))


# -- the rules -----------------------------------------------------------------------------------------------

Change = dict[int, Any]  # what a transition writes: position in the state -> new entry


class _Rules:
    """What ``problem`` says about single states."""

    def __init__(self, problem: ExtendedProblem) -> None:
        self.problem = problem
        names = [*(a.name for a in problem.automata), *(v.name for v in problem.variables)]
        self.place = {name: k for k, name in enumerate(names)}

    def value(self, expression: Expression, x: State) -> Any:
        return evaluate(expression, self.place, x)

    def initial(self) -> tuple[State, ...]:
        """Return the states that all of automata, variables, the problem and the plants' invariants admit."""
        p = self.problem
        starts = [[s for s, first in zip(a.states, a.initial, strict=True) if first] for a in p.automata]
        candidates = product(*starts, *(v.initial for v in p.variables))
        return tuple(x for x in candidates if self.value(p.initial, x) and self.hold(p.plant_conditions, x))

    def is_marked(self, x: State) -> bool:
        p = self.problem
        in_automata = all(a.marked[a.states.index(s)] for a, s in zip(p.automata, x, strict=False))
        in_variables = all(x[self.place[v.name]] in v.marked for v in p.variables)
        return bool(in_automata and in_variables and self.value(p.marked, x))

    def hold(self, conditions: Iterable[Condition], x: State, event: str | None = None) -> bool:
        """Return whether the invariants (or what ``event`` needs) are true at ``x``."""
        return all(self.value(c.predicate, x) for c in conditions if c.event == event)

    def plant_moves(self, event: str, x: State) -> list[Change]:
        """Return what the plants may do to ``x`` when ``event`` happens; [] if it cannot."""
        p = self.problem
        if not self.hold(p.plant_conditions, x, event):
            return []
        moves = self._moves(p.plants, 0, event, x)
        return [m for m in moves if self.hold(p.plant_conditions, self.merge(x, m))]

    def spec_moves(self, event: str, x: State) -> list[Change]:
        """Return how the specifications may follow ``event`` from ``x``; [] if they do not allow it."""
        p = self.problem
        if not self.hold(p.spec_conditions, x, event):
            return []
        return self._moves(p.specs, len(p.plants), event, x)

    def _moves(self, automata: Sequence[ExtendedAutomaton], first: int, event: str, x: State) -> list[Change]:
        choices: list[list[Change]] = []
        for k, a in enumerate(automata, first):
            if event in a.alphabet:
                mine = (e for e in a.edges if a.alphabet[e.event].name == event and a.states[e.source] == x[k])
                changes = (self._change(edge, k, a, x) for edge in mine)
                choices.append([c for c in changes if c is not None])
        return [{k: v for change in combination for k, v in change.items()} for combination in product(*choices)]

    def _change(self, edge: Edge, k: int, automaton: ExtendedAutomaton, x: State) -> Change | None:
        """Return what ``edge`` of automaton number ``k`` writes; None if it is not possible at ``x``."""
        if not self.value(edge.guard, x):
            return None
        change: Change = {k: automaton.states[edge.target]}
        domains = {v.name: v.values for v in self.problem.variables}
        for name, expression in edge.updates:
            change[self.place[name]] = new = self.value(expression, x)
            if new not in domains[name]:
                return None
        return change

    @staticmethod
    def merge(x: State, *changes: Change) -> State:
        """Return ``x`` after all ``changes`` at once."""
        written = {k: v for change in changes for k, v in change.items()}
        return tuple(written.get(k, v) for k, v in enumerate(x))


def evaluate(expression: Expression, place: Mapping[str, int], x: State) -> Any:
    """Return the value of a resolved ``expression`` in the state ``x``, by Python's own operators.

    ``place`` gives the position in ``x`` of each automaton and variable.

    >>> from thenar.model.expressions import parse
    >>> evaluate(parse("n + 1 if lit else 0"), {"n": 0, "lit": 1}, (4, True))
    5
    """
    match expression:
        case Constant(value=value):
            return value
        case Name(name=name):
            return x[place[name]]
        case At(automaton=automaton, state=state):
            return x[place[automaton]] == state
        case Operation(operator=operator, operands=operands):
            return _operate(operator, [evaluate(operand, place, x) for operand in operands])


def _operate(operator: str, values: list[Any]) -> Any:
    match operator, values:
        case "and", _:
            return all(values)
        case "or", _:
            return any(values)
        case "not", [a]:
            return not a
        case "neg", [a]:
            return -a
        case "if", [a, b, c]:
            return b if a else c
        case "==", [a, b]:
            return a == b
        case "!=", [a, b]:
            return a != b
        case "<", [a, b]:
            return a < b
        case "<=", [a, b]:
            return a <= b
        case ">", [a, b]:
            return a > b
        case ">=", [a, b]:
            return a >= b
        case "+", [a, b]:
            return a + b
        case "-", [a, b]:
            return a - b
        case "*", [a, b]:
            return a * b
        case "//", [a, b]:
            return a // b
        case "%", [a, b]:
            return a % b
    raise ValueError(f"unknown operator {operator!r} of {len(values)} operands")
