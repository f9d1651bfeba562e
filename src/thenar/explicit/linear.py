"""Linear systems x = c + P x of absorbing Markov chains, sparse, with nothing but NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heapify, heappop, heappush

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel

__all__ = ["ROUNDING", "System"]

ROUNDING = 16 * float(np.finfo(np.float64).eps)  # relative, of a sum of a few products
_DENSE = 400  # unknowns; a dense system of them takes milliseconds
_MAX_SWEEPS = 1000  # of conjugate gradients; where they work, a hundred are enough

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class System:
    """The system x = cost + P x with P[row, column] = share; column -1 is where the chain ends, and x is 0.

    From each row the chain must end with probability 1.

    >>> System(np.array([0, 0, 1]), np.array([0, 1, -1]), np.array([0.5, 0.5, 1.0]), np.array([1.0, 3.0])).solve(
    ...     np.zeros(2), np.full(2, 1e-9), kernel.Ticker()).tolist()
    [5.0, 3.0]
    """

    row: Ints
    column: Ints
    share: Floats
    cost: Floats

    def solve(self, guess: Floats, allowed: Floats, tick: kernel.Ticker) -> Floats:
        """Return the solution; its residual is ``allowed``, or no more than rounding.

        Up to 400 unknowns directly; beyond by stabilised biconjugate gradients, O(entries) a sweep, or, where they
        do not come near in 1000 sweeps, by elimination: no chain of states, however long, is hard for it.
        """
        n = len(self.cost)
        inside = self.column >= 0
        row, column, share = self.row[inside], self.column[inside], self.share[inside]
        if n <= _DENSE:
            matrix = np.eye(n)
            np.subtract.at(matrix, (row, column), share)
            return np.asarray(np.linalg.solve(matrix, self.cost), np.float64)
        found = _gradients(row, column, share, self.cost, guess, allowed, tick)
        return self.eliminate(tick) if found is None else found

    def eliminate(self, tick: kernel.Ticker) -> Floats:
        """Return the solution by taking one state after the other out of the chain, that with the fewest paths first.

        Nothing is subtracted, so nothing cancels: each number is right to its last digits.  O(n) for chains and
        trees; where every state leads to many others, up to O(n³).   [Grassmann, Taksar and Heyman 1985; Markowitz
        1957]

        >>> steps = System(np.array([0, 1, 1]), np.array([1, 0, -1]), np.array([1, 0.5, 0.5]), np.ones(2))
        >>> steps.eliminate(kernel.Ticker()).tolist()
        [4.0, 3.0]
        """
        n, cost = len(self.cost), self.cost.tolist()
        leads: list[dict[int, float]] = [{} for _ in range(n)]
        enters: list[set[int]] = [set() for _ in range(n)]
        ends = [0.0] * n
        for i, j, p in zip(self.row.tolist(), self.column.tolist(), self.share.tolist(), strict=True):
            if j < 0:
                ends[i] += p
            else:
                leads[i][j] = leads[i].get(j, 0.0) + p
                enters[j].add(i)
        heap = [(len(leads[k]) * len(enters[k]), k) for k in range(n)]
        heapify(heap)
        order: list[int] = []
        gone, entries = [False] * n, len(self.row)
        onward = [0.0] * n  # the probability to leave a state for another one that is left
        while heap:
            paths, k = heappop(heap)
            if gone[k]:
                continue
            if paths < len(leads[k]) * len(enters[k]):
                heappush(heap, (len(leads[k]) * len(enters[k]), k))
                continue
            if len(order) % 256 == 0:
                tick.look(n, entries)
            gone[k] = True
            order.append(k)
            leads[k].pop(k, None)
            enters[k].discard(k)
            onward[k] = sum(leads[k].values()) + ends[k]
            for j in leads[k]:
                enters[j].discard(k)
            for i in enters[k]:
                there = leads[i]
                share = there.pop(k) / onward[k]
                for j, p in leads[k].items():
                    there[j] = there.get(j, 0.0) + share * p
                    enters[j].add(i)
                ends[i] += share * ends[k]
                cost[i] += share * cost[k]
            entries += len(leads[k]) * len(enters[k])
        x = [0.0] * n
        for k in reversed(order):
            x[k] = (cost[k] + sum(p * x[j] for j, p in leads[k].items())) / onward[k]
        return np.array(x)


def _gradients(
    row: Ints, column: Ints, share: Floats, cost: Floats, x: Floats, allowed: Floats, tick: kernel.Ticker
) -> Floats | None:
    """Return ``x`` as biconjugate gradients improve it; None if they do not come near.   [van der Vorst 1992]"""
    n, scale = len(cost), 1.0 / allowed  # residuals are weighed by what is allowed of them

    def times(y: Floats) -> Floats:
        return y - np.bincount(row, share * y[column], minlength=n)

    def is_solved() -> bool:
        return bool((np.abs(cost - times(x)) <= np.maximum(allowed, ROUNDING * np.abs(x))).all())

    r = (cost - times(x)) * scale
    shadow, p, rho = r.copy(), r.copy(), r @ r
    with np.errstate(all="ignore"):  # when they break down, numbers overflow: no number is near
        for sweep in range(_MAX_SWEEPS):
            if np.abs(r).max() <= 1.0:
                break
            if sweep % 64 == 0:
                tick.look(n, len(row))
            v = times(p / scale) * scale
            alpha = rho / (shadow @ v)
            s = r - alpha * v
            t = times(s / scale) * scale
            omega = (t @ s) / (t @ t)
            x = x + (alpha * p + omega * s) / scale
            r = s - omega * t
            next_rho = shadow @ r
            p = r + (next_rho / rho) * (alpha / omega) * (p - omega * v)
            rho = next_rho
            if not np.isfinite(rho):
                return None
        return x if is_solved() else None
