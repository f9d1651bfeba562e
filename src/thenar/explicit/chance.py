"""Expected costs: what it costs on average to reach a marked state when chance decides which event comes first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.explicit.cost import CostToGo, settled_choices
from thenar.explicit.linear import ROUNDING, System
from thenar.explicit.rows import bytemask, kept, sources
from thenar.model.automaton import Automaton

__all__ = ["TOLERANCE", "expected_cost"]

TOLERANCE = 1e-9  # relative, of an expected cost
TIE = 1e-8  # relative; choices whose expected costs differ by less are as good
WAIT = -1  # the move that starts nothing
_MAX_ROUNDS = 1000  # of policy iteration; some ten are usual

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
    where no policy does.  First the states with such a policy are found, by backward search, O(|δ|) a round; one of
    these policies is then improved until no move is better (policy iteration); :mod:`thenar.explicit.linear` solves
    the systems of equations.  Mostly a hundred sweeps of O(|δ|) in all, far more where chance goes in long circles.

    The result satisfies Bellman's equation but for a share ``error`` of the least cost of a move, so its values are
    right within that share (an event of cost 0 counted as the cheapest other one): 1e-9, or what rounding allows.

    [Bertsekas and Tsitsiklis, Mathematics of Operations Research 16(3), 1991; de Alfaro 1997 for probability 1]

    >>> coin = Automaton.from_transitions(["toss -throw-> air -heads-> done", "air -tails-> toss"], initial="toss",
    ...     marked=["done"], uncontrollable=["heads", "tails"])
    >>> from thenar.explicit.cost import cost_to_go
    >>> cost_to_go(coin, {"heads": 0, "tails": 0}, case="expected").value
    2.0
    """
    process = _Process.of(automaton, price, odds)
    policy, sure = _almost_sure(process, tick)
    values = np.where(automaton.marked, 0.0, np.inf)
    here = np.flatnonzero(sure & ~automaton.marked)
    error, nearer = 0.0, np.zeros(automaton.n_transitions, np.bool_)
    if len(here):
        solver = _Improvement(process, sure, policy, tick)
        error = solver.run()
        values[here] = solver.value[here]
        nearer = solver.nearer()
    return CostToGo(automaton, "expected", values, *settled_choices(automaton, nearer, values), error)


