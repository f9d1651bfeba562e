"""The phases of the task: which one an event begins, as in the paper's Figure 2."""

from __future__ import annotations

__all__ = ["PHASES", "phase_after"]

PHASES = {
    "approach_1": "approach",
    "prox_make_C1": "loading",
    "prox_make_C2": "loading",
    "apply_loadF*": "loading",
    "remote_breakC*": "manipulation",
    "move_to_Z*": "squeezing",
    "stiffness_EP*": "replace",
    "remote_makeC*": "unloading",
    "prox_breakC_1": "release",
    "prox_breakC_2": "release",
    "retract_finger_1": "approach",
    "retract_finger_2": "approach",
}
"""Event -> the phase that begins when it has happened."""


def phase_after(event: str | None, phase: str = "approach") -> str:
    """Return the phase after ``event``, given the one before it.

    >>> phase_after("remote_breakC*"), phase_after("incip_slip*", "loading")
    ('manipulation', 'loading')
    """
    return PHASES.get(event or "", phase)
