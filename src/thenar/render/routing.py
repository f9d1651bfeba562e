"""The lines of a layered drawing: where they meet the nodes, and on which track they run sideways.

A line runs straight down a row and turns only in the gap between two rows.  There, lines that go sideways
over the same stretch run on tracks of their own, in an order in which lines need not cross twice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import fsum

from thenar.render.columns import settle
from thenar.render.geometry import HEAD, Box, Point, Route, label_size, recess, straight
from thenar.render.grid import ENTRY, HANGER, LABEL_OFFSET, PORT_GAP, Grid, Hanger
from thenar.render.scene import Scene

__all__ = ["TRACK", "Wire", "assign_tracks", "enter", "find_ports", "hang", "route"]

Wire = tuple[float, float]  # x at the upper and at the lower end of a line that crosses a gap
Ports = Mapping[tuple[int, int], float]

# All lengths in px.
PORT_INSET = 6.0  # from the end of a node's side
TRACK = 6.0  # between two tracks
CORNER = 7.0  # radius of a turn

_CIRCLE = 0.5523  # control points of a quarter circle, as a part of its radius


# -- sideways --------------------------------------------------------------------------------------------------


def assign_tracks(wires: Sequence[Wire]) -> dict[Wire, int]:
    """Return a track, from 0 at the top, for each of ``wires`` that goes sideways far enough to need one.

    Of two lines to the right the right one is higher, of two to the left the left one; then they cross only
    if their ends say so.  Time O(n²).

    >>> assign_tracks([(0, 50), (10, 60), (5, 6)])
    {(10, 60): 0, (0, 50): 1}
    """
    sideways = [wire for wire in dict.fromkeys(wires) if abs(wire[1] - wire[0]) >= 2 * CORNER]
    rightwards = sorted((w for w in sideways if w[0] < w[1]), reverse=True)
    leftwards = sorted(w for w in sideways if w[0] > w[1])
    tracks: dict[Wire, int] = {}
    for group in (rightwards, leftwards):
        for k, wire in enumerate(group):
            near = {tracks[other] for other in tracks if _meet(wire, other)}
            track = max((tracks[other] + 1 for other in group[:k] if _meet(wire, other)), default=0)
            while track in near:
                track += 1
            tracks[wire] = track
    return tracks


def _meet(a: Wire, b: Wire) -> bool:
    return min(a) < max(b) + TRACK and min(b) < max(a) + TRACK


# -- at the nodes ----------------------------------------------------------------------------------------------


def find_ports(grid: Grid) -> dict[tuple[int, int], float]:
    """Return, for each (state, next vertex), the x at which the line meets the state."""
    sides: dict[tuple[int, bool], list[int]] = {}
    for a, b in grid.segments:
        for v, w in ((a, b), (b, a)):
            if v < len(grid.states):
                sides.setdefault((v, v == a), []).append(w)
    ports: dict[tuple[int, int], float] = {}
    for (v, _), others in sides.items():
        others.sort(key=lambda w: grid.vertices[w].x)
        x = grid.vertices[v].x
        spread = _spread([grid.vertices[w].x - x for w in others], grid.sizes[v][0] / 2 - PORT_INSET)
        ports.update({(v, w): x + dx for w, dx in zip(others, spread, strict=True)})
    return ports


def _spread(wishes: Sequence[float], reach: float) -> list[float]:
    """Return where lines that come from ``wishes`` meet a side, at most ``reach`` from its middle."""
    n = len(wishes)
    middle = next((i for i, wish in enumerate(wishes) if abs(wish) < 0.5), None)  # that line is straight: it stays
    if middle is None:
        gaps = [min(PORT_GAP, 2 * reach / max(1, n - 1))] * (n - 1)
    else:
        gaps = [min(PORT_GAP, reach / max(1, middle))] * middle
        gaps += [min(PORT_GAP, reach / max(1, n - 1 - middle))] * (n - 1 - middle)
    weights = [1e6 if i == middle else 1.0 for i in range(n)]
    places = settle([min(reach, max(-reach, wish)) for wish in wishes], weights, gaps)
    # what was pressed together may stick out: push it back in
    return [round(min(reach - fsum(gaps[i:]), max(fsum(gaps[:i]) - reach, x)), 3) for i, x in enumerate(places)]


def enter(box: Box) -> Route:
    """Return the small arrow into an initial state."""
    return Route(straight((box.left - ENTRY, box.y), (box.left - HEAD, box.y)), (box.left, box.y))


# -- whole ways ------------------------------------------------------------------------------------------------


def route(
    scene: Scene,
    grid: Grid,
    k: int,
    boxes: Sequence[Box],
    ports: Ports,
    tops: Sequence[float],
    bottoms: Sequence[float],
    track_y: Mapping[tuple[int, Wire], float],
) -> Route:
    """Return the way of edge ``k``: down (or up) its chain of vertices, from one row to the next."""
    chain = grid.chains[k]
    source, target = boxes[chain[0]], boxes[chain[-1]]
    down = grid.vertices[chain[0]].row < grid.vertices[chain[-1]].row
    side = 1.0 if down else -1.0
    xs = [ports[chain[0], chain[1]], *(grid.vertices[v].x for v in chain[1:-1]), ports[chain[-1], chain[-2]]]
    tip = (xs[-1], target.y - side * (target.height / 2 - recess(xs[-1] - target.x, target.width / 2)))

    points = [(xs[0], source.y + side * (source.height / 2 - recess(xs[0] - source.x, source.width / 2)))]
    for (a, x0), (b, x1) in pairwise(zip(chain, xs, strict=True)):
        row, next_row = grid.vertices[a].row, grid.vertices[b].row
        leave, arrive = (bottoms[row], tops[next_row]) if down else (tops[row], bottoms[next_row])
        wire = (min(row, next_row), (x0, x1) if down else (x1, x0))
        _run(points, leave)
        _cross_gap(points, (x1, arrive), track_y.get(wire))
    _run(points, tip[1] - side * HEAD)

    edge = scene.edges[k]
    label = None
    if edge.labels:
        vertex = grid.vertices[chain[1]]
        width, height = label_size(edge)
        label = Box(vertex.x + LABEL_OFFSET + width / 2, (tops[vertex.row] + bottoms[vertex.row]) / 2, width, height)
    return Route(tuple(points), tip, label)


def _run(points: list[Point], y: float) -> None:
    """Go straight up or down to ``y``."""
    if abs(points[-1][1] - y) > 0.01:
        points += straight(points[-1], (points[-1][0], y))[1:]


def _cross_gap(points: list[Point], end: Point, track: float | None) -> None:
    (x0, y0), (x1, y1) = points[-1], end
    if abs(x1 - x0) < 0.01:
        _run(points, y1)
    elif track is None:
        middle = (y0 + y1) / 2
        points += [(x0, middle), (x1, middle), end]
    else:
        sx, sy = (1.0 if x1 > x0 else -1.0), (1.0 if y1 > y0 else -1.0)
        r0, r1 = min(CORNER, abs(track - y0)), min(CORNER, abs(y1 - track))
        _run(points, track - sy * r0)
        rest = 1 - _CIRCLE
        turned = (x0 + sx * r0, track)
        points += [(x0, track - sy * rest * r0), (x0 + sx * rest * r0, track), turned]
        points += straight(turned, (x1 - sx * r1, track))[1:]
        points += [(x1 - sx * rest * r1, track), (x1, track + sy * rest * r1), (x1, track + sy * r1)]
        _run(points, y1)


def hang(scene: Scene, hanger: Hanger, box: Box) -> tuple[Route, Box | None]:
    """Return the way of a self-loop or loose end on the state at ``box``, and the box of the loose end."""
    edge = scene.edges[hanger.edge]
    y = box.y + hanger.dy
    aim = max(7.0 - box.height / 2, min(box.height / 2 - 7.0, hanger.dy))  # where on the side of the node
    far = box.right + HANGER
    width, height = label_size(edge)
    label = Box(far + width / 2, y, width, height) if edge.labels else None

    def side(dy: float) -> Point:
        return box.right - recess(dy, box.height / 2), box.y + dy

    if hanger.end is None:
        start, tip = side(aim - 5.0), side(aim + 5.0)
        base = (tip[0] + 0.95 * HEAD, tip[1] + 0.3 * HEAD)
        return Route((start, (far, y - 15.0), (far, y + 18.0), base), tip, label), None
    if not hanger.outwards:
        tip = (box.left + recess(hanger.dy, box.height / 2), y)
        start = (box.left - HANGER + 4.0, y)
        return Route(straight(start, (tip[0] - HEAD, y)), tip), Box(start[0] - 8.0, y, 14.0, 14.0)
    end = (far - 6.0, y)
    if scene.nodes[hanger.end].kind == "disabled":
        return Route(straight(side(aim), end), None, label), Box(end[0], y, 0.0, 14.0)
    if label:
        label = Box(label.x + 14.0, y, width, height)
    return Route(straight(side(aim), (end[0] - HEAD, y)), end, label), Box(end[0] + 9.0, y, 14.0, 14.0)
