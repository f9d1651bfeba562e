"""A scene as a picture: standalone SVG that reads well on light and on dark paper."""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape
from typing import Literal

from thenar.errors import InputError
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Trace
from thenar.render.geometry import (
    EVENT_FONT,
    EVENT_LINE,
    HEAD,
    ROUNDING,
    STATE_FONT,
    STATE_LINE,
    Box,
    Layout,
    Point,
    Route,
    along,
    more_text,
)
from thenar.render.graphviz import graphviz_or_own
from thenar.render.layout import layered
from thenar.render.measure import event_text, label_lines, printable, state_lines, text_width
from thenar.render.scene import LIMIT, Edge, Label, Node, Scene, scene

__all__ = ["draw", "svg"]

FONT = "Helvetica, Arial, 'Liberation Sans', sans-serif"
RED = "#d73a40"  # uncontrollable; contrast 4.6 on white, 4.1 on near-black
GREEN = "#23863b"  # a check that holds; contrast 4.6 on white, 4.1 on near-black
GREY = "#858b93"  # cut or disabled
AMBER = "#f2a71b"  # highlighted: a marker pen below the ink, never the ink itself
CAPTION_HEIGHT = 24.0  # px

_PAPER = """<style>
svg.thenar{color:#1f2328}svg.thenar .paper{fill:#fff}
@media (prefers-color-scheme:dark){svg.thenar{color:#e6edf3}svg.thenar .paper{fill:#0d1117}}
</style>
<rect class="paper" width="100%" height="100%" fill="#fff"/>"""


def svg(
    obj: Automaton | Supervisor | Scene,
    *,
    highlight: Iterable[int] = (),
    path: Trace | str | None = None,
    centre: int | None = None,
    limit: int = LIMIT,
    layout: Literal["own", "dot"] = "own",
) -> str:
    """Draw an automaton, a supervisor or a scene as an SVG document.

    The initial state has a small entry arrow, a marked state a double line.  A controllable event has a tick
    across its edge; an edge whose events are all uncontrollable is dashed and red, and so is (in italics) the
    name of an uncontrollable event on any edge.  A dashed edge to a bar is an event that the supervisor
    disables, one to "…" leads out of the picture.

    ``highlight``, ``path``, ``centre`` and ``limit`` choose what is shown, see :func:`scene`.  Our ``own``
    layout gives the same bytes everywhere; ``layout="dot"`` takes Graphviz's if it is installed and answers
    within 5 s.  The attribute ``data-layout`` says whose it is, and why if it is not the one asked for.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> svg(lamp).splitlines()[1]
    "<title>Automaton 'LAMP': 2 states (1 marked), 2 transitions, 2 events</title>"
    """
    if layout not in ("own", "dot"):
        raise InputError(f"layout is {layout!r}; choose 'own' or 'dot'")
    shown = obj if isinstance(obj, Scene) else scene(obj, highlight=highlight, path=path, centre=centre, limit=limit)
    return draw(shown, layered(shown) if layout == "own" else graphviz_or_own(shown))


def draw(picture: Scene, layout: Layout, *, paper: bool = True) -> str:
    """Return ``picture`` laid out by ``layout`` as SVG.

    Without ``paper`` there is no background and the ink is the surrounding text's colour: for a page that
    brings its own.
    """
    caption = picture.caption
    width = max(layout.width, text_width(caption, EVENT_FONT) + 16.0 if caption else 0.0)
    height = layout.height + (CAPTION_HEIGHT if caption else 0.0)
    ink = ' color="#1f2328"' if paper else ""
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="thenar" role="img" width="{_n(width)}" '
        f'height="{_n(height)}" viewBox="0 0 {_n(width)} {_n(height)}" font-family="{FONT}" '
        f'data-layout="{escape(layout.engine)}"{ink}>',
        f"<title>{_text(picture.title)}</title>",
    ]
    if caption:
        lines.append(f"<desc>{_text(caption)}</desc>")
    if paper:
        lines.append(_PAPER)
    lines += _marker_pen(picture, layout)
    lines.append('<g fill="none" stroke="currentColor" stroke-width="1.3">')
    drawn: set[tuple[Point, ...]] = set()
    for edge, route in zip(picture.edges, layout.routes, strict=True):
        lines.append(_edge(picture, edge, route, _own_part(route, drawn)))
    if layout.entry:
        lines.append(f'<path d="{_d(layout.entry.points)}"/>{_head(layout.entry)}')
    lines += ["</g>", f'<g fill="currentColor" text-anchor="middle" font-size="{_n(STATE_FONT)}">']
    lines += [_node(node, box) for node, box in zip(picture.nodes, layout.boxes, strict=True)]
    lines += ["</g>", f'<g fill="currentColor" font-size="{_n(EVENT_FONT)}">']
    lines += [
        _label(edge, route.label) for edge, route in zip(picture.edges, layout.routes, strict=True) if route.label
    ]
    if caption:
        lines.append(f'<text x="8" y="{_n(height - 9.0)}" fill="{GREY}">{_text(caption)}</text>')
    return "\n".join([*lines, "</g>", "</svg>"])


def _marker_pen(picture: Scene, layout: Layout) -> list[str]:
    routes = [r for e, r in zip(picture.edges, layout.routes, strict=True) if e.highlighted]
    passed = [b for n, b in zip(picture.nodes, layout.boxes, strict=True) if n.passed or n.highlighted]
    if not routes and not passed:
        return []
    return [
        f'<g fill="none" stroke="{AMBER}" stroke-width="9" stroke-linecap="round" opacity="0.4">',
        *(f'<path d="{_d((*r.points, *_to_tip(r)))}"/>' for r in routes),
        *(_rounded(box, 2.0) for box in passed),
        "</g>",
    ]


