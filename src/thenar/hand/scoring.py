"""The scorer: what really happened, from the physics' own trajectory.  The only reader of the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from thenar.hand.skills import LIFT_HEIGHT
from thenar.hand.slip import SLIP_FRACTION
from thenar.hand.world import CROWN, ELEMENTS, FACE, HALF_HEIGHT, PITCH, World
from thenar.runtime.run import Run

__all__ = ["Score", "Truth", "score"]

LIFTED_WITHIN_M = 1e-3
REPLACED_WITHIN_M = 2e-3
UPRIGHT_RAD = 0.02
DROPPED_M = 3e-3  # that the object slides through the fingers while they hold it
SLID_M = 5e-7  # that an element must slide further than the one that slides least: then it slips, and that one sticks
GROSS_M = 1e-5  # or that it must slide within RECENT_MS, when all slide: a pad that rolls moves by less
RECENT_MS = 50
CLEAR_M = 1e-6  # of air under the block
CORE_HALF_WIDTH = 0.014
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Truth:
    """The truth over time, a row for each millisecond.

    ``height_m``: (n,) how far the block is above where it stood; ``aside_m``: (n,) sideways; ``tilt_rad``: (n,);
    ``on_table``: (n,) bool; ``slid_m``: (n, 2, 7) how far each element of each pad is along its plate.
    """

    height_m: Floats
    aside_m: Floats
    tilt_rad: Floats
    on_table: NDArray[np.bool_]
    slid_m: Floats


@dataclass(frozen=True, slots=True)
class Score:
    """How an episode went, physically.  Lengths in metres, latencies in milliseconds."""

    physical_success: bool
    lifted: bool
    replaced: bool
    dropped: bool
    lift_error_m: float | None
    replace_error_m: float
    slip_before_detection_m: float
    latency_ms: dict[str, list[float]] = field(default_factory=dict)
    early_slips: int = 0  # reported before a quarter of the elements slid by more than SLID_M


def truth(world: World) -> Truth:
    """Return the truth over time."""
    q = {name: world.trajectory[:, column] for name, column in world.joints.items()}
    tilt = q["block_pitch"]
    lowest = q["block_z"] - CORE_HALF_WIDTH * np.abs(np.sin(tilt)) - HALF_HEIGHT * (np.cos(tilt) - 1.0)
    slid = np.stack([_slid(world, q, i) for i in (1, 2)], axis=1)
    there = np.arange(world.ticks) < (world.ticks if world.table_gone_tick is None else world.table_gone_tick)
    return Truth(q["block_z"], q["block_x"], tilt, there & (lowest <= CLEAR_M), slid)


def _slid(world: World, q: dict[str, Floats], i: int) -> Floats:
    """Return where each element of finger ``i`` is along its plate: (n, 7) float64, m."""
    side = -1.0 if i == 1 else 1.0
    block, tilt = world.block, q["block_pitch"]
    # plate: on the core, that stands at the block's place and turns with it
    x = side * (FACE - 0.002) + q[f"plate_{i}"]
    start = 10.0 if world.missing else block.x_m
    plate_x = start + q["block_x"] + np.cos(tilt) * x
    plate_z = HALF_HEIGHT + block.table_height_m + q["block_z"] - np.sin(tilt) * x
    face = tilt + block.face_tilt_rad
    along = np.sin(face), np.cos(face)  # the plate's own upward direction
    pitch = q[f"pitch_{i}"]
    middle = (ELEMENTS - 1) / 2
    found = np.empty((len(tilt), ELEMENTS))
    for k in range(ELEMENTS):
        away = (k - middle) / middle
        u = side * (0.0015 + CROWN * away**2) - side * q[f"normal_{i}_{k}"]
        w = (k - middle) * PITCH + q[f"shear_{i}_{k}"]
        ex = q[f"position_x_{i}"] + np.cos(pitch) * u + np.sin(pitch) * w
        ez = q[f"position_z_{i}"] - np.sin(pitch) * u + np.cos(pitch) * w
        found[:, k] = (ex - plate_x) * along[0] + (ez - plate_z) * along[1]
    return found


def score(run: Run, truth: Truth) -> Score:
    """Compare what the hand reported with what happened."""
    last = len(truth.height_m) - 1
    times = [(entry["event"], min(round(entry["t"] * 1000), last)) for entry in run.entries if entry["kind"] == "event"]
    when = {event: [k for name, k in times if name == event] for event, _ in times}
    lift_error = None
    if "move_to_Z*" in when:
        lift_error = float(truth.height_m[when["move_to_Z*"][-1]] - LIFT_HEIGHT)
    # replaced: where it stood before the last attempt; what shook it before is not the hand's doing
    attempts = [round(e["t"] * 1000) for e in run.entries if e["kind"] == "start" and e["event"] == "approach_1"]
    stood = min(attempts[-1], last) if attempts else 0
    moved = truth.aside_m[-1] - truth.aside_m[stood], truth.height_m[-1] - truth.height_m[stood]
    replace_error = float(np.hypot(*moved))
    lifted = lift_error is not None and abs(lift_error) <= LIFTED_WITHIN_M
    upright = abs(float(truth.tilt_rad[-1])) <= UPRIGHT_RAD
    replaced = replace_error <= REPLACED_WITHIN_M and upright and bool(truth.on_table[-1])
    dropped = _dropped(truth, run, when)

    def begun(event: str) -> list[int]:
        return [round(e["t"] * 1000) for e in run.entries if e["kind"] == "start" and e["event"] == event]

    slips = _slips(run, truth)
    latency = {
        "incip_slip*": [late for late, _ in slips if late is not None],
        "remote_breakC*": _after(~truth.on_table, when.get("remote_breakC*", []), begun("remote_breakC*")),
        "remote_makeC*": _after(truth.on_table, when.get("remote_makeC*", []), begun("remote_makeC*")),
    }
    slid = max((distance for _, distance in slips), default=0.0)
    return Score(
        lifted and replaced and not dropped,
        lifted,
        replaced,
        dropped,
        lift_error,
        replace_error,
        slid,
        {event: values for event, values in latency.items() if values},
        sum(late is None for late, _ in slips),
    )


def _dropped(truth: Truth, run: Run, when: dict[str, list[int]]) -> bool:
    """Whether the object slid through the fingers in the air, or was let go of there."""
    last = len(truth.on_table) - 1
    opened = [
        min(round(e["t"] * 1000), last)
        for e in run.entries
        if e["kind"] == "start" and e["event"].startswith("prox_breakC")
    ]
    for lifted in when.get("remote_breakC*", []):
        landed = np.flatnonzero(truth.on_table[lifted:])
        down = lifted + int(landed[0]) if len(landed) else last
        held = np.median(truth.slid_m[lifted : min([down, *(k for k in opened if k > lifted)]) + 1], axis=2)
        if np.abs(held - held[0]).max() > DROPPED_M:
            return True
        free = [k for name in ("prox_breakC_1", "prox_breakC_2") for k in when.get(name, []) if lifted < k < down]
        if free:
            return True
    return False


def _after(condition: NDArray[np.bool_], reports: list[int], begun: Sequence[int] = ()) -> list[float]:
    """Return how long before each report the condition became true, in ms; only where it was false before.

    What was true before somebody looked, from the last of ``begun`` on, counts from there.
    """
    found = []
    for k in reports:
        false_before = np.flatnonzero(~condition[: k + 1])
        if len(false_before) and condition[k]:
            onset = max(int(false_before[-1]) + 1, *(b for b in begun if b <= k), 0)
            found.append(float(k - onset))
    return found


def _slips(run: Run, truth: Truth) -> list[tuple[float | None, float]]:
    """Return for each slip event its latency (ms) and how far the object had slid through the fingers (m)."""
    found, armed = [], 0
    last = len(truth.height_m) - 1
    for entry in run.entries:
        k = min(round(entry["t"] * 1000), last)
        if entry["kind"] == "event" and entry["event"] == "incip_slip*":
            moved = np.abs(truth.slid_m[armed : k + 1] - truth.slid_m[armed])
            pad = moved[:, 0]
            further = pad > pad.min(axis=1, keepdims=True) + SLID_M
            before = np.maximum(np.arange(len(pad)) - RECENT_MS, 0)
            along = truth.slid_m[armed : k + 1, 0]
            gross = np.abs(along - along[before]) > GROSS_M
            sliding = (further | gross).mean(axis=1) >= SLIP_FRACTION
            onset = _after(sliding, [k - armed])
            found.append((onset[0] if onset else None, float(np.median(moved[-1], axis=1).max())))
            armed = k
        elif entry["kind"] == "start":
            armed = k
    return found
