"""The order of the levels: parts that depend on each other stand together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import InputError, did_you_mean

__all__ = ["METHODS", "find_order"]

METHODS = ("auto", "model", "force", "cuthill_mckee", "sloan", "dissection")
"""How to order: the best of all, as the model lists them, or one heuristic."""


AS_GOOD = 1.05  # the cost of an order over that of another that says little about which one is better


def find_order(
    n: int, edges: Iterable[Sequence[int]], method: str, tick: kernel.Ticker
) -> tuple[NDArray[np.uint32], bool]:
    """Return an order of 0 .. n - 1, the top level first, in which each of ``edges`` spans few places.

    Beside it whether its reverse costs about the same, so that only trying both can tell which one is better.

    Every heuristic but ``"model"`` is followed by a sliding window; ``"auto"`` takes, of all orders found and
    their reverses, the one of least weighted event span (Siminiceanu and Ciardo 2006).  The same input gives
    the same order.  Raises InputError for an unknown method.
    """
    if method not in METHODS:
        raise InputError(f"unknown order {method!r}{did_you_mean(method, METHODS)}; there are: {', '.join(METHODS)}")
    start = np.arange(n, dtype=np.uint32)
    if method == "model" or n < 2:
        return start, False
    kept = list(dict.fromkeys(tuple(sorted(set(e))) for e in edges))
    kept = [e for e in kept if len(e) > 1]
    offsets = np.cumsum([0, *map(len, kept)], dtype=np.int64)
    members = np.array([v for e in kept for v in e], np.uint32)

    def run(how: str, given: NDArray[np.uint32]) -> tuple[NDArray[np.uint32], float, float]:
        return kernel.order(n, offsets, members, how, given, tick)

    names = METHODS[2:] if method == "auto" else (method,)
    found = [run(how, start)[0] for how in names]
    if method == "auto":
        found += [run("force", order)[0] for order in found[1:]]
    found = [run("sliding_window", order)[0] for order in found]
    if method == "auto":
        found.append(start)
    both = [np.ascontiguousarray(x) for order in found for x in (order, order[::-1])]
    costs = [run("", order)[2] for order in both]
    best = int(np.argmin(costs))
    return both[best], costs[best ^ 1] <= AS_GOOD * costs[best]
