"""The layout of Graphviz's ``dot``, for those who have it and prefer it; never needed, never waited for."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import replace
from typing import Any

from thenar.render.geometry import Box, Layout, Point, Route, label_size, node_size, straight
from thenar.render.layout import MARGIN, layered
from thenar.render.scene import Scene

__all__ = ["TIME_LIMIT", "graphviz_or_own"]

TIME_LIMIT = 5.0  # seconds; dot needs more than a minute for some 81-state products
_INCH = 72.0  # px
_LABEL_GAP = 5.0  # px


def graphviz_or_own(scene: Scene, time_limit: float = TIME_LIMIT) -> Layout:
    """Lay out ``scene`` by ``dot``; by our own code, saying why in ``engine``, where that is not to be had."""
    program = shutil.which("dot")
    if program is None:
        return replace(layered(scene), engine="own (dot is not installed)")
    try:
        answer = subprocess.run(
            [program, "-Tjson0"],
            input=_source(scene),
            capture_output=True,
            check=True,
            encoding="utf-8",
            timeout=time_limit,
        )
        return _read(scene, json.loads(answer.stdout))
    except subprocess.TimeoutExpired:
        return replace(layered(scene), engine=f"own (dot took longer than {time_limit:g} s)")
    # other versions may answer in ways unknown to _read
    except (OSError, subprocess.CalledProcessError, ValueError, TypeError, AttributeError, LookupError):
        return replace(layered(scene), engine="own (dot failed)")


def _source(scene: Scene) -> str:
    """Return the graph with every size fixed: dot is asked for places only, and sees no name."""
    lines = ["digraph {", "graph [nodesep=0.2 ranksep=0.3]", 'node [shape=box fixedsize=true label=""]']
    for k, node in enumerate(scene.nodes):
        width, height = node_size(node)
        lines.append(f"{k} [width={width / _INCH:.4f} height={height / _INCH:.4f}]")
        if node.initial:
            lines += ["entry [width=0.01 height=0.01]", f"entry -> {k} [id=entry]"]
    for k, edge in enumerate(scene.edges):
        width, height = label_size(edge)
        size = f'fixedsize="true" width="{width + 2 * _LABEL_GAP:.0f}" height="{height:.0f}"'
        label = f'label=<<table border="0" cellpadding="0" {size}><tr><td></td></tr></table>>' if edge.labels else ""
        head = "dir=none" if scene.nodes[edge.target].kind == "disabled" else ""
        lines.append(f"{edge.source} -> {edge.target} [id={k} {head} {label}]")
    return "\n".join([*lines, "}"])


def _read(scene: Scene, answer: dict[str, Any]) -> Layout:
    _, _, width, height = (float(x) for x in answer["bb"].split(","))

    def point(text: str) -> Point:
        x, y = text.split(",")[-2:]
        return float(x) + MARGIN, height - float(y) + MARGIN  # dot's y grows upwards

    boxes: dict[str, Box] = {}
    for item in answer["objects"]:
        boxes[item["name"]] = Box(*point(item["pos"]), float(item["width"]) * _INCH, float(item["height"]) * _INCH)
    routes: dict[str, Route] = {}
    for item in answer["edges"]:
        # "e,x,y" is the tip; then the spline, its start and three points a curve
        spline = item["pos"].split()
        tip = point(spline.pop(0)) if spline[0].startswith("e,") else None
        points = tuple(map(point, spline))
        if (len(points) - 1) % 3:
            points = straight(points[0], points[-1])
        label = None
        if "lp" in item:
            label = Box(*point(item["lp"]), *label_size(scene.edges[int(item["id"])]))
        routes[item["id"]] = Route(points, tip, label)
    nodes = range(len(scene.nodes))
    return Layout(
        width + 2 * MARGIN,
        height + 2 * MARGIN,
        tuple(boxes[str(k)] for k in nodes),
        tuple(routes[str(k)] for k in range(len(scene.edges))),
        routes.get("entry"),
        "dot",
    )
