"""Where things are: the boxes and routes that a layout returns, and the sizes that it starts from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from thenar.render.measure import event_text, label_lines, state_lines, text_width
from thenar.render.scene import Edge, Label, Node

__all__ = ["Box", "Layout", "Point", "Route", "along", "label_size", "node_size", "recess", "straight"]

Point = tuple[float, float]

# All lengths in px.
STATE_FONT = 13.0
EVENT_FONT = 12.0
STATE_LINE = 16.0
EVENT_LINE = 15.0
NODE_HEIGHT = 28.0  # of a state with one line of text: a circle when the name is short
ROUNDING = 14.0  # radius of a state's corners
HEAD = 8.0  # length of an arrow head


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle with centre (x, y); y grows downwards."""

    x: float
    y: float
    width: float
    height: float

    @property
    def left(self) -> float:
        """x of the left side."""
        return self.x - self.width / 2

    @property
    def right(self) -> float:
        """x of the right side."""
        return self.x + self.width / 2

    @property
    def top(self) -> float:
        """y of the upper side."""
        return self.y - self.height / 2

    @property
    def bottom(self) -> float:
        """y of the lower side."""
        return self.y + self.height / 2

    def overlaps(self, other: Box) -> bool:
        """Return whether the interiors meet."""
        return (
            self.left < other.right and other.left < self.right and self.top < other.bottom and other.top < self.bottom
        )


@dataclass(frozen=True, slots=True)
class Route:
    """The way of an edge: ``points`` are a start and three points for each cubic Bézier curve.

    The arrow head lies between the last point and ``tip``; without a tip there is none.  ``label`` is the
    room for the events, if there are any.
    """

    points: tuple[Point, ...]
    tip: Point | None = None
    label: Box | None = None


@dataclass(frozen=True, slots=True)
class Layout:
    """A drawing of ``width`` x ``height``: a box for each node of a scene, a route for each edge.

    ``entry`` is the small arrow into the initial state; ``engine`` says who made the layout.
    """

    width: float
    height: float
    boxes: tuple[Box, ...]
    routes: tuple[Route, ...]
    entry: Route | None
    engine: str


def node_size(node: Node) -> tuple[float, float]:
    """Return the width and height of a node."""
    if node.kind != "state":
        return 14.0, 14.0
    lines = state_lines(node.label)
    widest = max(text_width(line, STATE_FONT) for line in lines)
    height = NODE_HEIGHT + STATE_LINE * (len(lines) - 1)
    return max(NODE_HEIGHT, widest + 20.0), height


def label_size(edge: Edge) -> tuple[float, float]:
    """Return the width and height of the events on an edge; (0, 0) if there are none."""
    lines = label_lines(edge.labels)
    if not lines:
        return 0.0, 0.0
    left_out = len(edge.labels) - sum(map(len, lines))
    widest = max(text_width(line_text(line), EVENT_FONT) for line in lines)
    if left_out:
        widest = max(widest, text_width(more_text(left_out), EVENT_FONT))
    return widest, EVENT_LINE * (len(lines) + bool(left_out))


def line_text(line: tuple[Label, ...]) -> str:
    """Return one line of events as it is written."""
    return ", ".join(event_text(label) for label in line)


def more_text(left_out: int) -> str:
    """Say how many events a label leaves out."""
    return f"… {left_out} more"


def recess(offset: float, half: float) -> float:
    """Return how far a rounded side of half length ``half`` lies behind its middle at ``offset`` from it."""
    into_corner = abs(offset) - (half - ROUNDING)
    if into_corner <= 0:
        return 0.0
    return ROUNDING - math.sqrt(max(0.0, ROUNDING**2 - into_corner**2))


def straight(*corners: Point) -> tuple[Point, ...]:
    """Return the points of a route along straight lines."""
    points = [corners[0]]
    for (x0, y0), (x1, y1) in pairwise(corners):
        points += [((2 * x0 + x1) / 3, (2 * y0 + y1) / 3), ((x0 + 2 * x1) / 3, (y0 + 2 * y1) / 3), (x1, y1)]
    return tuple(points)


def along(points: tuple[Point, ...], upto: float) -> tuple[Point, Point]:
    """Return the point at distance ``upto`` along a route (or its end), and the unit direction there."""
    before = points[0]
    gone, direction = 0.0, (0.0, 1.0)
    for k in range(0, len(points) - 3, 3):
        p0, p1, p2, p3 = points[k : k + 4]
        for step in range(1, 13):
            t = step / 12
            a, b, c, d = (1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3
            here = (a * p0[0] + b * p1[0] + c * p2[0] + d * p3[0], a * p0[1] + b * p1[1] + c * p2[1] + d * p3[1])
            length = math.dist(before, here)
            if length > 0:
                direction = (here[0] - before[0]) / length, (here[1] - before[1]) / length
            before = here
            gone += length
            if gone >= upto:
                return here, direction
    return before, direction