def _own_part(route: Route, drawn: set[tuple[Point, ...]]) -> Route:
    """Return ``route`` up to where it joins one that is ``drawn``: ink over ink looks bold."""
    for k in range(0, len(route.points) - 1, 3):
        curve = route.points[k : k + 4]
        if curve in drawn:
            return Route(route.points[: k + 1])
        drawn.add(curve)
    return route


def _edge(picture: Scene, edge: Edge, full: Route, route: Route) -> str:
    source, target = picture.nodes[edge.source], picture.nodes[edge.target]
    loose = source.kind != "state" or target.kind != "state"
    colour = RED if edge.uncontrollable else GREY if loose else "currentColor"
    dashes = "2 3" if loose else "5 3" if edge.uncontrollable else "none"
    words = ", ".join(_event_in_words(label) for label in edge.labels)
    ends = f"{source.label or '…'} → {target.label or 'nowhere'}"
    parts = [
        f'<g stroke="{colour}"><title>{_text(f"{ends}: {words}" if words else ends)}</title>'
        f'<path d="{_d(route.points)}" stroke-dasharray="{dashes}"/>'
    ]
    if edge.controllable and not loose:
        parts.append(_tick(full, 6.0, 4.0))
    if target.kind == "disabled":
        parts.append(_tick(full, math.inf, 6.0))
    return "".join([*parts, _head(route, colour), "</g>"])


def _event_in_words(label: Label) -> str:
    event = label.event
    state = ("disabled " if label.disabled else "") + ", ".join(event.properties)
    return f"{event.name} ({state}{': ' + event.meaning if event.meaning else ''})"


def _tick(route: Route, distance: float, half: float) -> str:
    (x, y), (dx, dy) = along(route.points, distance)
    ends = (x - half * dy, y + half * dx), (x + half * dy, y - half * dx)
    return f'<path d="M{_p(ends[0])}L{_p(ends[1])}"/>'


def _head(route: Route, colour: str = "currentColor") -> str:
    if route.tip is None:
        return ""
    (x, y), (bx, by) = route.tip, route.points[-1]
    length = max(0.01, ((x - bx) ** 2 + (y - by) ** 2) ** 0.5)
    dx, dy = (x - bx) / length, (y - by) / length
    wings = [(x - HEAD * dx - s * 3.2 * dy, y - HEAD * dy + s * 3.2 * dx) for s in (1, -1)]
    return f'<path d="M{_p(route.tip)}L{_p(wings[0])}L{_p(wings[1])}Z" fill="{colour}" stroke="none"/>'


def _to_tip(route: Route) -> tuple[Point, ...]:
    return () if route.tip is None else (route.points[-1], route.tip, route.tip)


def _node(node: Node, box: Box) -> str:
    if node.kind == "disabled":
        return ""
    if node.kind == "cut":
        return f'<text x="{_n(box.x)}" y="{_n(box.y + 2.0)}" fill="{GREY}">…</text>'
    parts = [f'<g data-state="{node.state}"><title>{_text(node.label)}</title>']
    fill = f'fill="{AMBER}" fill-opacity="0.35"' if node.highlighted else 'fill="none"'
    parts.append(f'<g {fill} stroke="currentColor" stroke-width="1.3">{_rounded(box, 0.0)}')
    if node.marked:
        parts.append(_rounded(box, -3.0))
    parts.append("</g>")
    lines = state_lines(node.label)
    for k, line in enumerate(lines):
        y = box.y + STATE_LINE * (k - (len(lines) - 1) / 2) + 0.35 * STATE_FONT
        parts.append(f'<text x="{_n(box.x)}" y="{_n(y)}">{escape(line)}</text>')
    return "".join([*parts, "</g>"])


def _rounded(box: Box, grow: float) -> str:
    return (
        f'<rect x="{_n(box.left - grow)}" y="{_n(box.top - grow)}" width="{_n(box.width + 2 * grow)}" '
        f'height="{_n(box.height + 2 * grow)}" rx="{_n(ROUNDING + grow)}"/>'
    )


def _label(edge: Edge, room: Box) -> str:
    lines = label_lines(edge.labels)
    y = room.top + 0.5 * EVENT_LINE + 0.35 * EVENT_FONT
    texts = []
    for line in lines:
        texts.append(f'<text x="{_n(room.left)}" y="{_n(y)}">{", ".join(map(_event, line))}</text>')
        y += EVENT_LINE
    left_out = len(edge.labels) - sum(map(len, lines))
    if left_out:
        texts.append(f'<text x="{_n(room.left)}" y="{_n(y)}" fill="{GREY}">{more_text(left_out)}</text>')
    return "".join(texts)


def _event(label: Label) -> str:
    looks = ""
    if not label.event.controllable:
        looks += f' fill="{RED}" font-style="italic"'
    elif label.disabled:
        looks += f' fill="{GREY}"'
    if label.disabled:
        looks += ' text-decoration="line-through"'
    if label.highlighted:
        looks += ' font-weight="bold"'
    name = escape(event_text(label))
    return f"<tspan{looks}>{name}</tspan>" if looks else name


def _text(text: str) -> str:
    return escape(printable(text), quote=False)


def _d(points: tuple[Point, ...]) -> str:
    rest = "".join(f"C{' '.join(map(_p, points[k : k + 3]))}" for k in range(1, len(points), 3))
    return f"M{_p(points[0])}{rest}"


def _p(point: Point) -> str:
    return f"{_n(point[0])},{_n(point[1])}"


def _n(value: float) -> str:
    text = f"{value:.1f}"
    return "0" if text == "-0.0" else text.removesuffix(".0")
