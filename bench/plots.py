"""Two figures of a run: time against size beside TCT and libFAUDES, and how the task grows with the fingers."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DOCS = Path(__file__).parents[1] / "docs"
LINES = {"thenar": ("#1b6ca8", "o"), "TCT": ("#c0392b", "s"), "libFAUDES": ("#7f8c8d", "^")}
LOOK: Any = {"svg.fonttype": "none", "svg.hashsalt": "thenar", "font.size": 9, "axes.spines.top": False}
LOOK |= {"axes.spines.right": False, "axes.grid": True, "grid.color": "#e5e5e5", "legend.frameon": False}


def latest(results: Path) -> Path:
    """Return the last run's JSON file."""
    runs = sorted(results.glob("*.json"))
    if not runs:
        raise SystemExit("there is no run to draw yet: python -m bench")
    return runs[-1]


def draw(run: Path, folder: Path | None = None) -> list[Path]:
    """Draw what ``run`` has measured, for the documentation or, with its name in front, into ``folder``."""
    import matplotlib as mpl

    found = json.loads(run.read_text())
    pictures: dict[str, Callable[[Any], Figure]] = {"speed": _speed, "growth": _growth}
    drawn = []
    for name, section in (("speed", "families"), ("growth", "fingers")):
        if found.get(section):
            path = DOCS / f"{name}.svg" if folder is None else folder / f"{run.stem}-{name}.svg"
            with mpl.rc_context(LOOK):
                pictures[name](found[section]).savefig(path, metadata={"Date": None}, bbox_inches="tight")
            drawn.append(path)
    return drawn


def _axes(n: int, width: float) -> tuple[Figure, Sequence[Axes]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, 2.8), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, [figure.add_subplot(1, n, k + 1) for k in range(n)]


def _speed(rows: list[dict[str, Any]]) -> Figure:
    """CPU seconds against the states of the supervisor, a panel for each family; a ring: not within the limit."""
    names = list(dict.fromkeys(row["model"].split("(")[0] for row in rows if "(" in row["model"]))
    figure, panels = _axes(len(names), 2.6 * len(names))
    for axes, family in zip(panels, names, strict=True):
        own = [row for row in rows if row["model"].startswith(f"{family}(")]
        for tool, (color, marker) in LINES.items():
            points = [(row["states"], row["seconds"][tool]) for row in own if row["seconds"].get(tool)]
            if points:
                axes.plot(*zip(*points, strict=True), color=color, marker=marker, markersize=4, label=tool)
            for row in own:
                given_up = row.get("trouble", {}).get(tool, "")
                if given_up.startswith("> "):
                    limit = float(given_up[2:].split()[0])
                    axes.plot(row["states"], limit, marker=marker, color=color, markerfacecolor="none", markersize=6)
        axes.set(xscale="log", yscale="log", title=family, xlabel="states of the supervisor")
        axes.minorticks_off()
    panels[0].set_ylabel("CPU seconds")
    panels[0].legend()
    return figure


def _growth(rows: list[dict[str, Any]]) -> Figure:
    """States, nodes of their diagram and CPU seconds against the number of fingers."""
    done = [row for row in rows if "states" in row]
    fingers = [row["fingers"] for row in done]
    figure, panels = _axes(3, 9.0)
    shown = {
        "states of the supervisor, powers of ten": [math.log10(row["states"]) for row in done],  # too large for floats
        "nodes of its diagram": [row["nodes"] for row in done],
        "CPU seconds": [row["cpu_s"] for row in done],
    }
    for k, (axes, (title, values)) in enumerate(zip(panels, shown.items(), strict=True)):
        axes.plot(fingers, values, color=LINES["thenar"][0], marker="o", markersize=4)
        scale = "log" if k else "linear"  # straight lines show powers, and for the states an exponential
        axes.set(xscale=scale, yscale=scale, title=title, xlabel="fingers")
        if k:
            ticks = [n for n in (2, 5, 10, 20, 50, 100) if fingers[0] <= n <= fingers[-1]]
            axes.set_xticks(ticks, [str(n) for n in ticks])
            axes.minorticks_off()
    return figure
