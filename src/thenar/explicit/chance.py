"""Expected costs: what it costs on average to reach a marked state when chance decides which event comes first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.explicit.cost import CostToGo, settle, settled_choices
from thenar.explicit.linear import ROUNDING, System, weighed
from thenar.explicit.rows import bytemask, kept, sources
from thenar.model.automaton import Automaton

__all__ = ["TOLERANCE", "expected_cost"]

TOLERANCE = 1e-9  # relative, of an expected cost
_AS_GOOD = 1e-8  # relative; choices whose expected costs differ by less are as good
_WAIT = -1  # the move that starts nothing
_MOST = 1e290  # that a way seems to cost: below it all ways can be told from no way, and be added up
_DISCOUNT = 1e-9  # the chance to be done after each event, where policies without it cost more than numbers can say

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


def expected_cost(automaton: Automaton, price: Floats, odds: Floats, tick: kernel.Ticker) -> CostToGo:
    """Return the least expected cost of the way from each state to a marked one: a stochastic shortest path.

    ``price`` and ``odds`` are (n_events,) float64, cost and weight of each event.  In state q, U being the
    uncontrollable events with a weight,

    * to wait costs w(q) = Σ odds(u) v(u) / Σ odds(u) over u ∈ U, infinite if U is empty
    * to start e costs b v(e) + (1 - b) w(q) with b = odds(e) / (odds(e) + Σ odds(u)); b = 1 if U is empty.

    The value is the least cost among the policies that reach a marked state with probability 1, and infinite
    where no policy does.  First the states with such a policy are found, by backward search, O(|δ|) a round; then the
    policy that takes a cheapest way, each step repeated until it succeeds, O(|δ| log |Q|), is improved until no move
    is better (policy iteration); :mod:`thenar.explicit.linear` solves the systems of equations.  Mostly a hundred
    sweeps of O(|δ|) in all, far more where chance goes in long circles.

    The ``error`` is a bound by Bellman's equation: how much the values, or the moves that were not taken, may be off,
    as a share of the least cost of a move (an event of cost 0 counted as the cheapest other one).  It is 1e-9, or what
    rounding allows: with values that are 1e6 times a move it may be 1e-8.  A value above 1.8e308 is infinite.

    [Bertsekas and Tsitsiklis, Mathematics of Operations Research 16(3), 1991; de Alfaro 1997 for probability 1]

    >>> coin = Automaton.from_transitions(["toss -throw-> air -heads-> done", "air -tails-> toss"], initial="toss",
    ...     marked=["done"], uncontrollable=["heads", "tails"])
    >>> from thenar.explicit.cost import cost_to_go
    >>> cost_to_go(coin, {"heads": 0, "tails": 0}, case="expected").value
    2.0
    """
    process = _Process.of(automaton, price, odds)
    sure = _almost_sure(process, tick)
    values = np.where(automaton.marked, 0.0, np.inf)
    here = np.flatnonzero(sure & ~automaton.marked)
    error, nearer = 0.0, np.zeros(automaton.n_transitions, np.bool_)
    if len(here):
        solver = _Improvement(process, sure, tick)
        error = solver.run()
        values[here] = solver.value[here]
        nearer = solver.nearer()
    return CostToGo(automaton, "expected", values, *settled_choices(automaton, nearer, values), error)


@dataclass(frozen=True, slots=True)
class _Process:
    """The Markov decision process of a closed loop: what is drawn in each state, and what can be started.

    * ``drawn``: (m,) transitions of unmarked states by uncontrollable events with a weight, ``share`` their
      probabilities if nothing is started, ``from_`` and ``to`` the states, ``cost`` what the events cost
    * ``started``: (k,) transitions of unmarked states by controllable events, ``first`` and ``rest`` (k,) the
      probabilities that the event comes before all others, and that another one does; ``certain`` where none can
    * ``fee``: (k,) what the events started cost

    A probability below 1e-308 is 0, though what it is of can happen.
    """

    automaton: Automaton
    drawn: Ints
    from_: Ints
    to: Ints
    share: Floats
    cost: Floats
    exposed: Mask
    started: Ints
    source: Ints
    target: Ints
    first: Floats
    rest: Floats
    certain: Mask
    fee: Floats

    @classmethod
    def of(cls, a: Automaton, price: Floats, odds: Floats) -> _Process:
        """Read the process off an automaton."""
        source, events, targets = sources(a), a.events, a.targets.astype(np.int64)
        free = a.alphabet.uncontrollable[events] if len(events) else np.zeros(0, np.bool_)
        open_ = ~a.marked[source]
        drawn = np.flatnonzero(open_ & free & (odds[events] > 0))
        # as shares of the largest of the state: so sums do not overflow, and their order does not matter
        largest = np.zeros(a.n_states)
        np.maximum.at(largest, source[drawn], odds[events[drawn]])
        share = odds[events[drawn]] / largest[source[drawn]]
        total = np.bincount(source[drawn], share, minlength=a.n_states)
        started = np.flatnonzero(open_ & ~free)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            ratio = odds[events[started]] / largest[source[started]] / total[source[started]]
            certain = np.isinf(odds[events[started]]) | (total[source[started]] == 0)
            first = np.where(certain, 1.0, np.where(ratio < 1.0, ratio / (1.0 + ratio), 1.0 / (1.0 + 1.0 / ratio)))
            rest = np.where(certain, 0.0, 1.0 / (1.0 + ratio))  # not 1 - first, which cancels
        return cls(
            a, drawn, source[drawn], targets[drawn], share / total[source[drawn]], price[events[drawn]], total > 0,
            started, source[started], targets[started], first, rest, certain, price[events[started]],
        )  # fmt: skip

    def mean(self, values: Floats) -> Floats:
        """Return (n,) the mean over what is drawn in each state of ``values``, one for each drawn transition."""
        n = self.automaton.n_states
        return np.asarray(np.bincount(self.from_, weighed(self.share, values), minlength=n), np.float64)

    def within(self, states: Mask) -> tuple[Mask, Mask]:
        """Return where one may wait, and which events may be started, so that nothing leads out of ``states``."""
        safe = states.copy()
        safe[self.from_[~states[self.to]]] = False
        return safe & self.exposed, states[self.source] & states[self.target] & (safe[self.source] | self.certain)

    def usable(self, may_wait: Mask, may_start: Mask) -> Mask:
        """Return (n_transitions,) which may be taken then."""
        usable = np.zeros(self.automaton.n_transitions, np.bool_)
        usable[self.drawn[may_wait[self.from_]]] = True
        usable[self.started[may_start]] = True
        return usable


def _almost_sure(process: _Process, tick: kernel.Ticker) -> Mask:
    """Return the states from which some policy reaches a marked state with probability 1.

    From a set of states those moves are safe that cannot leave it; the states from which a marked one cannot be
    reached by safe moves are taken out, until none is.
    """
    a = process.automaton
    alive = np.ones(a.n_states, np.bool_)
    while True:
        tick.look(a.n_states, a.n_transitions)
        part = kept(a, process.usable(*process.within(alive)))
        reaching = kernel.distance_to(part.offsets, part.events, part.targets, bytemask(a.marked), tick) >= 0
        if reaching[alive].all():
            return alive
        alive &= reaching


class _Improvement:
    """Policy iteration on the states that are ``sure``; ``policy`` holds a place in ``started``, or _WAIT, for each."""

    def __init__(self, process: _Process, sure: Mask, tick: kernel.Ticker) -> None:
        p = self.process = process
        self.tick = tick
        self.here = sure & ~p.automaton.marked
        self.states = np.flatnonzero(self.here)
        self.may_wait, self.may_start = p.within(sure)
        self.may_wait &= self.here
        #: what it costs until the next event: to wait in each state, to start each event
        self.idle = p.mean(p.cost)
        self.stage = p.first * p.fee + p.rest * self.idle[p.source]
        cheap = np.concatenate((p.cost[p.cost > 0], p.fee[p.fee > 0]))
        floor = float(cheap.min()) if len(cheap) else 1.0
        #: (n,) the least cost of a move that is allowed, an event of cost 0 counted as the cheapest other one
        self.unit = np.where(self.may_wait, np.maximum(self.idle, floor), np.inf)
        np.minimum.at(self.unit, p.source[self.may_start], np.maximum(self.stage, floor)[self.may_start])
        self.unit[~self.here] = floor
        self.value = np.zeros(p.automaton.n_states)
        self.policy = self._cheapest_ways()

    def run(self) -> float:
        """Improve the policy until no other is better; return the error that is left, relative."""
        error = self._evaluate()
        if np.isinf(self.value).any():
            self._moderate()
            error = self._evaluate()
        return self._error(self._improve(error))

    def nearer(self) -> Mask:
        """Return (n_transitions,) which transitions belong to a move of least cost."""
        p = self.process
        start, wait = self._moves()
        # less than the cost of the event itself, and no event without a cost: so no idle cycle is ever as good
        slack = np.minimum(_AS_GOOD * self.value[p.source], self.stage / 2)
        best = (start <= self.value[p.source] + slack) & (self.stage > 0) & np.isfinite(start)
        slack = np.minimum(_AS_GOOD * self.value, self.idle / 2)
        waits = self.here & (self.policy == _WAIT)
        waits |= (wait <= self.value + slack) & (self.idle > 0) & np.isfinite(wait)
        nearer = np.zeros(p.automaton.n_transitions, np.bool_)
        nearer[p.started[best | self._taken()]] = True
        nearer[p.drawn[waits[p.from_]]] = True
        return nearer

    def _cheapest_ways(self) -> Ints:
        """Return the policy that goes a cheapest way, where each move costs as much as it does until it succeeds.

        In each state it comes nearer with some probability, and so to a marked state with probability 1.
        """
        p, a = self.process, self.process.automaton
        paid = np.full(a.n_transitions, _MOST)
        for places, fee, chance in ((p.drawn, self.idle[p.from_], p.share), (p.started, self.stage, p.first)):
            with np.errstate(all="ignore"):
                paid[places] = np.where(chance > 0, np.minimum(fee / chance, _MOST), _MOST)
        counts = p.usable(self.may_wait, self.may_start)
        value, steps = settle(a, a.marked, paid, counts, False, self.tick)
        source = sources(a)
        onward = counts & (steps[a.targets] == steps[source] - 1) & (value[a.targets] + paid == value[source])
        policy = np.full(a.n_states, _WAIT)
        chosen = np.flatnonzero(onward[p.started])[::-1]
        policy[p.source[chosen]] = chosen  # of several the first
        return policy

    def _improve(self, error: float, discount: float = 0.0) -> float:
        """Improve the policy, whose value is known within ``error``; return the error of the value of the last one.

        A rise of values is rounding: each round must bring one below all that it was before, or is the last.
        """
        p, lowest = self.process, self.value.copy()
        while True:
            self.tick.look(p.automaton.n_states, p.automaton.n_transitions)
            start, wait = self._moves(discount)
            best = wait.copy()
            np.minimum.at(best, p.source, start)
            slack = np.maximum(TOLERANCE * self.unit, ROUNDING * np.minimum(self.value, _MOST))
            better = self.here & (best < self.value - slack)
            if not better.any():
                return error
            # only strictly better moves: the policy keeps reaching a marked state with probability 1
            self.policy[better] = _WAIT
            choice = np.flatnonzero(better[p.source] & (start == best[p.source]) & (start < wait[p.source]))[::-1]
            self.policy[p.source[choice]] = choice
            error = self._evaluate(discount)
            if not (self.value < lowest - slack / 2).any():
                return error
            lowest = np.minimum(lowest, self.value)

    def _moderate(self) -> None:
        """Change a policy whose cost is above all numbers for the best one of those that may be done after each event.

        Only where that one reaches a marked state at a cost that is a number: there it leads to such states only.
        """
        before = self.policy.copy()
        self._evaluate(_DISCOUNT)
        self._improve(0.0, _DISCOUNT)
        lost = self.states[np.isinf(self._system().eliminate(self.tick))]
        self.policy[lost] = before[lost]

    def _error(self, known: float) -> float:
        """Return a bound on the relative error of values that are those of the policy within ``known``.

        Either they satisfy Bellman's equation, with the rounding of one step; or they are those of a policy, and no
        move that it does not take is better than they are, with their own rounding.
        """
        p = self.process
        start, wait = self._moves()
        best, other = wait.copy(), np.where(self.policy == _WAIT, np.inf, wait)
        np.minimum.at(best, p.source, start)
        np.minimum.at(other, p.source, np.where(self._taken(), np.inf, start))
        finite = self.here & np.isfinite(self.value)
        value, best, other, unit = (x[finite] for x in (self.value, best, other, self.unit))
        blur = known + ROUNDING
        as_equation = (np.abs(value - best) + ROUNDING * value) / unit
        as_policy = np.maximum(value * (1.0 + blur) - other * (1.0 - blur), 0.0) / unit
        return float(min(as_equation.max(initial=0.0), known + as_policy.max(initial=0.0)))

    def _taken(self) -> Mask:
        """Return (k,) which of the events that can be started the policy starts."""
        p = self.process
        return np.asarray(self.policy[p.source] == np.arange(len(p.source)), np.bool_)

    def _moves(self, discount: float = 0.0) -> tuple[Floats, Floats]:
        """Return what it costs to start each event, and to wait in each state; infinite if it is not allowed."""
        p, value = self.process, (1.0 - discount) * self.value
        wait = p.mean(p.cost + value[p.to])
        start = weighed(p.first, p.fee + value[p.target]) + weighed(p.rest, wait[p.source])
        return np.where(self.may_start, start, np.inf), np.where(self.may_wait, wait, np.inf)

    def _evaluate(self, discount: float = 0.0) -> float:
        """Make ``value`` that of the policy, and return its relative error."""
        system = self._system(discount)
        unit = self.unit[self.states]
        self.value[self.states], error = system.solve(self.value[self.states], unit, TOLERANCE, self.tick)
        return error

    def _system(self, discount: float = 0.0) -> System:
        """Return the equations V = c + P V of the policy."""
        p, states, n = self.process, self.states, len(self.states)
        number = np.full(p.automaton.n_states, -1)
        number[states] = np.arange(n)
        begun = np.flatnonzero(self.policy[states] != _WAIT)
        events = self.policy[states[begun]]
        rest, cost = np.ones(n), self.idle[states]
        rest[begun], cost[begun] = p.rest[events], self.stage[events]
        drawn = number[p.from_] >= 0
        row = number[p.from_[drawn]]
        done = np.arange(n if discount else 0)
        share = np.concatenate((p.share[drawn] * rest[row], p.first[events])) * (1.0 - discount)
        row = np.concatenate((row, begun, done))
        column = np.concatenate((number[p.to[drawn]], number[p.target[events]], np.full(len(done), -1)))
        share = np.concatenate((share, np.full(len(done), discount)))
        comes = share > 0
        return System(row[comes], column[comes], share[comes], cost)
