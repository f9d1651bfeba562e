"""Our own layout: layers from top to bottom, labels between them, lines that never cross a label."""

from __future__ import annotations

from itertools import pairwise

from thenar.render.columns import assign_x
from thenar.render.geometry import Box, Layout
from thenar.render.grid import Grid, build_grid
from thenar.render.layers import reduce_crossings
from thenar.render.routing import TRACK, Wire, assign_tracks, enter, find_ports, hang, route
from thenar.render.scene import Scene

__all__ = ["layered"]

# All lengths in px.
MARGIN = 8.0
GAP = 14.0  # between neighbours in a row
STEM = 9.0  # above and below the nodes, where edges run straight: room for arrow heads and ticks
ROW_GAP = 12.0  # between rows that no line crosses sideways
TRACKS_HEIGHT = 60.0  # at most, for the lines that run sideways between two rows

_EFFORT = 3000  # vertex visits for each of crossing reduction and placement, whatever the size


def layered(scene: Scene) -> Layout:
    """Lay out ``scene`` from top to bottom; the same scene always comes out the same.

    Work is bounded: some 5 ms for a task of 20 states, 20 ms for 30 states with three transitions each.

    >>> from thenar.model.automaton import Automaton
    >>> from thenar.render.scene import scene
    >>> chain = Automaton.from_transitions(["a -x-> b -y-> c -z-> a"], initial="a")
    >>> a, b, c = layered(scene(chain)).boxes
    >>> a.bottom < b.top and b.bottom < c.top
    True
    """
    grid = build_grid(scene)
    effort = max(2, min(12, _EFFORT // max(1, len(grid.vertices))))
    grid.rows = reduce_crossings(grid.rows, list(grid.segments), effort)
    _place_vertices(grid, effort)
    ports = find_ports(grid)
    tops, bottoms, track_y = _place_rows(grid, ports)

    at = []
    for vertex, size in zip(grid.vertices, grid.sizes, strict=False):
        at.append(Box(vertex.x, (tops[vertex.row] + bottoms[vertex.row]) / 2, *size))
    boxes = dict(zip(grid.states, at, strict=True))
    routes = {k: route(scene, grid, k, at, ports, tops, bottoms, track_y) for k in grid.chains}
    for box, group in zip(at, grid.hangers, strict=True):
        for hanger in group:
            routes[hanger.edge], loose_end = hang(scene, hanger, box)
            if hanger.end is not None and loose_end is not None:
                boxes[hanger.end] = loose_end
    entries = [enter(boxes[k]) for k in grid.states if scene.nodes[k].initial]
    return Layout(
        width=MARGIN + max((v.x + v.right for v in grid.vertices), default=0.0),
        height=2 * MARGIN if not bottoms else bottoms[-1] - STEM + MARGIN,
        boxes=tuple(boxes[k] for k in range(len(scene.nodes))),
        routes=tuple(routes[k] for k in range(len(scene.edges))),
        entry=entries[0] if entries else None,
        engine="own",
    )


def _place_vertices(grid: Grid, rounds: int) -> None:
    vertices = grid.vertices
    gaps = {(a, b): vertices[a].right + GAP + vertices[b].left for row in grid.rows for a, b in pairwise(row)}
    places = assign_x(grid.rows, grid.segments, gaps, rounds)
    shift = MARGIN - min((x - vertex.left for x, vertex in zip(places, vertices, strict=True)), default=0.0)
    for x, vertex in zip(places, vertices, strict=True):
        vertex.x = x + shift


def _place_rows(
    grid: Grid, ports: dict[tuple[int, int], float]
) -> tuple[list[float], list[float], dict[tuple[int, Wire], float]]:
    """Return the top and the bottom of each row, and the y of each track in the gaps between them."""
    wires: list[list[Wire]] = [[] for _ in grid.rows]
    for a, b in grid.segments:
        ends = ports.get((a, b), grid.vertices[a].x), ports.get((b, a), grid.vertices[b].x)
        wires[grid.vertices[a].row].append(ends)
    tops: list[float] = []
    bottoms: list[float] = []
    track_y: dict[tuple[int, Wire], float] = {}
    y = MARGIN - STEM
    for r, row in enumerate(grid.rows):
        tops.append(y)
        y += max(grid.vertices[v].height for v in row) + 2 * STEM * (r % 2 == 0)
        bottoms.append(y)
        tracks = assign_tracks(wires[r])
        count = 1 + max(tracks.values(), default=-1)
        spacing = min(TRACK, TRACKS_HEIGHT / max(1, count))
        track_y |= {(r, wire): y + ROW_GAP / 2 + spacing * (track + 0.5) for wire, track in tracks.items()}
        y += ROW_GAP + spacing * count
    return tops, bottoms, track_y
