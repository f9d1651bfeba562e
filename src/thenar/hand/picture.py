"""The picture of an episode, as the paper's Figures 1 and 2: forces, height and slip over the phases of the task."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from thenar.hand.episode import Episode
from thenar.hand.estimates import Estimate
from thenar.hand.phases import phase_after
from thenar.hand.skills import SKILLS
from thenar.hand.slip import SLIP_FRACTION
from thenar.hand.world import PERIOD_S
from thenar.io.files import atomic_write
from thenar.runtime.record import Entry

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Mark", "draw_episode", "figure", "marks", "phases", "save", "spread"]

SIZE_INCH, DPI = (11.0, 8.6), 150
# Okabe & Ito, "Color Universal Design" (2008); the tints are Paul Tol's pale scheme: both safe for colour-blind eyes
BLUE, ORANGE, GREEN, PURPLE, RED = "#0072B2", "#E69F00", "#009E73", "#A6558C", "#D55E00"
INK, GREY, HAIR = "#1f2328", "#5b6169", "#a9afb7"
TINTS = {
    "approach": "#dddddd",
    "loading": "#eeeebb",
    "manipulation": "#ccddaa",
    "squeezing": "#ffcccc",
    "replace": "#cceeff",
    "unloading": "#bbccee",
    "release": "#e5d8ee",
}
CONTACT = ("prox_make_C", "remote_breakC", "remote_makeC", "prox_breakC")  # how the paper's contact events begin
LEAN_DEG = 60.0  # of the event names
NAME_PT, PHASE_PT = 7.5, 9.0
LEFT, RIGHT = 0.065, 0.885  # of the figure's width: where the axis of time lies
WIDTH_PT = (RIGHT - LEFT) * SIZE_INCH[0] * 72
TARE_MS = 300  # of the run, in which no finger touches anything yet
SMOOTH_MS = 20  # of the moving mean of the forces: what is shorter is noise, 50 mN at 1 kHz
LOWEST_MM = -12.0  # an object that falls further leaves the picture
LEAST_N, LEAST_MM = 1.0, 5.0  # of the axes' range: noise alone is not to look like a signal
BELOW_MM = -0.2  # lower than this an object is not on the table but under it: somebody took the table away

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Mark:
    """Something that happened at ``time_s``; ``kind`` is contact, surprise (uncontrollable, or a violation), other."""

    time_s: float
    name: str
    kind: str


def draw_episode(episode: Episode, *, scenario: str = "") -> bytes:
    """Draw ``episode`` as a PNG of 1650 × 1290 pixels.

    Four panels share the axis of time (s): grip force of each finger and its command (N), load force and true weight
    (N), height of the object and its contact with the table (mm, the truth), share of the slipping pad elements.
    Every event of the log is named above them, in bold where a contact changes, in red italics where it is
    uncontrollable; the bands are the phases that :data:`~thenar.hand.phases.PHASES` makes of the events.
    ``scenario`` goes into the title.  The same episode gives the same bytes (on the same matplotlib); about 0.7 s.
    """
    stream = io.BytesIO()
    figure(episode, scenario=scenario).savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
    return stream.getvalue()


def save(path: str | os.PathLike[str], episode: Episode, *, scenario: str = "") -> None:
    """Write the picture of ``episode`` to ``path`` as PNG, all or nothing; raise InputError if that cannot be."""
    atomic_write(path, draw_episode(episode, scenario=scenario))


def figure(episode: Episode, *, scenario: str = "") -> Figure:
    """Return the picture as a matplotlib figure: for a paper, ``figure(episode).savefig("episode.pdf")``."""
    from matplotlib import style
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with style.context(["default", {"axes.linewidth": 0.7, "font.size": 9.0, "axes.edgecolor": GREY}]):
        paper = Figure(figsize=SIZE_INCH)
        FigureCanvasAgg(paper)
        grid = paper.add_gridspec(
            6,
            1,
            height_ratios=(1.4, 0.36, 1.7, 1.5, 1.25, 0.8),
            left=LEFT,
            right=RIGHT,
            top=0.918,
            bottom=0.06,
            hspace=0.06,
        )
        strip, band, *panels = (paper.add_subplot(grid[k]) for k in range(6))
        end = max(episode.run.time_s, len(episode.recording) * PERIOD_S)
        for axes in (strip, band, *panels):
            axes.set_xlim(0.0, end)
        for panel, draw in zip(panels, (_grip, _load, _height, _slip), strict=True):
            draw(panel, episode)
            _dress(panel)
        panels[-1].tick_params(labelbottom=True)
        panels[-1].set_xlabel("time [s]")
        _bands(band, panels, episode, end)
        found = marks(episode.run.entries)
        for panel in panels:
            for mark in found:
                colour, width = {"contact": (INK, 0.8), "surprise": (RED, 0.9)}.get(mark.kind, (HAIR, 0.5))
                panel.axvline(mark.time_s, color=colour, linewidth=width, zorder=1.5)
        _names(strip, band, found)
        _title(paper, episode, scenario)
        return paper


def phases(entries: Iterable[Entry], end_s: float) -> list[tuple[str, float, float]]:
    """Return the phases of a log as (name, begin, end) in seconds, in their order and without a gap.

    >>> phases([{"kind": "event", "t": 1.0, "event": "prox_make_C1"}], 2.5)
    [('approach', 0.0, 1.0), ('loading', 1.0, 2.5)]
    """
    found = [(phase_after(None), 0.0)]
    for entry in entries:
        if entry["kind"] == "event" and (phase := phase_after(entry["event"], found[-1][0])) != found[-1][0]:
            found.append((phase, entry["t"]))
    ends = [begin for _, begin in found[1:]] + [end_s]
    return [(name, begin, end) for (name, begin), end in zip(found, ends, strict=True) if end > begin]


def marks(entries: Iterable[Entry]) -> list[Mark]:
    """Return what of a log is marked in the picture: its events, its violations, and a stop.

    >>> marks([{"kind": "event", "t": 1.0, "event": "incip_slip*"}])
    [Mark(time_s=1.0, name='incip_slip', kind='surprise')]
    """
    found = []
    for entry in entries:
        if entry["kind"] == "event":
            name = entry["event"].removesuffix("*")
            kind = "other" if entry["event"] in SKILLS else "surprise"
            found.append(Mark(entry["t"], name, "contact" if name.startswith(CONTACT) else kind))
        elif entry["kind"] == "violation":
            found.append(Mark(entry["t"], f"violation: {entry['event'].removesuffix('*')}", "surprise"))
        elif entry["kind"] == "end" and entry.get("outcome") == "stopped":
            found.append(Mark(entry["t"], "safe stop", "surprise"))
    return found


def spread(wanted: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Return places at least ``gap`` apart within [low, high], in order, and as near (least squares) to ``wanted``.

    ``wanted`` ascends.  Where not all have room the gap is made smaller.  Time O(n): pools of adjacent violators.

    >>> spread([1.0, 1.0, 5.0], 1.0, 0.0, 10.0)
    [0.5, 1.5, 5.0]
    """
    n = len(wanted)
    gap = min(gap, (high - low) / (n - 1)) if n > 1 else 0.0
    pools: list[list[float]] = []  # sum and number; places less k gaps only have to ascend
    for k, x in enumerate(wanted):
        pools.append([x - k * gap, 1])
        while len(pools) > 1 and pools[-2][0] * pools[-1][1] > pools[-1][0] * pools[-2][1]:
            total, count = pools.pop()
            pools[-1][0] += total
            pools[-1][1] += count
    means = [total / count for total, count in pools for _ in range(int(count))]
    room = high - (n - 1) * gap
    return [min(max(mean, low), room) + k * gap for k, mean in enumerate(means)]


