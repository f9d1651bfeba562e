"""The metric half of a layered drawing: an x for every vertex, long and important edges straight.

Vertices joined by a straight edge form a *column* and share one x.  Columns are drawn towards their
neighbours and kept apart, alternately, until they hardly move.
[alignment after Brandes, Köpf 2002; separation after Dwyer, Marriott, Stuckey 2006]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import fsum

__all__ = ["assign_x", "settle"]

Pair = tuple[int, int]

_WIDE_ENOUGH = 1200.0  # px; in a dense graph straight edges cost more room than they are worth:
_TOO_WIDE = 2.7  # times what the widest row needs
_DAMPING = 0.6  # < 1, or two columns that attract each other would trade places for ever


def assign_x(
    rows: Sequence[Sequence[int]],
    segments: Mapping[Pair, tuple[float, float]],
    gaps: Mapping[Pair, float],
    rounds: int,
) -> list[float]:
    """Return an x for each vertex in ``rows``, each row read from left to right.

    ``segments`` maps (vertex, vertex one row below) to its importance, the larger the sooner it becomes
    straight (at 0 never on purpose), and its stiffness, the larger the nearer its ends come.  ``gaps`` maps
    two neighbours in a row to the least distance between them.

    >>> assign_x([[0, 1], [2]], {(1, 2): (1, 1)}, {(0, 1): 10}, rounds=5)
    [0.0, 10.0, 10.0]
    """
    column = _columns(rows, {ab: s for ab, (s, _) in segments.items() if s > 0})
    order, places, apart = _first_places(rows, column, gaps)
    widest_row = max((fsum(gaps[ab] for ab in pairwise(row)) for row in rows), default=0.0)
    if max(places, default=0.0) - min(places, default=0.0) > max(_WIDE_ENOUGH, _TOO_WIDE * widest_row):
        column = list(range(len(column)))
        order, places, apart = _first_places(rows, column, gaps)
    pulls: dict[Pair, float] = {}
    for (a, b), (_, stiffness) in segments.items():
        if column[a] != column[b]:
            for key in ((column[a], column[b]), (column[b], column[a])):
                pulls[key] = pulls.get(key, 0.0) + stiffness
    weights = [0.01] * len(places)
    for (c, _), stiffness in pulls.items():
        weights[c] += stiffness
    for _ in range(rounds):
        wishes = [0.01 * x for x in places]
        for (c, d), stiffness in pulls.items():
            wishes[c] += stiffness * places[d]
        wishes = [x + _DAMPING * (wish / weight - x) for x, wish, weight in zip(places, wishes, weights, strict=True)]
        places = _keep_apart(order, wishes, weights, apart)
    return [places[c] for c in column]


def _first_places(
    rows: Sequence[Sequence[int]], column: Sequence[int], gaps: Mapping[Pair, float]
) -> tuple[list[int], list[float], dict[Pair, float]]:
    """Return the columns from left to right, a place for each, and the least distances between them."""
    apart: dict[Pair, float] = {}
    for row in rows:
        for a, b in pairwise(row):
            key = column[a], column[b]
            apart[key] = max(apart.get(key, 0.0), gaps[a, b])
    order = _left_to_right(max(column, default=-1) + 1, apart)
    return order, _between_extremes(order, apart), apart


def _columns(rows: Sequence[Sequence[int]], importance: Mapping[Pair, float]) -> list[int]:
    """Return the column of each vertex: the most important segments first, none across another one."""
    row_of = {v: r for r, row in enumerate(rows) for v in row}
    place = {v: k for row in rows for k, v in enumerate(row)}
    above: dict[int, int] = {}
    below: dict[int, int] = {}
    chosen: list[list[Pair]] = [[] for _ in rows]
    for a, b in sorted(importance, key=lambda ab: (-importance[ab], row_of[ab[0]], place[ab[0]], place[ab[1]])):
        if a in below or b in above:
            continue
        here = chosen[row_of[a]]
        if all((place[a] < i) == (place[b] < j) for i, j in here):
            here.append((place[a], place[b]))
            below[a], above[b] = b, a
    column = [-1] * len(row_of)
    count = 0
    for row in rows:
        for v in row:
            if v in above:
                column[v] = column[above[v]]
            else:
                column[v], count = count, count + 1
    return column


def _left_to_right(count: int, apart: Mapping[Pair, float]) -> list[int]:
    """Return the columns such that each comes after all those to its left."""
    after: list[list[int]] = [[] for _ in range(count)]
    waiting = [0] * count
    for c, d in apart:
        after[c].append(d)
        waiting[d] += 1
    order = [c for c in range(count) if not waiting[c]]
    for c in order:
        for d in after[c]:
            waiting[d] -= 1
            if not waiting[d]:
                order.append(d)
    return order


def _between_extremes(order: Sequence[int], apart: Mapping[Pair, float]) -> list[float]:
    """Return the mean of the leftmost and the rightmost placement, which keeps columns apart as they do."""
    before, after = _by_end(apart, len(order))
    leftmost, rightmost = [0.0] * len(order), [0.0] * len(order)
    for c in order:
        leftmost[c] = max((leftmost[b] + gap for b, gap in before[c]), default=0.0)
    width = max(leftmost, default=0.0)
    for c in reversed(order):
        rightmost[c] = min((rightmost[d] - gap for d, gap in after[c]), default=width)
    return [(a + b) / 2 for a, b in zip(leftmost, rightmost, strict=True)]


def _by_end(apart: Mapping[Pair, float], n: int) -> tuple[list[list[tuple[int, float]]], list[list[tuple[int, float]]]]:
    before: list[list[tuple[int, float]]] = [[] for _ in range(n)]
    after: list[list[tuple[int, float]]] = [[] for _ in range(n)]
    for (c, d), gap in apart.items():
        before[d].append((c, gap))
        after[c].append((d, gap))
    return before, after


def _keep_apart(
    order: Sequence[int], wishes: Sequence[float], weights: Sequence[float], apart: Mapping[Pair, float]
) -> list[float]:
    """Return places near ``wishes`` that keep every distance in ``apart``.

    From left to right; whatever presses on its left neighbour is glued to it, and the group moves to the
    weighted mean of its wishes.
    """
    before, _ = _by_end(apart, len(order))
    group_of = list(range(len(wishes)))
    offset = [0.0] * len(wishes)  # of a column within its group
    members = [[c] for c in range(len(wishes))]
    mass = list(weights)
    moment = [weight * wish for weight, wish in zip(weights, wishes, strict=True)]
    for c in order:
        g = group_of[c]
        while True:
            here = moment[g] / mass[g]
            worst, glue = 1e-6, None
            for d in members[g]:
                for b, gap in before[d]:
                    h = group_of[b]
                    if h != g:
                        short = moment[h] / mass[h] + offset[b] + gap - here - offset[d]
                        if short > worst:
                            worst, glue = short, (b, d, gap)
            if glue is None:
                break
            b, d, gap = glue
            h = group_of[b]
            shift = offset[d] - gap - offset[b]  # of the origin of group h within group g
            for m in members[h]:
                offset[m] += shift
                group_of[m] = g
            moment[g] += moment[h] - mass[h] * shift
            mass[g] += mass[h]
            members[g] += members[h]
    return [moment[g] / mass[g] + offset[c] for c, g in enumerate(group_of)]


def settle(wishes: Sequence[float], weights: Sequence[float], gaps: Sequence[float]) -> list[float]:
    """Return the places nearest to ``wishes`` (weighted least squares) that keep ``gaps`` between neighbours.

    ``gaps[i]`` separates place i from place i + 1.  Pooling adjacent violators, O(n).

    >>> settle([0, 0, 9], [1, 1, 1], [2, 2])
    [-1.0, 1.0, 9.0]
    """
    offsets = [0.0]
    for gap in gaps:
        offsets.append(offsets[-1] + gap)
    pools: list[tuple[float, float, int]] = []  # (mean, weight, members) of places pressed together
    for wish, weight, offset in zip(wishes, weights, offsets, strict=True):
        mean, total, members = wish - offset, weight, 1
        while pools and pools[-1][0] > mean:
            other, heavy, more = pools.pop()
            mean, total, members = (mean * total + other * heavy) / (total + heavy), total + heavy, members + more
        pools.append((mean, total, members))
    means = [mean for mean, _, members in pools for _ in range(members)]
    return [mean + offset for mean, offset in zip(means, offsets, strict=True)]
