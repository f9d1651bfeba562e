"""Values that a variable may have, as predicates of Waters: its ranges have no gaps, conditions say them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby

from thenar.io.foreign.waters.say import binary, number, simple
from thenar.model.expressions import Value

__all__ = ["among", "in_no_gap"]


def among(name: str, chosen: Sequence[Value], domain: Sequence[Value]) -> list[str]:
    """Return a predicate that is true for the ``chosen`` values, none if these are all in between.

    ``name`` is the element of the variable that has the values ``domain``.
    """
    if not chosen:
        return [number(0)]
    if isinstance(domain[0], str):
        some = [binary("==", name, simple(str(x))) for x in chosen]
        return [] if set(chosen) == set(domain) else [binary("|", *some)]
    runs = _runs(map(int, chosen))
    if runs == [(min(map(int, domain)), max(map(int, domain)))]:
        return []
    return [binary("|", *(_between(name, low, high) for low, high in runs))]


def in_no_gap(value: str, domain: Sequence[Value]) -> list[str]:
    """Return a guard that keeps the element ``value`` out of the gaps between numbers of ``domain``, if it has any."""
    if isinstance(domain[0], (str, bool)):
        return []
    runs = _runs(map(int, domain))
    return [] if len(runs) == 1 else [binary("|", *(_between(value, low, high) for low, high in runs))]


def _between(value: str, low: int, high: int) -> str:
    if low == high:
        return binary("==", value, number(low))
    return binary("&", binary(">=", value, number(low)), binary("<=", value, number(high)))


def _runs(numbers: Iterable[int]) -> list[tuple[int, int]]:
    """Return the first and last of each run of numbers that follow one another."""
    runs = []
    for _, group in groupby(enumerate(sorted(numbers)), key=lambda item: item[1] - item[0]):
        run = [n for _, n in group]
        runs.append((run[0], run[-1]))
    return runs