def _grip(axes: Axes, episode: Episode) -> None:
    at, time = _columns(episode)
    # the wider line below: while both press alike, both are seen
    for i, sign, colour, width in ((1, 1.0, BLUE, 2.2), (2, -1.0, ORANGE, 1.3)):
        fx, fz, pitch = _forces(at, i)
        grip = sign * (fx * np.cos(pitch) + fz * np.sin(pitch))
        axes.plot(time, grip, color=colour, lw=width, label=f"finger {i}")
    axes.plot(time, at["grip_command"], color=INK, lw=0.9, ls=(0, (4, 2)), label="command")
    axes.update_datalim([(0.0, LEAST_N)])
    axes.set_ylabel("grip force [N]")


def _load(axes: Axes, episode: Episode) -> None:
    at, time = _columns(episode)
    load = np.zeros(len(time))
    for i in (1, 2):
        fx, fz, pitch = _forces(at, i)
        load += fz * np.cos(pitch) - fx * np.sin(pitch)
    axes.plot(time, load, color=GREEN, lw=1.2, label="both fingers")
    if not episode.world.missing:
        axes.axhline(episode.block.weight_n, color=INK, lw=1.0, ls=":", label="true weight")
    axes.update_datalim([(0.0, LEAST_N)])
    axes.set_ylabel("load force [N]")


