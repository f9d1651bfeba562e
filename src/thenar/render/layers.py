"""The combinatorial half of a layered drawing: which layer a node lies in, and in which order.

Edges against the flow are turned round (they come back as edges that run upwards), nodes lie below all
their predecessors, and the order within the layers keeps crossings few.     [Sugiyama, Tagawa, Toda 1981]
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Iterator, Sequence
from math import fsum

__all__ = ["assign_layers", "reduce_crossings"]

Pair = tuple[int, int]

_PATIENCE = 4  # sweeps without fewer crossings before a search ends
_TURNED_COST = 3  # in layers: how much longer other edges may get to have one edge more with the flow


def assign_layers(n: int, edges: Sequence[Pair], root: int) -> list[int]:
    """Return a layer for each of ``n`` nodes, from 0 at the top, such that no edge stays within one layer.

    Depth-first search turns round few edges where a task has a flow, and none where there is no cycle;
    breadth-first search keeps the drawing of a dense graph shallow.  The cheaper is taken.  Time
    O(n + len(edges)).

    >>> assign_layers(4, [(0, 1), (1, 2), (2, 1), (2, 3), (3, 0)], root=0)
    [0, 1, 2, 3]
    """
    if not n:
        return []
    after: list[list[int]] = [[] for _ in range(n)]
    for u, v in edges:
        after[u].append(v)
    flowing = _layers_along(_depth_first(after, root), edges)
    if all(flowing[u] < flowing[v] for u, v in edges):
        return flowing
    shallow = _layers_along(_breadth_first(after, root), edges)
    return min(flowing, shallow, key=lambda layers: _cost(layers, edges))


def _cost(layers: list[int], edges: Sequence[Pair]) -> int:
    spans = (layers[v] - layers[u] for u, v in edges)
    return sum(span if span > 0 else _TURNED_COST - span for span in spans)


def _depth_first(after: list[list[int]], root: int) -> list[int]:
    """Return the nodes in reverse postorder: only an edge that closes a cycle of the search runs against it."""
    seen: set[int] = set()
    postorder: list[int] = []
    for start in (root, *range(len(after))):
        if start in seen:
            continue
        seen.add(start)
        stack = [(start, iter(after[start]))]
        while stack:
            u, successors = stack[-1]
            v = next((v for v in successors if v not in seen), None)
            if v is None:
                postorder.append(u)
                stack.pop()
            else:
                seen.add(v)
                stack.append((v, iter(after[v])))
    return postorder[::-1]


def _breadth_first(after: list[list[int]], root: int) -> list[int]:
    order: dict[int, None] = {}
    for start in (root, *range(len(after))):
        queue = [] if start in order else [start]
        order.update(dict.fromkeys(queue))
        for u in queue:
            fresh = [v for v in dict.fromkeys(after[u]) if v not in order]
            order.update(dict.fromkeys(fresh))
            queue += fresh
    return list(order)


def _layers_along(order: list[int], edges: Sequence[Pair]) -> list[int]:
    """Put each node one layer below the lowest of those that lead to it, then shorten long edges."""
    position = {u: k for k, u in enumerate(order)}
    above: list[list[int]] = [[] for _ in order]
    below: list[list[int]] = [[] for _ in order]
    pull = [0] * len(order)  # > 0 where moving down shortens more than it lengthens
    for u, v in edges:
        with_flow = position[u] < position[v]
        top, bottom = (u, v) if with_flow else (v, u)
        below[top].append(bottom)
        above[bottom].append(top)
        weight = 2 if with_flow else 1
        pull[top] += weight
        pull[bottom] -= weight
    layers = [0] * len(order)
    for u in order:
        layers[u] = max((layers[w] + 1 for w in above[u]), default=0)
    for u in reversed(order):
        if below[u] and pull[u] > 0:
            layers[u] = min(layers[w] for w in below[u]) - 1
    return layers


def reduce_crossings(rows: list[list[int]], segments: Sequence[Pair], rounds: int) -> list[list[int]]:
    """Reorder the vertices of each row so that few of the ``segments`` between adjacent rows cross.

    A segment is a pair (vertex, vertex one row below).  Barycentres and swaps of neighbours, ``rounds`` times
    down and up, from several first orders; the best order seen is returned.

    >>> reduce_crossings([[0, 1], [2, 3]], [(0, 3), (1, 2)], rounds=1)
    [[0, 1], [3, 2]]
    """
    n = sum(map(len, rows))
    up: list[list[int]] = [[] for _ in range(n)]
    down: list[list[int]] = [[] for _ in range(n)]
    for a, b in segments:
        down[a].append(b)
        up[b].append(a)
    best, fewest = rows, -1
    for first in _first_orders(rows, up, down):
        order, crossings = _improved(first, up, down, rounds)
        if crossings < fewest or fewest < 0:
            best, fewest = order, crossings
        if fewest == 0:
            break
    return best


def _first_orders(rows: list[list[int]], up: list[list[int]], down: list[list[int]]) -> Iterator[list[list[int]]]:
    """Yield orders in which searches meet the vertices: down and up, to the left and to the right first."""
    row_of = {v: r for r, row in enumerate(rows) for v in row}
    for neighbours, starts in ((down, rows), (up, rows[::-1])):
        for step in (1, -1):
            ordered: list[list[int]] = [[] for _ in rows]
            seen: set[int] = set()
            for start in (v for row in starts for v in row[::step]):
                stack = [start]
                while stack:
                    v = stack.pop()
                    if v not in seen:
                        seen.add(v)
                        ordered[row_of[v]].append(v)
                        stack += neighbours[v][::-step]
            yield ordered


def _improved(
    rows: list[list[int]], up: list[list[int]], down: list[list[int]], rounds: int
) -> tuple[list[list[int]], int]:
    """Return the best order found from ``rows`` on, and its crossings."""
    place = [0.0] * len(up)
    for row in rows:
        _number(row, place)
    best, fewest = [row[:] for row in rows], _crossings(rows, down, place)
    fruitless = 0
    for k in range(2 * rounds):
        if fewest == 0 or fruitless == _PATIENCE:
            break
        downwards = k % 2 == 0
        for row in rows if downwards else reversed(rows):
            _by_barycentre(row, up if downwards else down, place)
        for row in rows:
            _swap_neighbours(row, up, down, place)
        crossings = _crossings(rows, down, place)
        fruitless += 1
        if crossings < fewest:
            best, fewest, fruitless = [row[:] for row in rows], crossings, 0
    return best, fewest


def _number(row: list[int], place: list[float]) -> None:
    for k, v in enumerate(row):
        place[v] = float(k)


def _by_barycentre(row: list[int], fixed: list[list[int]], place: list[float]) -> None:
    wish = {v: fsum(place[w] for w in fixed[v]) / len(fixed[v]) if fixed[v] else place[v] for v in row}
    row.sort(key=lambda v: (wish[v], place[v]))
    _number(row, place)


def _swap_neighbours(row: list[int], up: list[list[int]], down: list[list[int]], place: list[float]) -> None:
    for k in range(len(row) - 1):
        a, b = row[k], row[k + 1]
        if _between(up[a], up[b], place) + _between(down[a], down[b], place) > 0:
            row[k], row[k + 1] = b, a
    _number(row, place)


def _between(left: list[int], right: list[int], place: list[float]) -> int:
    """Return how many crossings a swap of two neighbours with these other ends would save."""
    saved = 0
    for a in left:
        for b in right:
            saved += (place[a] > place[b]) - (place[a] < place[b])
    return saved


def _crossings(rows: list[list[int]], down: list[list[int]], place: list[float]) -> int:
    total = 0
    for row in rows:
        met: list[float] = []  # lower ends of the segments to the left, sorted
        for v in row:
            ends = [place[w] for w in down[v]]
            for end in ends:
                total += len(met) - bisect_right(met, end)
            for end in ends:
                insort(met, end)
    return total
