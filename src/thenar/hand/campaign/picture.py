"""The picture of a campaign: how far the estimates are off the truth."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from thenar.hand.campaign.row import Row
from thenar.hand.campaign.summary import summary

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_errors"]

OURS, PAPER, FAILED, GREY, INK = "#1f6f8b", "#d98e32", "#c0392b", "#8a8f94", "#333333"
PANELS = (
    ("mu", "friction", "true μ", 1.0),
    ("weight_n", "weight", "true weight, N", 1.0),
    ("stiffness_n_per_m", "stiffness", "true stiffness, kN/m", 1e-3),
)


def draw_errors(rows: Sequence[Row]) -> bytes:
    """Return a PNG: friction by both formulas against the truth, and the relative error of each quantity.

    The band is ± rms; an episode that failed physically is a red cross.  The same rows give the same bytes.

    >>> draw_errors([])[:4]
    b'\\x89PNG'
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2).flat
    errors = summary(rows)["errors"]
    _against_truth(axes[0], rows, errors)
    for ax, panel in zip(axes[1:], PANELS, strict=True):
        _relative(ax, rows, errors, *panel)
    succeeded = sum(row.physical_success for row in rows)
    figure.suptitle(f"{succeeded} of {len(rows)} episodes succeeded physically", fontsize=12, color=INK)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _against_truth(ax: Axes, rows: Sequence[Row], errors: dict[str, Any]) -> None:
    """Friction as the hand finds it, and by the paper's formula, over the true one."""
    ends = [min((r.mu_truth for r in rows), default=0.0), max((r.mu_truth for r in rows), default=1.0)]
    ax.plot(ends, ends, color=GREY, lw=0.8, zorder=1)
    for name, colour, label in (("mu", OURS, "by element"), ("mu_paper", PAPER, "paper: F_t / F_n of the whole pad")):
        points = [(r.mu_truth, getattr(r, name)) for r in rows if getattr(r, name) is not None]
        ax.scatter(*_columns(points), s=10, color=colour, lw=0, alpha=0.8, zorder=2, label=label)
    bias = errors["mu_paper"]["mean"]
    also = "" if bias is None else f"; the bias of the paper's formula is {_percent(bias, '+')}"
    _finish(ax, f"friction, found and true{also}", "true μ", "μ found")
    ax.set_ylim(bottom=0)
    ax.legend(frameon=False, fontsize=9, loc="upper left")


def _relative(
    ax: Axes, rows: Sequence[Row], errors: dict[str, Any], name: str, title: str, label: str, unit: float
) -> None:
    """Relative error of one quantity over its true value."""
    for success, size, width, colour, marker in ((True, 10, 0.0, OURS, "o"), (False, 36, 1.5, FAILED, "x")):
        points = [
            (unit * getattr(r, f"{name}_truth"), 100 * getattr(r, f"{name}_error"))
            for r in rows
            if r.physical_success == success and getattr(r, f"{name}_error") is not None
        ]
        ax.scatter(*_columns(points), s=size, lw=width, color=colour, marker=marker, alpha=0.8, zorder=2)
    ax.axhline(0, color=GREY, lw=0.8, zorder=1)
    rms, paper = errors[name]["rms"], errors[f"{name}_paper"]["rms"]
    if rms is not None:
        ax.axhspan(-100 * rms, 100 * rms, color=OURS, alpha=0.12, lw=0, zorder=0)
        reach = 1.15 * 100 * errors[name]["max"]
        ax.set_ylim(-reach, reach)
    also = "" if paper is None else f" (the paper's formula: {_percent(paper)})"
    _finish(ax, title if rms is None else f"{title}: rms {_percent(rms)}{also}", label, "relative error, %")


def _finish(ax: Axes, title: str, x: str, y: str) -> None:
    ax.set_title(title, fontsize=10, loc="left", color=INK)
    ax.set_xlabel(x, fontsize=9)
    ax.set_ylabel(y, fontsize=9)
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(labelsize=8)


def _columns(points: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]


def _percent(share: float, sign: str = "") -> str:
    digits = max(0, 1 - math.floor(math.log10(abs(100 * share)))) if share else 0  # two that mean something
    return f"{100 * share:{sign}.{digits}f} %"