def _height(axes: Axes, episode: Episode) -> None:
    axes.set_ylabel("height [mm]")
    if episode.world.missing:
        axes.set_yticks([])
        axes.text(0.5, 0.5, "there is no object", transform=axes.transAxes, ha="center", va="center", color=GREY)
        return
    _, time = _columns(episode)
    height = 1e3 * episode.truth.height_m
    low, high = max(float(height.min()), LOWEST_MM), max(float(height.max()), LEAST_MM)
    margin = 0.1 * (high - low)
    stands = (_smooth(episode.truth.on_table.astype(float)) > 0.5) & (height > BELOW_MM)
    axes.set_ylim(low - margin, high + margin)
    axes.fill_between(
        time, 0, 1, where=stands.tolist(), transform=axes.get_xaxis_transform(),
        facecolor="none", edgecolor=HAIR, hatch="////", linewidth=0, label="on the table", zorder=0.8,
    )  # fmt: skip
    axes.plot(time, height, color=BLUE, lw=1.4, label="object (truth)")
    if height.min() < low:
        axes.annotate(
            "further down",
            (time[int(np.argmax(height < low))], low),
            (8, 3),
            textcoords="offset points",
            color=GREY,
        )


def _slip(axes: Axes, episode: Episode) -> None:
    at, time = _columns(episode)
    # above the marks: a slip that is caught is over within some milliseconds, as wide as the mark of its event
    axes.fill_between(time, at["slip_fraction"], step="pre", color=PURPLE, lw=1.6, label="share of pad", zorder=3)
    axes.axhline(SLIP_FRACTION, color=INK, lw=0.8, ls=":", label="threshold")
    axes.set_ylim(0.0, 1.08)
    axes.set_yticks([0.0, 0.5, 1.0])
    axes.set_ylabel("slip")


def _columns(episode: Episode) -> tuple[dict[str, Floats], Floats]:
    """Return the channels by name, and their time."""
    recording = episode.recording
    time = np.linspace(
        PERIOD_S, len(recording) * PERIOD_S, len(recording)
    )  # a row is what was measured at the end of its period
    return dict(zip(episode.channels, recording.T, strict=True)), time


def _forces(at: dict[str, Floats], i: int) -> tuple[Floats, Floats, Floats]:
    """Return what finger ``i`` feels, x and z, tared and smoothed, and its pitch: the sensor turns with the tip."""
    fx, fz = (_smooth(f - f[:TARE_MS].mean()) for f in (at[f"force_x_{i}"], at[f"force_z_{i}"]))
    return fx, fz, _smooth(at[f"pitch_{i}"])


