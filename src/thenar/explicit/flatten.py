"""From an extended problem to a plain one: its states listed one by one, variables and all."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.explicit.rows import row_offsets
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.expressions import TRUE, At, Constant, Expression, Name, Value, evaluate
from thenar.model.extended import Condition, Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.names import Listed
from thenar.model.problem import Problem

__all__ = ["START", "Flat", "flatten"]

Rows: TypeAlias = NDArray[np.int64]
"""(n, parts): the state of each automaton and the value (its position) of each variable."""

START, BROKEN = "start", "requirement"  # events that no model has: their names hold a character that none may hold
CHOICE = "choice"
CHUNK = 1 << 14  # combinations of initial states and values that are looked at together


@dataclass(frozen=True, slots=True)
class Flat:
    """An extended problem as a plain one of one plant and one specification with the same states.

    ``states`` (n, parts) are the states of the problem; the first states of ``problem`` in this order are these.
    Behind them come states that only keep the books: where the outcome of an event is chosen, and, if there are
    several initial states, one before them.
    """

    problem: Problem
    states: Rows
    is_plain: bool  # one initial state, and no event with several outcomes


def flatten(problem: ExtendedProblem, tick: kernel.Ticker) -> Flat:
    """List the states that plants and specifications of ``problem`` reach, and what happens in them.

    The plant can do in each state what the plants can, the specification what the specifications allow.  An
    event with several outcomes leads to a state of its own, from which uncontrollable events lead on; several
    initial states follow a state of their own by controllable events: so the supervisor of the plain problem
    disables an event as a whole, and chooses where to start.  States of which a specification's invariant does not hold
    have an uncontrollable event that the specification forbids.

    Python and NumPy: some 10^5 states a second.  Raises LimitReached at a limit of the ticker.
    """
    return _Flattening(problem, tick).run()


@dataclass(slots=True)
class _Step:
    """How an event moves the states of a set of rows: sources (positions) and the rows entered."""

    sources: NDArray[np.int64]
    targets: Rows


@dataclass(slots=True)
class _Found:
    """Transitions by number of state."""

    source: list[NDArray[np.int64]] = field(default_factory=list)
    event: list[NDArray[np.int64]] = field(default_factory=list)
    target: list[NDArray[np.int64]] = field(default_factory=list)
    n: int = 0

    def add(self, source: NDArray[np.int64], event: int, target: NDArray[np.int64]) -> None:
        self.source.append(source)
        self.event.append(np.full(len(source), event, np.int64))
        self.target.append(target)
        self.n += len(source)

    def columns(self) -> Rows:
        parts = (np.concatenate(c) if c else np.zeros(0, np.int64) for c in (self.source, self.event, self.target))
        return np.stack(list(parts), axis=1)


class _Flattening:
    def __init__(self, problem: ExtendedProblem, tick: kernel.Ticker) -> None:
        self.problem, self.tick = problem, tick
        names = [*(a.name for a in problem.automata), *(v.name for v in problem.variables)]
        self.column = {name: k for k, name in enumerate(names)}
        self.codes = [np.array([_code(x) for x in v.values]) for v in problem.variables]
        by_code = [np.argsort(codes, kind="stable") for codes in self.codes]
        self.rising = [(codes[order], order) for codes, order in zip(self.codes, by_code, strict=True)]
        self.n_automata = len(problem.automata)
        self.state_number = [{s: k for k, s in enumerate(a.states)} for a in problem.automata]
        self.edges = [_edges_by_event(a) for a in problem.automata]
        self.number: dict[bytes, int] = {}
        self.rows: list[Rows] = []

    # -- values --------------------------------------------------------------------------------------------

    def truth(self, expression: Expression, rows: Rows) -> NDArray[np.bool_]:
        """Return where ``expression`` is true."""
        return np.broadcast_to(self.value(expression, rows), len(rows)).astype(np.bool_)

    def value(self, expression: Expression, rows: Rows) -> Any:
        def leaf(x: Constant | Name | At) -> Any:
            if isinstance(x, Constant):
                return _code(x.value)
            if isinstance(x, At):
                k = self.column[x.automaton]
                return rows[:, k] == self.state_number[k][x.state]
            k = self.column[x.name]
            return self.codes[k - self.n_automata][rows[:, k]]

        return evaluate(expression, leaf)

    def all_hold(self, conditions: Sequence[Condition], event: str | None, rows: Rows) -> NDArray[np.bool_]:
        """Return where the conditions on ``event`` (None: the invariants) hold."""
        holds = np.ones(len(rows), np.bool_)
        for c in conditions:
            if c.event == event:
                holds &= self.truth(c.predicate, rows)
        return holds

    # -- steps ---------------------------------------------------------------------------------------------

    def steps(self, event: Event, automata: Sequence[int], rows: Rows) -> Iterator[_Step]:
        """Yield what ``event`` does in ``automata`` together, for each choice of edges."""
        own = [k for k in automata if event.name in self.edges[k]]
        for chosen in itertools.product(*(self.edges[k][event.name] for k in own)):
            here = np.ones(len(rows), np.bool_)
            for k, edge in zip(own, chosen, strict=True):
                here &= rows[:, k] == edge.source
            at = np.flatnonzero(here)
            for edge in chosen:
                if len(at) and edge.guard != TRUE:
                    at = at[self.truth(edge.guard, rows[at])]
            if not len(at):
                continue
            targets = rows[at].copy()
            fits = np.ones(len(at), np.bool_)
            for k, edge in zip(own, chosen, strict=True):
                targets[:, k] = edge.target
                for variable, new in edge.updates:
                    column = self.column[variable]
                    rising, position = self.rising[column - self.n_automata]
                    values = np.broadcast_to(self.value(new, rows[at]), len(at))
                    place = np.minimum(np.searchsorted(rising, values), len(rising) - 1)
                    fits &= rising[place] == values
                    targets[:, column] = position[place]
            yield _Step(at[fits], targets[fits])

    def numbered(self, rows: Rows) -> NDArray[np.int64]:
        """Return the number of each row; new ones are given the next."""
        if not len(rows):
            return np.zeros(0, np.int64)
        raw = np.ascontiguousarray(rows).tobytes()
        width = rows.shape[1] * rows.itemsize
        number, fresh = self.number, []
        out = np.empty(len(rows), np.int64)
        for k in range(len(rows)):
            key = raw[k * width : (k + 1) * width]
            found = number.get(key)
            if found is None:
                found = number[key] = len(number)
                fresh.append(k)
            out[k] = found
        if fresh:
            self.rows.append(rows[fresh])
        return out

    # -- the whole -----------------------------------------------------------------------------------------

    def run(self) -> Flat:
        problem = self.problem
        everyone = range(self.n_automata)
        plants = range(len(problem.plants))
        initial = self.numbered(self.initial_rows())
        plant, spec, bad = _Found(), _Found(), []
        done = chunks = 0
        while done < len(self.number):
            first, done = done, len(self.number)
            layer = np.concatenate(self.rows[chunks:])
            chunks = len(self.rows)
            legal = self.all_hold(problem.spec_conditions, None, layer)
            bad.append(first + np.flatnonzero(~legal))
            possible, allowed = {}, {}
            for k, event in enumerate(problem.alphabet):
                if not any(event.name in own for own in self.edges):
                    continue
                self.tick.look(len(self.number), spec.n)
                can = np.zeros(len(layer), np.bool_)
                for step in self.steps(event, plants, layer):
                    can[step.sources[self.all_hold(problem.plant_conditions, None, step.targets)]] = True
                can &= self.all_hold(problem.plant_conditions, event.name, layer)
                may = can & self.all_hold(problem.spec_conditions, event.name, layer)
                taken = []
                for step in self.steps(event, everyone, layer):
                    kept = may[step.sources] & self.all_hold(problem.plant_conditions, None, step.targets)
                    taken.append(_Step(step.sources[kept], step.targets[kept]))
                served = np.zeros(len(layer), np.bool_)
                for step in taken:
                    served[step.sources] = True
                if not event.controllable:
                    legal &= served | ~can
                possible[k], allowed[k] = can & ~served, taken
            for k, refused in possible.items():  # what the plants can and the specifications forbid leads nowhere
                here = first + np.flatnonzero(refused)
                plant.add(here, k, here)
            for k, taken in allowed.items():
                for step in taken:
                    expanded = legal[step.sources]
                    targets = self.numbered(step.targets[expanded])
                    for found in (plant, spec):
                        found.add(first + step.sources[expanded], k, targets)
        return self.assemble(
            initial, plant.columns(), spec.columns(), np.concatenate(bad) if bad else np.zeros(0, np.int64)
        )

    def initial_rows(self) -> Rows:
        problem = self.problem
        firsts = [[k for k, first in enumerate(a.initial) if first] for a in problem.automata]
        firsts += [[v.values.index(x) for x in v.initial] for v in problem.variables]
        found, n = [np.zeros((0, len(firsts)), np.int64)], 0
        combinations = itertools.product(*firsts)
        while some := list(itertools.islice(combinations, CHUNK)):  # there may be more than can be listed
            rows = np.array(some, np.int64)
            found.append(rows[self.truth(problem.initial, rows) & self.all_hold(problem.plant_conditions, None, rows)])
            n += len(found[-1])
            self.tick.look(n, 0)
        return np.concatenate(found)

    def assemble(self, initial: NDArray[np.int64], plant: Rows, spec: Rows, bad: NDArray[np.int64]) -> Flat:
        problem, rows = (
            self.problem,
            np.concatenate(self.rows) if self.rows else np.zeros((0, len(self.column)), np.int64),
        )
        n = len(rows)
        events: list[Event] = list(problem.alphabet)
        taken = {e.name for e in events}
        marked = self.truth(problem.marked, rows)
        masks = [list(a.marked) for a in problem.automata]
        masks += [[x in v.marked for x in v.values] for v in problem.variables]
        for k, mask in enumerate(masks):
            marked &= np.array(mask, np.bool_)[rows[:, k]]
        plant, spec = np.unique(plant, axis=0), np.unique(spec, axis=0)
        plant, spec, n_choices, widest = _resolved(plant, spec, n, len(events))
        events += [Event(_fresh(f"{CHOICE}{k + 1}", taken), controllable=False) for k in range(widest)]
        total = n + n_choices
        if len(bad):
            events.append(Event(_fresh(BROKEN, taken), controllable=False))
            plant = np.concatenate([plant, np.stack([bad, np.full(len(bad), len(events) - 1), bad], axis=1)])
        first = int(initial[0]) if len(initial) == 1 else total
        if len(initial) > 1:
            starts = np.arange(len(events), len(events) + len(initial))
            events += [Event(_fresh(f"{START}{k + 1}", taken)) for k in range(len(initial))]
            ways = np.stack([np.full(len(initial), total), starts, initial], axis=1)
            plant, spec = np.concatenate([plant, ways]), np.concatenate([spec, ways])
            total += 1
        alphabet = Alphabet(events)
        names = Listed((*("|".join(self.written(row)) for row in rows.tolist()), *(f"({k})" for k in range(total - n))))
        marks = np.concatenate([marked, np.zeros(total - n, np.bool_)])
        if not len(initial):
            nothing = Automaton.empty(alphabet, "plants")
            return Flat(Problem(nothing, name=problem.name, alphabet=alphabet), rows, True)
        automata = [
            _automaton(name, alphabet, first, total, found, marks, names)
            for name, found in (("plants", plant), ("specifications", spec))
        ]
        flat = Problem(automata[0], automata[1], name=problem.name, alphabet=alphabet, description=problem.description)
        return Flat(flat, rows, is_plain=total == n)

    def written(self, row: Sequence[int]) -> Iterator[str]:
        for k, automaton in enumerate(self.problem.automata):
            yield automaton.states[row[k]]
        for k, variable in enumerate(self.problem.variables, self.n_automata):
            yield str(Constant(variable.values[row[k]]))


def _resolved(plant: Rows, spec: Rows, n: int, n_events: int) -> tuple[Rows, Rows, int, int]:
    """Put a state of its own wherever an event has several outcomes; return how many, and the most outcomes."""
    key = spec[:, :2]
    _, inverse, counts = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    several = counts[inverse] > 1
    if not several.any():
        return plant, spec, 0, 0
    groups, member = np.unique(inverse[several], return_inverse=True)
    branches = spec[several]
    rank = np.arange(len(branches)) - np.searchsorted(member, member)  # unique() left the branches of a group together
    centre = n + member
    onward = np.stack([centre, n_events + rank, branches[:, 2]], axis=1)
    into = np.unique(np.stack([branches[:, 0], branches[:, 1], centre], axis=1), axis=0)
    choices = np.concatenate([into, onward])
    refused = plant[~_member(plant, spec)]
    spec = np.concatenate([spec[~several], choices])
    return np.concatenate([refused, spec]), spec, len(groups), int(rank.max()) + 1


def _member(rows: Rows, of: Rows) -> NDArray[np.bool_]:
    known = set(map(tuple, of.tolist()))
    return np.array([tuple(r) in known for r in rows.tolist()], np.bool_).reshape(-1)


def _automaton(
    name: str, alphabet: Alphabet, initial: int, n: int, rows: Rows, marked: NDArray[np.bool_], names: Listed
) -> Automaton:
    rows = rows[np.lexsort((rows[:, 1], rows[:, 0]))]
    offsets = row_offsets(np.bincount(rows[:, 0], minlength=n))
    events, targets = rows[:, 1].astype(np.int32), rows[:, 2].astype(np.int32)
    return Automaton(name, alphabet, initial, offsets, events, targets, marked, names)


def _edges_by_event(automaton: ExtendedAutomaton) -> dict[str, list[Edge]]:
    found: dict[str, list[Edge]] = {name: [] for name in automaton.alphabet.names}
    for edge in automaton.edges:
        found[automaton.alphabet[edge.event].name].append(edge)
    return found


def _fresh(name: str, taken: set[str]) -> str:
    """Return ``name``, or one like it, that no event has."""
    while name in taken:
        name += "'"
    taken.add(name)
    return name


_CODES: dict[str, int] = {}


def _code(value: Value) -> int:
    """Return a number for ``value``: different literals have different ones."""
    return _CODES.setdefault(value, len(_CODES)) if isinstance(value, str) else int(value)
