"""The skeleton of a layered drawing: rows of nodes, labels and passing edges, before anything has a place.

Rows alternate: nodes, then the labels of the edges between them, then nodes again.  Whatever an edge passes
it passes as a vertex of its own in that row, so the order and the spacing within the rows keep everything
apart, and edges turn only in the gaps between the rows.  Edges that come from afar to the same node share
the last part of their way.  Self-loops and loose ends hang on the side of their node.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import fsum

from thenar.render.geometry import label_size, node_size
from thenar.render.layers import assign_layers
from thenar.render.scene import Scene

__all__ = ["ENTRY", "HANGER", "LABEL_OFFSET", "PORT_GAP", "Grid", "Hanger", "Vertex", "build_grid"]

# All lengths in px.
HANGER = 26.0  # from a node to the label of what hangs on it
HANGER_GAP = 5.0
CUT_WIDTH = 14.0  # of the "…" at a loose end
ENTRY = 20.0  # length of the small arrow into the initial state
PORT_GAP = 11.0  # between the ends of two edges at a node
MOST_PORTS = 12  # more lines than these move closer together
LABEL_OFFSET = 5.0  # from an edge to its label

_LONG = 1e6  # importance of keeping long edges straight: above that of anything else


@dataclass(slots=True)
class Vertex:
    """A node, a label or a passing edge at ``x`` in a row; it needs ``left`` and ``right`` on either side."""

    row: int
    left: float
    right: float
    height: float
    thin: bool = False
    x: float = 0.0


@dataclass(slots=True)
class Hanger:
    """A self-loop or a loose end at the side of a node, ``dy`` below its centre."""

    edge: int
    end: int | None  # the node at the loose end
    outwards: bool
    width: float
    height: float
    dy: float = 0.0


@dataclass(slots=True)
class Grid:
    """Vertices in rows; the first ones are the ``states``, positions in the scene's nodes.

    ``sizes`` are those of the states: wide enough for their text and for the lines that meet them.
    ``chains`` has for each edge between states the vertices along its way, ``segments`` for each two of them
    one above the other what :func:`assign_x` needs, ``hangers`` for each state what hangs on it.
    """

    states: list[int]
    sizes: list[tuple[float, float]] = field(default_factory=list)
    vertices: list[Vertex] = field(default_factory=list)
    rows: list[list[int]] = field(default_factory=list)
    chains: dict[int, list[int]] = field(default_factory=dict)
    segments: dict[tuple[int, int], tuple[float, float]] = field(default_factory=dict)
    hangers: list[list[Hanger]] = field(default_factory=list)

    def add(self, row: int, left: float, right: float, height: float, thin: bool = False) -> int:
        """Add a vertex and return its number."""
        self.vertices.append(Vertex(row, left, right, height, thin))
        return len(self.vertices) - 1


def build_grid(scene: Scene) -> Grid:
    """Return the grid of ``scene``, its rows not yet in any particular order."""
    grid = Grid([k for k, node in enumerate(scene.nodes) if node.kind == "state"])
    number = {k: v for v, k in enumerate(grid.states)}
    between: dict[int, tuple[int, int]] = {}
    grid.hangers = [[] for _ in grid.states]
    for k, edge in enumerate(scene.edges):
        u, v = number.get(edge.source), number.get(edge.target)
        if u is not None and v is not None and u != v:
            between[k] = u, v
        elif u is not None:
            grid.hangers[u].append(_hanger(scene, k, outwards=True))
        elif v is not None:
            grid.hangers[v].append(_hanger(scene, k, outwards=False))
    layers = assign_layers(len(grid.states), list(between.values()), number.get(scene.root, 0))
    _add_states(grid, scene, layers)
    _add_edges(grid, scene, between, layers)
    _widen(grid)
    grid.rows = [[] for _ in range(1 + max((vertex.row for vertex in grid.vertices), default=-1))]
    for v, vertex in enumerate(grid.vertices):
        grid.rows[vertex.row].append(v)
    return grid


def _hanger(scene: Scene, k: int, outwards: bool) -> Hanger:
    edge = scene.edges[k]
    end = None if edge.source == edge.target else edge.target if outwards else edge.source
    width, height = label_size(edge)
    cut = end is not None and scene.nodes[end].kind == "cut"
    return Hanger(k, end, outwards, HANGER + width + CUT_WIDTH * cut, max(height, 16.0))


def _add_states(grid: Grid, scene: Scene, layers: list[int]) -> None:
    for k, layer, group in zip(grid.states, layers, grid.hangers, strict=True):
        node = scene.nodes[k]
        width, height = node_size(node)
        grid.sizes.append((width, height))
        outwards = [h for h in group if h.outwards]
        tall = fsum(h.height for h in outwards) + HANGER_GAP * (len(outwards) - 1)
        y = -tall / 2
        for h in outwards:
            h.dy = y + h.height / 2
            y += h.height + HANGER_GAP
        for h in group:
            if not h.outwards and node.initial:
                h.dy = 9.0  # below the entry arrow
        right = max((h.width for h in outwards), default=0.0)
        left = max([ENTRY * node.initial, *(h.width for h in group if not h.outwards)])
        grid.add(2 * layer, width / 2 + left, width / 2 + right, max(height, tall))


def _add_edges(grid: Grid, scene: Scene, between: Mapping[int, tuple[int, int]], layers: Sequence[int]) -> None:
    flow = _flow(between, layers)
    shared: dict[tuple[int, bool, int], int] = {}  # (target, downwards, row): the common way of plain edges
    for k, (u, v) in between.items():
        edge, down = scene.edges[k], layers[u] < layers[v]
        step = 1 if down else -1
        chain = [u]
        for row in range(2 * layers[u] + step, 2 * layers[v], step):
            if len(chain) == 1:
                width, height = label_size(edge)
                chain.append(grid.add(row, 4.0, LABEL_OFFSET + width, height))
            elif edge.uncontrollable:  # a shared way would lay dashes over dashes
                chain.append(grid.add(row, 2.0, 2.0, 0.0, thin=True))
            else:
                if (v, down, row) not in shared:
                    shared[v, down, row] = grid.add(row, 2.0, 2.0, 0.0, thin=True)
                chain.append(shared[v, down, row])
        chain.append(v)
        grid.chains[k] = chain
        for a, b in pairwise(chain if down else chain[::-1]):
            grid.segments[a, b] = (flow[k], 2.0) if down else (0.0, 1.0)
    users = Counter(v for chain in grid.chains.values() for v in chain)
    for a, b in grid.segments:
        thin = grid.vertices[a].thin + grid.vertices[b].thin
        # the label of a long edge lies on its line too, unless the line is shared with others
        if thin == 2 or (thin == 1 and users[a] == users[b] == 1):
            grid.segments[a, b] = _LONG, 4.0


def _widen(grid: Grid) -> None:
    """Give a state the width that the lines on its busier side need."""
    sides = Counter(end for a, b in grid.segments for end in ((a, "below"), (b, "above")))
    for v, (width, height) in enumerate(grid.sizes):
        needed = PORT_GAP * min(MOST_PORTS, max(sides[v, "below"], sides[v, "above"]))
        more = max(0.0, needed - width)
        grid.sizes[v] = width + more, height
        grid.vertices[v].left += more / 2
        grid.vertices[v].right += more / 2


def _flow(between: Mapping[int, tuple[int, int]], layers: Sequence[int]) -> dict[int, float]:
    """Return for each edge the length of the longest way downwards along it: most on the main line of a task."""
    ahead, behind = [0] * len(layers), [0] * len(layers)
    downwards = sorted((layers[u], u, v) for u, v in between.values() if layers[u] < layers[v])
    for _, u, v in downwards:
        behind[v] = max(behind[v], behind[u] + 1)
    for _, u, v in reversed(downwards):
        ahead[u] = max(ahead[u], ahead[v] + 1)
    return {k: float(behind[u] + 1 + ahead[v]) for k, (u, v) in between.items()}
