"""The Grasp-Lift-Replace task (GLR): two fingers grasp, lift, squeeze and replace an object.

From *A Discrete-Event Systems Approach to Modeling Dexterous Manipulation*, after the robotic task of Howe and
Cutkosky and the human one of Johansson and Westling.
"""

from __future__ import annotations

from thenar.library.glr.automata import adequate, finger, legal, spec1, spec2, spec3, spec4
from thenar.library.glr.events import EVENTS
from thenar.model.problem import Problem

__all__ = ["EVENTS", "adequate", "finger", "legal", "problem", "spec1", "spec2", "spec3", "spec4"]


def problem() -> Problem:
    """Return the task: both fingers as plants, the paper's four specifications (the third one a finger each).

    >>> problem()
    Problem 'glr': 2 plants, 5 specs, 28 events (6 uncontrollable)
    """
    return Problem(
        [finger(1), finger(2)],
        [spec1(), spec2(), spec3(1), spec3(2), spec4()],
        name="glr",
        alphabet=EVENTS,
        description="Two fingers grasp, lift, squeeze and replace an object, and learn its properties.",
    )