@dataclass(frozen=True, slots=True)
class _Process:
    """The Markov decision process of a closed loop: what is drawn in each state, and what can be started.

    * ``drawn``: (m,) transitions of unmarked states by uncontrollable events with a weight, ``share`` their
      probabilities if nothing is started, ``from_`` and ``to`` the states
    * ``started``: (k,) transitions of unmarked states by controllable events, ``first`` (k,) the probability
      that the event comes before all others
    * ``cost``: (m,) of the drawn ones, ``fee``: (k,) of the started ones
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
    fee: Floats

    @classmethod
    def of(cls, a: Automaton, price: Floats, odds: Floats) -> _Process:
        """Read the process off an automaton."""
        source, events, targets = sources(a), a.events, a.targets.astype(np.int64)
        free = a.alphabet.uncontrollable[events] if len(events) else np.zeros(0, np.bool_)
        open_ = ~a.marked[source]
        drawn = np.flatnonzero(open_ & free & (odds[events] > 0))
        total = np.bincount(source[drawn], odds[events[drawn]], minlength=a.n_states)
        started = np.flatnonzero(open_ & ~free)
        weight, against = odds[events[started]], total[source[started]]
        alone = np.isinf(weight) | (against == 0)
        first = np.where(alone, 1.0, weight / np.where(alone, 1.0, weight + against))
        share = odds[events[drawn]] / total[source[drawn]]
        return cls(
            a, drawn, source[drawn], targets[drawn], share, price[events[drawn]], total > 0,
            started, source[started], targets[started], first, price[events[started]],
        )  # fmt: skip

    def mean(self, values: Floats) -> Floats:
        """Return (n,) the mean over what is drawn in each state of ``values``, one for each drawn transition."""
        return np.asarray(np.bincount(self.from_, self.share * values, minlength=self.automaton.n_states), np.float64)


def _almost_sure(process: _Process, tick: kernel.Ticker) -> tuple[Ints, Mask]:
    """Return a policy, and the states from which it reaches a marked state with probability 1: as many as any does.

    From a set of states those moves are safe that cannot leave it; the states from which a marked one cannot be
    reached by safe moves are taken out, until none is.
    """
    p, a = process, process.automaton
    alive = np.ones(a.n_states, np.bool_)
    while True:
        tick.look(a.n_states, a.n_transitions)
        safe = np.ones(a.n_states, np.bool_)
        safe[p.from_[~alive[p.to]]] = False
        fine = alive[p.target] & (safe[p.source] | (p.first == 1.0)) & alive[p.source]
        usable = np.zeros(a.n_transitions, np.bool_)
        usable[p.drawn[safe[p.from_] & alive[p.from_]]] = True
        usable[p.started[fine]] = True
        part = kept(a, usable)
        distance = kernel.distance_to(part.offsets, part.events, part.targets, bytemask(a.marked), tick)
        reaching = distance >= 0
        if (reaching & alive).sum() == alive.sum():
            break
        alive &= reaching
    # a policy that comes nearer with some probability in each state comes there with probability 1
    policy = np.full(a.n_states, WAIT)
    onward = np.flatnonzero(fine & (distance[p.target] < distance[p.source]))[::-1]
    drawn_nearer = np.zeros(a.n_states, np.bool_)
    drawn_nearer[p.from_[safe[p.from_] & (distance[p.to] < distance[p.from_])]] = True
    onward = onward[~drawn_nearer[p.source[onward]]]
    policy[p.source[onward]] = onward  # of several the first
    return policy, alive


class _Improvement:
    """Policy iteration from a policy that reaches a marked state from all ``sure`` states."""

    def __init__(self, process: _Process, sure: Mask, policy: Ints, tick: kernel.Ticker) -> None:
        p = self.process = process
        n = p.automaton.n_states
        self.tick, self.policy = tick, policy
        self.here = sure & ~p.automaton.marked
        safe = np.ones(n, np.bool_)
        safe[p.from_[~sure[p.to]]] = False
        self.may_wait = p.exposed & safe & self.here
        self.may_start = self.here[p.source] & sure[p.target] & (safe[p.source] | (p.first == 1.0))
        #: what it costs until the next event: to wait in each state, to start each event
        self.idle = p.mean(p.cost)
        self.stage = p.first * p.fee + (1.0 - p.first) * self.idle[p.source]
        cheap = np.concatenate((p.cost[p.cost > 0], p.fee[p.fee > 0]))
        floor = float(cheap.min()) if len(cheap) else 1.0
        #: (n,) the least cost of a move that is allowed, an event of cost 0 counted as the cheapest other one
        self.unit = np.where(self.may_wait, np.maximum(self.idle, floor), np.inf)
        np.minimum.at(self.unit, p.source[self.may_start], np.maximum(self.stage, floor)[self.may_start])
        self.unit[~self.here] = floor
        self.value = np.zeros(n)

    def run(self) -> float:
        """Improve the policy until no other is better; return the error that is left, relative."""
        p, states = self.process, np.flatnonzero(self.here)
        for _ in range(_MAX_ROUNDS):
            self.tick.look(p.automaton.n_states, p.automaton.n_transitions)
            self._evaluate(states)
            start, wait = self._moves()
            best = wait.copy()
            np.minimum.at(best, p.source, start)
            slack = np.maximum(TOLERANCE * self.unit, ROUNDING * self.value)
            better = self.here & (best < self.value - slack)
            if not better.any():
                break
            # only strictly better moves: the policy keeps reaching a marked state with probability 1
            self.policy[better] = WAIT
            choice = np.flatnonzero(better[p.source] & (start == best[p.source]) & (start < wait[p.source]))[::-1]
            self.policy[p.source[choice]] = choice
        off = np.abs(self.value - best)[states] / self.unit[states]
        return float(off.max())

    def nearer(self) -> Mask:
        """Return (n_transitions,) which transitions belong to a move of least cost."""
        p = self.process
        start, wait = self._moves()
        mine = self.policy[p.source] == np.arange(len(p.source))
        # less than the cost of the event itself, and no event without a cost: so no idle cycle is ever as good
        slack = np.minimum(TIE * self.value[p.source], self.stage / 2)
        best = (start <= self.value[p.source] + slack) & (self.stage > 0) & np.isfinite(start)
        slack = np.minimum(TIE * self.value, self.idle / 2)
        waits = self.here & (self.policy == WAIT)
        waits |= (wait <= self.value + slack) & (self.idle > 0) & np.isfinite(wait)
        nearer = np.zeros(p.automaton.n_transitions, np.bool_)
        nearer[p.started[best | mine]] = True
        nearer[p.drawn[waits[p.from_]]] = True
        return nearer

    def _moves(self) -> tuple[Floats, Floats]:
        """Return what it costs to start each event, and to wait in each state; infinite if it is not allowed."""
        p = self.process
        wait = p.mean(p.cost + self.value[p.to])
        start = p.first * (p.fee + self.value[p.target]) + (1.0 - p.first) * wait[p.source]
        return np.where(self.may_start, start, np.inf), np.where(self.may_wait, wait, np.inf)

    def _evaluate(self, states: Ints) -> None:
        """Solve V = c + P V for the policy, on ``states``."""
        p, n = self.process, self.process.automaton.n_states
        number = np.full(n, -1)
        number[states] = np.arange(len(states))
        started = self.policy[states]
        starts = started != WAIT
        first = np.where(starts, p.first[started], 0.0) if len(p.first) else np.zeros(len(states))
        # what is drawn, where it is not certain that the event started comes first
        drawn = number[p.from_] >= 0
        row, column = number[p.from_[drawn]], number[p.to[drawn]]
        share = p.share[drawn] * (1.0 - first[row])
        chosen = np.flatnonzero(starts)
        row = np.concatenate((row, chosen))
        column = np.concatenate((column, number[p.target[started[chosen]]]))
        share = np.concatenate((share, first[chosen]))
        cost = np.where(starts, self.stage[started], self.idle[states]) if len(p.first) else self.idle[states]
        comes = share > 0
        system = System(row[comes], column[comes], share[comes], cost)
        self.value[states] = system.solve(self.value[states], 0.1 * TOLERANCE * self.unit[states], self.tick)
