"""Linear systems x = c + P x of absorbing Markov chains, sparse, with nothing but NumPy."""

from __future__ import annotations

import math
from dataclasses import dataclass
from heapq import heapify, heappop, heappush

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel

__all__ = ["ROUNDING", "System", "weighed"]

ROUNDING = 16 * float(np.finfo(np.float64).eps)  # relative, of a sum of a few products
_DENSE = 200  # unknowns; a table of them takes some ten milliseconds
_FEW_SWEEPS = 64  # of conjugate gradients; mostly they are enough
_MAX_SWEEPS = 1000
_PATHS = 8  # times the entries: so many paths through what is taken out, and a chain stays sparse
_ACCEPTED = 1e-6  # relative error by rounding; beyond it sums that cancel are not trusted
_SMALL = 1e-100  # a row that leads on with less is scaled, long before it is nothing

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class System:
    """The system x = cost + P x with P[row, column] = share; column -1 is where the chain ends, and x is 0.

    ``cost``, (n,), is 0 or more.  The solution is infinite in rows from which the chain may never end, and where it is
    above 1.8e308.

    >>> system = System(np.array([0, 0, 1]), np.array([0, 1, -1]), np.array([0.5, 0.5, 1.0]), np.array([1.0, 3.0]))
    >>> system.solve(np.zeros(2), np.ones(2), 1e-9, kernel.Ticker())[0].tolist()
    [5.0, 3.0]
    """

    row: Ints
    column: Ints
    share: Floats
    cost: Floats

    def solve(self, guess: Floats, unit: Floats, tolerance: float, tick: kernel.Ticker) -> tuple[Floats, float]:
        """Return the solution, and how far it may be off, relative, where each row costs its ``unit`` at least.

        Up to 200 unknowns by elimination in a table, O(n³).  Beyond by stabilised biconjugate gradients, O(entries) a
        sweep, if a few sweeps come within ``tolerance`` or what rounding allows, 1e-6 at most; by elimination if the
        chain stays sparse; else by many sweeps, or by elimination after all.  Of elimination the error is an estimate,
        16 n eps: what can be proven is the square of n times more.
        """
        rounding = len(self.cost) * ROUNDING
        if len(self.cost) <= _DENSE:
            return self._tabulated(), rounding
        found = self._gradients(guess, unit, tolerance, _FEW_SWEEPS, tick)
        if found is not None:
            return found
        x = self._eliminated(tick, _PATHS * len(self.row))
        if x is not None:
            return x, rounding
        found = self._gradients(guess, unit, tolerance, _MAX_SWEEPS, tick)
        return found if found is not None else (self.eliminate(tick), rounding)

    def eliminate(self, tick: kernel.Ticker) -> Floats:
        """Return the solution by taking one state after the other out of the chain, that with the fewest paths first.

        Nothing is subtracted, so nothing cancels: each number is right to its last digits.  O(n) for chains and
        trees; where every state leads to many others, up to O(n³).   [Grassmann, Taksar and Heyman 1985; Markowitz
        1957]

        >>> steps = System(np.array([0, 1, 1]), np.array([1, 0, -1]), np.array([1, 0.5, 0.5]), np.ones(2))
        >>> steps.eliminate(kernel.Ticker()).tolist()
        [4.0, 3.0]
        """
        x = self._eliminated(tick, math.inf)
        assert x is not None
        return x

    def _eliminated(self, tick: kernel.Ticker, most: float) -> Floats | None:
        """Return what :meth:`eliminate` returns, None if that leads along more than ``most`` paths."""
        n, cost = len(self.cost), self.cost.tolist()
        leads: list[dict[int, float]] = [{} for _ in range(n)]
        enters: list[set[int]] = [set() for _ in range(n)]
        ends = [0.0] * n
        for i, j, p in zip(self.row.tolist(), self.column.tolist(), self.share.tolist(), strict=True):
            if j < 0:
                ends[i] += p
            elif i != j:  # to stay is to be asked again: what counts is in which proportion it goes on
                leads[i][j] = leads[i].get(j, 0.0) + p
                enters[j].add(i)
        heap = [(len(leads[k]) * len(enters[k]), k) for k in range(n)]
        heapify(heap)
        order: list[int] = []
        gone, taken = [False] * n, 0
        onward = [0.0] * n  # what leads from a state to others that are left
        while heap:
            paths, k = heappop(heap)
            if gone[k]:
                continue
            if paths < len(leads[k]) * len(enters[k]):
                heappush(heap, (len(leads[k]) * len(enters[k]), k))
                continue
            if len(order) % 256 == 0:
                tick.look(n, taken)
            taken += paths
            if taken > most:
                return None
            gone[k] = True
            order.append(k)
            onward[k] = sum(leads[k].values()) + ends[k]
            for j in leads[k]:
                enters[j].discard(k)
            for i in enters[k]:
                there = leads[i]
                share = there.pop(k)
                if not share:
                    continue
                if not onward[k]:
                    cost[i] = math.inf
                    continue
                share /= onward[k]
                for j, p in leads[k].items():
                    if i != j:
                        there[j] = there.get(j, 0.0) + share * p
                        enters[j].add(i)
                ends[i] += share * ends[k]
                cost[i] += share * cost[k]
                if i in leads[k] and 0.0 < (rest := sum(there.values()) + ends[i]) < _SMALL:
                    leads[i] = {j: p / rest for j, p in there.items()}
                    ends[i] /= rest
                    cost[i] /= rest
        x = [math.inf] * n
        for k in reversed(order):
            if onward[k]:
                x[k] = (cost[k] + sum(p * x[j] for j, p in leads[k].items() if p)) / onward[k]
        return np.array(x)

    def _tabulated(self) -> Floats:
        """Return what :meth:`eliminate` returns, from a table with a row for each state, in their order."""
        n, x = len(self.cost), self.cost.astype(np.float64)
        table = np.zeros((n, n + 1))  # where the chain ends is column 0, state k column k + 1
        np.add.at(table, (self.row, self.column + 1), self.share)
        table[np.arange(n), np.arange(n) + 1] = 0.0
        onward = np.empty(n)
        with np.errstate(over="ignore", under="ignore"):
            for k in range(n - 1, -1, -1):
                onward[k] = table[k, : k + 1].sum()
                into = np.flatnonzero(table[:k, k + 1])
                if not onward[k]:
                    x[into] = np.inf
                    continue
                share = table[into, k + 1] / onward[k]
                rows = table[into, : k + 1] + np.outer(share, table[k, : k + 1])
                rows[np.arange(len(into)), into + 1] = 0.0
                x[into] += weighed(share, x[k])
                rest = rows.sum(axis=1)
                rest[(rest == 0.0) | (rest >= _SMALL)] = 1.0
                table[into, : k + 1] = rows / rest[:, None]
                x[into] /= rest
            for k in range(n):
                sum_ = x[k] + weighed(table[k, 1 : k + 1], x[:k]).sum()
                x[k] = sum_ / onward[k] if onward[k] else np.inf
        return x

    def _gradients(
        self, guess: Floats, unit: Floats, tolerance: float, sweeps: int, tick: kernel.Ticker
    ) -> tuple[Floats, float] | None:
        """Return ``guess`` as biconjugate gradients improve it, and its error, ``tolerance`` or what rounding leaves.

        None if they do not come near, or rounding leaves more than 1e-6.

        [van der Vorst 1992]
        """
        n, inside = len(self.cost), self.column >= 0
        row, column, share = self.row[inside], self.column[inside], self.share[inside]
        scale = 1.0 / (0.1 * tolerance * unit)  # residuals are weighed by what is allowed of them

        def times(y: Floats) -> Floats:
            return y - np.bincount(row, share * y[column], minlength=n)

        with np.errstate(all="ignore"):  # when they break down, numbers overflow: no number is near
            x = np.where(np.isfinite(guess), guess, 0.0)
            r = (self.cost - times(x)) * scale
            shadow, p, rho = r.copy(), r.copy(), r @ r
            for sweep in range(sweeps):
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
            off, rounding = np.abs(self.cost - times(x)), ROUNDING * np.abs(x)
            error = float(((off + rounding) / unit).max())
        return (x, error) if error <= _ACCEPTED and (off <= np.maximum(tolerance * unit, rounding)).all() else None


def weighed(share: Floats, values: Floats | float) -> Floats:
    """Return ``share`` times ``values``: nothing where the share is, be the value infinite."""
    product: Floats = np.zeros(np.shape(share))
    np.multiply(share, values, out=product, where=share > 0)
    return product
