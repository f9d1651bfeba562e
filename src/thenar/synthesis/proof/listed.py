"""The checker of certificates that list the states: a proof check in NumPy, for every state and event at once.

A certificate holds the automata of a problem; states of their product, each one a *survivor* or *removed* with a
reason and a rank; and the supervisor.  Checked is

* *legal*:        no survivor has an uncontrollable event that the plants can do and a specification forbids,
* *controllable*: every uncontrollable event that is possible in a survivor leads to a survivor,
* *nonblocking*:  every survivor is marked or has a transition to a survivor that is one step nearer to one,
* *largest*:      every removed state has a reason of lower rank: a specification broken by an uncontrollable
  event; an uncontrollable event to a removed state of lower rank; or not being marked, and having all its
  transitions to removed states that are of lower rank or are removed for this same reason at this same rank,
* *faithful*:     the supervisor is the survivors that can be reached from the initial state, with all the
  transitions between them.

By induction over the rank no removed state can be in any controllable, nonblocking subset, so what is left
is the largest.   [Ramadge and Wonham 1987]
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from thenar.synthesis.proof.container import Arrays, Automaton, Ints, Mask, Statement, Wrong, claim, ints, mask

__all__ = ["ListedStates"]

SURVIVES, ILLEGAL, UNCONTROLLABLE, BLOCKING = range(4)


class ListedStates:
    """What a certificate claims of a problem, state by state."""

    n_nodes = 0

    def __init__(self, problem: Statement, arrays: Arrays) -> None:
        self.problem, self.arrays = problem, arrays
        self.events, self.free = problem.events, problem.free
        self.plant = [a.plant for a in problem.automata]
        self.tables = [_table(a) for a in problem.automata]
        self.coords = ints(arrays, "coords", 2)
        self.reason, self.rank, self.way = (ints(arrays, n) for n in ("reason", "rank", "way"))
        n = len(self.coords)
        sizes = [len(t) for t in self.tables]
        claim(self.coords.shape[1] == len(sizes), "malformed: states without coordinates")
        claim(all(len(a) == n for a in (self.reason, self.rank, self.way)), "malformed: arrays of unequal length")
        claim(n > 0, "malformed: nothing to check")
        inside = (self.coords >= 0) & (self.coords < sizes)
        claim(bool(inside.all()), "a state has a component outside its automaton")
        claim(self.coords[0].tolist() == [a.initial for a in problem.automata], "state 0 is not the initial state")
        claim(bool(np.isin(self.reason, range(4)).all()), "malformed: unknown reason")
        self.index = _Rows(self.coords, sizes)
        self.alive = self.reason == SURVIVES
        self.marked = np.ones(n, np.bool_)
        for k, a in enumerate(problem.automata):
            self.marked &= a.marked[self.coords[:, k]]

    def check(self) -> None:
        """Go through the whole proof; raise Wrong at the first thing that is not so.  O(states x events)."""
        self.check_states()
        self.check_removed()
        self.check_survivors()
        self.check_supervisor()

    @property
    def sizes(self) -> tuple[int, int, int]:
        """States and transitions of the supervisor, and the states gone through."""
        return len(self.arrays["origin"]), len(self.arrays["sup_events"]), len(self.reason)

    def moves(self, event: int, states: Ints) -> tuple[Mask, Mask, Ints]:
        """Return for each of ``states``: can the plants do ``event``; may they; the state reached (-1: none listed)."""
        owners = [k for k, table in enumerate(self.tables) if table[0, event] != -2]
        can = np.full(len(states), bool(owners))  # an event that no automaton has never happens
        may = np.ones(len(states), np.bool_)
        changed: dict[int, tuple[Ints, Ints]] = {}  # of each owner, its state before and after
        for k in owners:
            before = self.coords[states, k]
            after = self.tables[k][before, event]
            ok = after != -1
            if self.plant[k]:
                can &= ok
            else:
                may &= ok
            changed[k] = before, after
        both = np.flatnonzero(can & may)
        reached = np.full(len(states), -1, np.int64)
        reached[both] = self.index.find(states[both], {k: (q[both], t[both]) for k, (q, t) in changed.items()})
        return can, may, reached

    def where(self, bad: Mask, states: Ints) -> str:
        """Name the first of ``states`` at which ``bad`` holds, if there is one."""
        if not bad.any():
            return ""
        x = int(states[np.argmax(bad)])
        return f"state {x} ({self.problem.state(self.coords[x].tolist())})"

    def check_states(self) -> None:
        """No state is listed twice, and ranks and reasons go together."""
        claim(self.index.distinct, "a state of the product is listed twice")
        claim(bool(((self.rank < 0) == self.alive).all()), "a survivor has a rank, or a removed state has none")

    def check_removed(self) -> None:
        """Every removed state has a reason of lower rank."""
        removed = np.flatnonzero(~self.alive)
        proved = np.zeros(len(removed), np.bool_)
        reason, rank = self.reason[removed], self.rank[removed]
        blocked = (reason == BLOCKING) & ~self.marked[removed]
        for e, free in enumerate(self.free):
            can, may, reached = self.moves(e, removed)
            inside = reached >= 0
            gone = inside & ~self.alive[reached]
            lower = gone & (self.rank[reached] < rank)
            if free:
                proved |= (reason == ILLEGAL) & can & ~may
                proved |= (reason == UNCONTROLLABLE) & lower
            same = gone & (self.rank[reached] == rank) & (self.reason[reached] == BLOCKING)
            blocked &= ~(can & may) | lower | same
        proved |= blocked
        if not proved.all():
            words = {
                ILLEGAL: "breaking a specification",
                UNCONTROLLABLE: "an uncontrollable event",
                BLOCKING: "blocking",
            }
            first = int(reason[np.argmin(proved)])
            raise Wrong(
                f"not largest: {self.where(~proved, removed)} was removed for {words[first]} without that being so"
            )

    def check_survivors(self) -> None:
        """The survivors are legal, controllable and nonblocking."""
        alive = np.flatnonzero(self.alive)
        nearer = self.marked[alive] & (self.way[alive] == 0)
        for e, free in enumerate(self.free):
            can, may, reached = self.moves(e, alive)
            lost = can & may & (reached < 0)
            claim(
                not lost.any(), f"{self.events[e]} leads from {self.where(lost, alive)} to a state that is not listed"
            )
            to_alive = (reached >= 0) & self.alive[reached]
            if free:
                broken, uncontrolled = can & ~may, can & may & ~to_alive
                name, breaks, leads = self.events[e], self.where(broken, alive), self.where(uncontrolled, alive)
                claim(not broken.any(), f"not within the specifications: {name} breaks one in {breaks}")
                claim(not uncontrolled.any(), f"not controllable: {name} leads from {leads} to a removed state")
            nearer |= to_alive & (self.way[reached] >= 0) & (self.way[reached] < self.way[alive])
        claim(
            bool(nearer.all()), f"not nonblocking: no way to a marked state is shown from {self.where(~nearer, alive)}"
        )

    def check_supervisor(self) -> None:
        """The supervisor is the reachable survivors with all transitions between them, and its marks are theirs."""
        names = ("origin", "sup_offsets", "sup_events", "sup_targets")
        origin, offsets, events, targets = (ints(self.arrays, name) for name in names)
        marked = mask(self.arrays, "sup_marked")
        n = len(origin)
        if not self.alive[0]:
            empty = n == len(events) == len(targets) == len(marked) == 0
            claim(empty, "the initial state is removed, but the supervisor is not empty")
            return
        claim(n > 0 and origin[0] == 0, "the supervisor does not begin in the initial state")
        claim(
            bool(((origin >= 0) & (origin < len(self.reason))).all()), "the supervisor has a state that is not listed"
        )
        claim(len(np.unique(origin)) == n, "two states of the supervisor are the same")
        gone = ~self.alive[origin]
        claim(not gone.any(), f"the supervisor enters {self.where(gone, origin)}, a removed state")
        claim(np.array_equal(marked, self.marked[origin]), "the supervisor marks other states")
        claim(
            len(offsets) == n + 1 and offsets[0] == 0 and bool((np.diff(offsets) >= 0).all()), "malformed: supervisor"
        )
        claim(len(events) == len(targets) == offsets[-1], "malformed: supervisor")
        claim(
            bool(((targets >= 0) & (targets < n) & (events >= 0) & (events < len(self.events))).all()),
            "malformed: supervisor",
        )
        source = np.repeat(np.arange(n), np.diff(offsets))
        total = 0
        for e, name in enumerate(self.events):
            _, _, reached = self.moves(e, origin)
            expected = np.where((reached >= 0) & self.alive[reached], reached, -1)
            mine = events == e
            stated = np.full(n, -1, np.int64)
            stated[source[mine]] = origin[targets[mine]]
            wrong = stated != expected
            claim(not wrong.any(), f"the supervisor is wrong about {name} in {self.where(wrong, origin)}")
            total += int((expected >= 0).sum())
        claim(total == len(events), "the supervisor lists a transition twice")
        entered = np.full(n, n, np.int64)
        np.minimum.at(entered, targets, source)
        # numbered breadth-first: each state is entered from one with a smaller number, so all are reachable
        claim(bool((entered[1:] < np.arange(1, n)).all()), "the supervisor has a state that is never entered")


def _table(automaton: Automaton) -> Ints:
    """Return (n_states, n_events) int64: target, -1 undefined, -2 not in the alphabet."""
    table = np.full((len(automaton.marked), len(automaton.own)), -2, np.int64)
    table[:, automaton.own] = -1
    table[automaton.source, automaton.events] = automaton.targets
    return table


class _Rows:
    """Finds rows of small integers in a table by a key of one integer each, where that does not overflow."""

    def __init__(self, rows: Ints, sizes: list[int]) -> None:
        self.rows, self.sizes = rows, sizes
        self.strides: list[int] | None = []
        self.folds: list[Ints | None] = []
        key, span = np.zeros(len(rows), np.int64), 1
        for column, size in enumerate(sizes):
            if span * size >= 1 << 62:  # rank the keys so far; look-ups then go through every column
                known, key = np.unique(key, return_inverse=True)
                self.folds.append(known)
                self.strides = None
                span = len(known)
            else:
                self.folds.append(None)
            key, span = key * size + rows[:, column], span * size
        if self.strides is not None:
            self.strides = [math.prod(sizes[k + 1 :]) for k in range(len(sizes))]
        self.key = key
        self.order = np.argsort(key, kind="stable")
        self.sorted = key[self.order]
        self.distinct = bool((np.diff(self.sorted) > 0).all())
        self.place: NDArray[np.int32] | None = None
        if span <= 16 * len(rows):  # then a table is smaller than what is checked anyway, and quicker than a search
            self.place = np.full(span, -1, np.int32)
            self.place[key] = np.arange(len(rows))

    def find(self, states: Ints, changed: Mapping[int, tuple[Ints, Ints]]) -> Ints:
        """Return the number of each of ``states`` with the columns ``changed`` (from, to); -1: not there."""
        known_so_far = np.ones(len(states), np.bool_)
        if self.strides is not None:
            key = self.key[states]
            for column, (before, after) in changed.items():
                key += (after - before) * self.strides[column]
        else:
            key = np.zeros(len(states), np.int64)
            for column, (size, known) in enumerate(zip(self.sizes, self.folds, strict=True)):
                if known is not None:
                    place = np.minimum(np.searchsorted(known, key), len(known) - 1)
                    known_so_far &= known[place] == key
                    key = place
                value = changed[column][1] if column in changed else self.rows[states, column]
                key = key * size + value
        if self.place is not None:
            return self.place[key].astype(np.int64)
        place = np.minimum(np.searchsorted(self.sorted, key), len(self.sorted) - 1)
        return np.where(known_so_far & (self.sorted[place] == key), self.order[place], -1)