def _smooth(values: Floats) -> Floats:
    """Return the centred moving mean over SMOOTH_MS; as long as ``values``, of fewer at either end."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    k = np.arange(len(values))
    first, last = np.maximum(k - SMOOTH_MS // 2, 0), np.minimum(k + SMOOTH_MS // 2 + 1, len(values))
    found: Floats = (total[last] - total[first]) / (last - first)
    return found


def _dress(axes: Axes) -> None:
    axes.tick_params(labelbottom=False, length=3, width=0.7, labelsize=8.5)
    axes.margins(y=0.1)
    axes.yaxis.set_label_coords(-0.045, 0.5)
    axes.spines[["top", "right"]].set_visible(False)
    if not axes.get_legend_handles_labels()[0]:
        return
    axes.legend(
        loc="upper left", bbox_to_anchor=(1.004, 1.02), frameon=False, fontsize=8.5, handlelength=1.4, borderaxespad=0.2
    )


def _bands(band: Axes, panels: Sequence[Axes], episode: Episode, end: float) -> None:
    """Colour the phases and write their names into them; a name that has no room goes into a key beside."""
    band.axis("off")
    band.set_ylim(0.0, 1.0)
    frictions = [e["t"] for e in episode.run.entries if e["kind"] == "start" and e["event"] == "dec_gripF*"]
    named, unnamed = set(), []
    for name, begin, until in phases(episode.run.entries, end):
        tint = TINTS.get(name, "#ffffff")
        band.axvspan(begin, until, color=tint, lw=0)
        for panel in panels:
            panel.axvspan(begin, until, color=tint, alpha=0.35, lw=0, zorder=0.5)
        texts = [name]
        if any(begin <= t < until for t in frictions):
            texts = [f"{name} + friction EP", f"{name}\n+ friction EP", name]
        room = WIDTH_PT * (until - begin) / end
        for size in (PHASE_PT, PHASE_PT - 1, PHASE_PT - 2):
            fitting = [text for text in texts if _width(text, size) + 3 < room]
            if fitting:
                band.text(
                    (begin + until) / 2, 0.48, fitting[0], ha="center", va="center", fontsize=size, linespacing=1,
                    bbox={"facecolor": tint, "edgecolor": "none", "pad": 0.5},
                )  # fmt: skip
                named.add(name)
                break
        else:
            unnamed.append(name)
    for k, name in enumerate(dict.fromkeys(n for n in unnamed if n not in named)):
        y = 0.82 - 0.34 * k
        band.text(1.008, y, "■", transform=band.transAxes, va="center", fontsize=11, color=TINTS[name])
        band.text(1.028, y, name, transform=band.transAxes, va="center", fontsize=8)


def _width(text: str, size: float) -> float:
    """Return the width of ``text`` in points."""
    from matplotlib.textpath import TextPath

    return max(float(TextPath((0, 0), line, size=size).get_extents().width) for line in text.split("\n"))


def _names(strip: Axes, band: Axes, found: Sequence[Mark]) -> None:
    """Name the marks in a strip above the panels: slanted, so far apart that none touches the next, with leaders."""
    strip.axis("off")
    strip.set_ylim(0.0, 1.0)
    end = strip.get_xlim()[1]
    line_pt = 1.25 / math.sin(math.radians(LEAN_DEG))
    size = min(NAME_PT, WIDTH_PT / (line_pt * max(len(found), 1)))
    places = spread([m.time_s / end * WIDTH_PT for m in found], line_pt * size, 3.0, WIDTH_PT - 3.0)
    for mark, place in zip(found, places, strict=True):
        x, t = place / WIDTH_PT * end, mark.time_s
        colour = {"contact": INK, "surprise": RED}.get(mark.kind, GREY)
        strip.plot([t, t, x], [0.0, 0.03, 0.17], color=colour, lw=0.6, clip_on=False, solid_joinstyle="round")
        band.plot([t, t], [0.0, 1.0], color=colour, lw=0.5, alpha=0.45)
        strip.text(
            x, 0.19, mark.name, rotation=LEAN_DEG, rotation_mode="anchor", ha="left", va="center", fontsize=size,
            color=colour, style="italic" if mark.kind == "surprise" else "normal",
            weight="bold" if mark.kind == "contact" else "normal",
        )  # fmt: skip


def _title(paper: Figure, episode: Episode, scenario: str) -> None:
    run, block, found = episode.run, episode.block, episode.estimates
    what = f"scenario {scenario}, seed {episode.seed}" if scenario else f"seed {episode.seed}"
    outcome = run.outcome.replace("_", " ")
    estimates = ",    ".join(
        [
            _measured("μ", found.mu, block.mu, ""),
            _measured("weight", found.weight_n, block.weight_n, " N"),
            _measured("stiffness", found.stiffness_n_per_m, block.stiffness_n_per_m, " N/m"),
        ]
    )
    why = "" if episode.discrete_success else run.message
    measured = "" if found.mu is found.weight_n is found.stiffness_n_per_m is None else estimates
    paper.text(LEFT, 0.972, f"{what}: {outcome}; in truth {_really(episode)}", fontsize=11.5, weight="bold", color=INK)
    for k, line in enumerate(filter(None, [why, measured])):
        paper.text(LEFT, 0.949 - 0.021 * k, line, fontsize=9.5, color=INK)


def _really(episode: Episode) -> str:
    """Return in few words what happened to the object, whatever the hand believes."""
    score, truth = episode.score, episode.truth
    if episode.world.missing:
        return "there was no object"
    if score.physical_success or score.dropped:
        return "dropped" if score.dropped else "lifted and replaced"
    if "remote_breakC*" not in episode.run.trace or truth.on_table.all():
        return "not lifted"
    if not truth.on_table[-1]:
        return "left in the air"
    return "not replaced" if score.lifted else "not lifted to Z"


def _measured(what: str, found: Estimate | None, truth: float, unit: str) -> str:
    """Return an estimate beside the truth, to the first digit of its uncertainty."""
    if found is None:
        return f"{what} not measured (truth {truth:.4g}{unit})"
    u = found.uncertainty
    digits = max(0, min(4, -math.floor(math.log10(u)))) if 0 < u < math.inf else 3
    return f"{what} {found.value:.{digits}f} ± {u:.{digits}f}{unit} (truth {truth:.{digits}f})"
