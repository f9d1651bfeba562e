"""Planning: the policy of least expected time to a marked state, with what the task is for done on the way."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.explicit.components import strong_components
from thenar.model.supervisor import Supervisor
from thenar.runtime.binding import check_binding
from thenar.runtime.cells import Cells, unfold
from thenar.runtime.driver import Driver

__all__ = ["PENALTY_S", "Shortest"]

PENALTY_S = 1000.0  # for each goal event missed: far above any run, so that giving up is the last resort
CAP_S = 1e6  # the value of a state from which no end is sure; above all penalties
MAX_GOALS = 8  # the plan holds every subset of the goal events
MAX_TRANSITIONS = 8_000_000  # times subsets; 64 MB each of a handful of arrays
_TOLERANCE = 1e-9  # relative, of an expected time
_MAX_ODDS = 0.999  # a skill that is always interrupted would never be worth its start
_TIE = 1e-8  # relative; what differs by less is as good
_MAX_SWEEPS = 5000

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Shortest:
    """Chooses what leads to a marked state in the least expected time, each of ``through`` having happened.

    What has happened counts from the last visit of a marked state.  The plan is the Markov decision process
    over (supervisor state x, D ⊆ through), with a value V(x, D) in seconds; it serves any number of runs:

    * to start e takes its expected_s, one control period at least; with probability P = 1 − Π (1 − odds_u) one of
      the uncontrollable events u of x comes first, u in proportion to odds_u, and the choice is made anew.  A
      command is never interrupted;
    * to wait takes Σ w_u expected_s_u and u comes with w_u = odds_u / Σ odds, over the u of finite expected_s;
    * to end, in a marked state, costs 1000 s for each event of ``through`` that is missing.

    A marked state is also left again, but only for states from which it cannot be entered once more: where the
    supervisor remembers what was tried (the executor repeats nothing).  Value iteration from above, so that
    idle loops cost what they never gain: O(2^|through| |ξ|) per sweep.

    Raises ModelError if an event has no skill or no detector, UnknownName for an unknown event in ``through``,
    InputError for more than 8 of them or a supervisor too large to plan for.   [Bellman 1957; Puterman 1994, ch. 7]

    >>> from thenar.library.classics import small_factory
    >>> from thenar.runtime.driver import Detector, Skill
    >>> from thenar.synthesis.api import synthesize
    >>> supervisor = synthesize(small_factory()).supervisor
    >>> names = supervisor.automaton.alphabet
    >>> class Plain:
    ...     period_s = 0.001
    ...     skills = {e.name: Skill(e.name, "achievement", 1.0, 9.0) for e in names if e.controllable}
    ...     detectors = {e.name: Detector(e.name, 0.0, 2.0, 9.0) for e in names if not e.controllable}
    >>> policy = Shortest(supervisor, Plain(), through=["start_1"])
    >>> policy.choose(0, [names.index("start_1")], may_wait=False) == names.index("start_1")
    True
    """

    name = "shortest"
    __slots__ = ("_at", "_bits", "_cells", "_initial", "_process", "_start_s", "_value_s", "_wait_s", "sweeps")

    def __init__(self, supervisor: Supervisor, driver: Driver, *, through: Sequence[str] = ()) -> None:
        S = supervisor.automaton
        if supervisor.is_empty:
            raise InputError("there is nothing to plan: no supervisor exists for this problem")
        check_binding(S.alphabet, driver)
        goals = list(dict.fromkeys(S.alphabet.index(name) for name in through))
        if len(goals) > MAX_GOALS:
            raise InputError(f"a plan goes through at most {MAX_GOALS} events, not {len(goals)}")
        if S.n_transitions << len(goals) > MAX_TRANSITIONS:
            raise InputError(f"{S.n_transitions:,} transitions and {len(goals)} goal events are too many to plan for")
        self._bits = {e: 1 << k for k, e in enumerate(goals)}
        self._cells = unfold(supervisor, goals)
        self._process = _Process(self._cells, supervisor, driver, len(goals))
        self._value_s, self.sweeps = self._process.solve()
        self._start_s, self._wait_s = self._process.backup(self._value_s)
        self._initial = S.initial
        self.begin()

    def begin(self) -> None:
        """Forget the last run."""
        self._at = self._initial, 0

    def saw(self, event: int, state: int) -> None:
        """Keep count of the goal events since the last marked state."""
        before, done = self._at
        self._at = state, (0 if self._process.marks(before) else done) | self._bits.get(event, 0)

    def expected_s(self, state: int, done: Iterable[int] | None = None) -> float:
        """Return the expected time from ``state`` to the end, with the penalties for missed goal events.

        ``done`` are the goal events that have happened since the last marked state; by default, in this run.
        """
        subset = self._at[1] if done is None else sum(self._bits[e] for e in done)
        cell = self._cells.find(state, subset)
        onward = self._start_s[slice(*self._process.row(cell))]
        return float(min(self._wait_s[cell], self._process.end_s[cell], *onward))

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        """Return the choice of least expected time; of equal ones the first in the alphabet."""
        cell = self._cells.find(state, self._at[1])
        lo, hi = self._process.row(cell)
        row = zip(self._start_s[lo:hi].tolist(), self._process.event[lo:hi].tolist(), strict=True)
        times: list[tuple[float, int]] = [(time_s, event) for time_s, event in row if event in choices]
        if not times:
            return None
        bound = min(times)[0] * (1.0 + _TIE)
        if self._process.marks(state):
            if self._process.end_s[cell] <= bound:
                return None
        elif may_wait and self._wait_s[cell] * (1.0 + _TIE) < bound:
            return None
        return next(event for time_s, event in times if time_s <= bound)


class _Process:
    """The Markov decision process of :class:`Shortest` over cells: what is started, and what may come before."""

    def __init__(self, cells: Cells, supervisor: Supervisor, driver: Driver, n_goals: int) -> None:
        S = supervisor.automaton
        skills = [driver.skills.get(e.name) if e.controllable else None for e in S.alphabet]
        detectors = [None if e.controllable else driver.detectors.get(e.name) for e in S.alphabet]
        # at least a control period: where time is nothing, an idle round would be as good as the way on
        takes = np.array([max(s.expected_s, driver.period_s) if s else d.expected_s if d else 0.0
                          for s, d in zip(skills, detectors, strict=True)])  # fmt: skip
        races = np.array([s is not None and s.commit == "achievement" for s in skills])
        odds = np.array([min(d.odds, _MAX_ODDS) if d else 0.0 for d in detectors])

        self.n, self.marked = len(cells.state), S.marked
        is_marked = S.marked[cells.state]
        missing = n_goals - np.array([int(d).bit_count() for d in range(1 << n_goals)])
        #: (n,) seconds, what it costs to end in each cell
        self.end_s = np.where(is_marked, PENALTY_S * missing[cells.done], CAP_S)

        sensed = np.array([d is not None for d in detectors])[cells.event]
        owner, event = cells.source[sensed], cells.event[sensed]
        self.interrupts = _Draw(owner, event, cells.target[sensed], odds, self.n)
        interrupted = -np.expm1(np.bincount(owner, np.log1p(-odds[event]), minlength=self.n))

        comes = sensed & np.isfinite(takes)[cells.event]
        owner, event = cells.source[comes], cells.event[comes]
        self.awaited = _Draw(owner, event, cells.target[comes], odds, self.n)
        waits = np.bincount(owner, self.awaited.share * takes[event], minlength=self.n)
        can_wait = (np.bincount(owner, minlength=self.n) > 0) & ~is_marked
        self.wait_cost = np.where(can_wait, waits, CAP_S)

        started = np.array([s is not None for s in skills])[cells.event]
        self.source, self.event = cells.source[started], cells.event[started]
        self.next, self.rows = cells.target[started], _Rows.of(self.source)
        self.cost = takes[self.event]
        self.first = np.where(races[self.event], interrupted[self.source], 0.0)
        self.offsets = np.concatenate(([0], np.cumsum(np.bincount(self.source, minlength=self.n))))
        component = strong_components(S.offsets.tolist(), S.targets.tolist())
        from_x, to_x = cells.state[self.source], cells.state[self.next]
        self.again = np.where(S.marked[from_x] & (component[from_x] == component[to_x]), CAP_S, 0.0)

    def marks(self, state: int) -> bool:
        """Return whether the supervisor marks ``state``."""
        return bool(self.marked[state])

    def row(self, cell: int) -> tuple[int, int]:
        """Return where the events that can be started in ``cell`` begin and end."""
        return int(self.offsets[cell]), int(self.offsets[cell + 1])

    def backup(self, value: Floats) -> tuple[Floats, Floats]:
        """Return the time that it takes to start each event, and to wait in each cell."""
        after = value[self.next]
        interrupted = self.interrupts.mean(value)[self.source]
        return self.cost + after + self.first * (interrupted - after), self.wait_cost + self.awaited.mean(value)

    def solve(self) -> tuple[Floats, int]:
        """Return the value of each cell, and the number of sweeps that it took."""
        value, sweeps, settled = np.full(self.n, CAP_S), 0, False
        while not settled and sweeps < _MAX_SWEEPS:
            start, wait = self.backup(value)
            new = self.rows.reduce(np.minimum, start + self.again, np.minimum(wait, self.end_s))
            settled = bool((value - new <= _TOLERANCE * new).all())
            value, sweeps = new, sweeps + 1
        return value, sweeps


class _Draw:
    """Which of the uncontrollable events of a cell comes, each in proportion to its odds."""

    def __init__(self, owner: Ints, event: Ints, target: Ints, odds: Floats, n: int) -> None:
        self.n, self.target, self.rows = n, target, _Rows.of(owner)
        total = np.bincount(owner, odds[event], minlength=n)
        share = np.where(total[owner] > 0, odds[event], 1.0)
        #: the probability of each event, given that one of its cell comes
        self.share = share / np.bincount(owner, share, minlength=n)[owner]

    def mean(self, value: Floats) -> Floats:
        """Return the expected value after the draw in each cell; 0 where there is nothing to draw."""
        return self.rows.reduce(np.add, self.share * value[self.target], np.zeros(self.n))


@dataclass(frozen=True, slots=True)
class _Rows:
    """Where rows of equal owner begin; owners without a row have none here, for reduceat knows no empty rows."""

    owner: Ints
    start: Ints

    @classmethod
    def of(cls, owners: Ints) -> _Rows:
        """Return the rows of ``owners``, which rise."""
        owner, start = np.unique(owners, return_index=True)
        return cls(owner, start)

    def reduce(self, operation: np.ufunc, values: Floats, into: Floats) -> Floats:
        """Return ``into`` with each row's values reduced into its owner's place."""
        if len(self.start):
            into[self.owner] = operation(into[self.owner], operation.reduceat(values, self.start))
        return into
