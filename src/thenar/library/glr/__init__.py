"""The Grasp-Lift-Replace task (GLR): two fingers grasp, lift, squeeze and replace an object.

From *A Discrete-Event Systems Approach to Modeling Dexterous Manipulation*, after the robotic task of Howe and
Cutkosky and the human one of Johansson and Westling.
"""

from __future__ import annotations

from thenar.errors import InputError, UnknownName
from thenar.library.glr import extended
from thenar.library.glr.automata import adequate, finger, legal, spec1, spec2, spec3, spec4
from thenar.library.glr.events import EVENTS, EXTENDED_EVENTS
from thenar.model.problem import Problem

__all__ = [
    "EVENTS",
    "EXTENDED_EVENTS",
    "VARIANTS",
    "adequate",
    "extended",
    "finger",
    "legal",
    "problem",
    "spec1",
    "spec2",
    "spec3",
    "spec4",
]

VARIANTS = ("paper", "extended")


def problem(variant: str = "paper") -> Problem:
    """Return the task: both fingers as plants, the specifications (the third one a finger each).

    ``"paper"`` is the paper's; in ``"extended"`` the object can be dropped, a skill can take too long and a finger
    can touch what it should not, and two more specifications say what must follow.

    Raises UnknownName for another variant, InputError for ``"timed"``, which is yet to come.

    >>> problem()
    Problem 'glr': 2 plants, 5 specs, 28 events (6 uncontrollable)
    >>> problem("extended")
    Problem 'glr(extended)': 2 plants, 7 specs, 33 events (11 uncontrollable)
    """
    if variant == "timed":
        raise InputError("the timed variant of glr needs timed automata, which thenar does not have yet")
    if variant not in VARIANTS:
        raise UnknownName("variant", variant, VARIANTS)
    if variant == "extended":
        return Problem(
            [extended.finger(1), extended.finger(2)],
            [extended.spec1(), spec2(), spec3(1), spec3(2), spec4(), extended.spec5(), extended.spec6()],
            name="glr(extended)",
            alphabet=EXTENDED_EVENTS,
            description="Two fingers grasp, lift, squeeze and replace an object, and come back if they fail.",
        )
    return Problem(
        [finger(1), finger(2)],
        [spec1(), spec2(), spec3(1), spec3(2), spec4()],
        name="glr",
        alphabet=EVENTS,
        description="Two fingers grasp, lift, squeeze and replace an object, and learn its properties.",
    )
