"""The Grasp-Lift-Replace task (GLR): fingers, two in the paper, grasp, lift, squeeze and replace an object.

From *A Discrete-Event Systems Approach to Modeling Dexterous Manipulation*, after the robotic task of Howe and
Cutkosky and the human one of Johansson and Westling.
"""

from __future__ import annotations

from thenar.errors import InputError, UnknownName
from thenar.library.glr import extended, slip
from thenar.library.glr.automata import adequate, finger, legal, nominal, reference, spec1, spec2, spec3, spec4
from thenar.library.glr.events import EVENTS, EXTENDED_EVENTS, check_fingers, events
from thenar.model.problem import Problem

__all__ = [
    "EVENTS",
    "EXTENDED_EVENTS",
    "VARIANTS",
    "adequate",
    "events",
    "extended",
    "finger",
    "legal",
    "nominal",
    "problem",
    "reference",
    "slip",
    "spec1",
    "spec2",
    "spec3",
    "spec4",
    "timed",
]

VARIANTS = ("paper", "extended", "timed")


def problem(variant: str = "paper", fingers: int = 2) -> Problem:
    """Return the task: the fingers as plants, the specifications (the third one a finger each).

    ``"paper"`` is the paper's; in ``"extended"`` the object can be dropped, a skill can take too long and a finger
    can touch what it should not, and two more specifications say what must follow; ``"timed"`` is :func:`timed`'s.

    The paper's task can be done with more ``fingers`` than its two: finger 1 is the thumb, and every other finger is
    its finger 2.

    * What acts on the object, or tells of it, is shared by all fingers, slip too: only one finger senses it.
    * What fingers 1 and 2 share before contact concerns the two, as the paper words it: each other finger shares its
      own three events with finger 1, which makes contact once it has been aligned with all (:func:`reference`).
    * Specifications 1 and 2 hold for each pair of finger 1 and another, 3 for each finger, 4 for the one object.

    So no automaton has more than 18 states, and n > 2 fingers need 5 n - 2 of them.  Except for the nine events of the
    object, and four of finger 1 itself, an event concerns one finger, or one and finger 1.

    Raises UnknownName for another variant, InputError for less than two fingers (one has nothing to be aligned with,
    and nothing to grip against), and for other than two in ``"extended"`` and ``"timed"``.

    >>> problem()
    Problem 'glr': 2 plants, 5 specs, 28 events (6 uncontrollable)
    >>> problem("extended")
    Problem 'glr(extended)': 2 plants, 7 specs, 33 events (11 uncontrollable)
    >>> problem(fingers=3)
    Problem 'glr(fingers=3)': 5 plants, 8 specs, 39 events (9 uncontrollable)
    """
    if variant not in VARIANTS:
        raise UnknownName("variant", variant, VARIANTS)
    check_fingers(fingers)
    if variant != "paper" and fingers != 2:
        raise InputError(f"the {variant} variant of glr has two fingers, not {fingers}; only the paper's can have more")
    if variant == "timed":
        return timed()
    if variant == "extended":
        return Problem(
            [extended.finger(1), extended.finger(2)],
            [extended.spec1(), spec2(), spec3(1), spec3(2), spec4(), extended.spec5(), extended.spec6()],
            name="glr(extended)",
            alphabet=EXTENDED_EVENTS,
            description="Two fingers grasp, lift, squeeze and replace an object, and come back if they fail.",
        )
    others = range(2, fingers + 1)
    return Problem(
        [
            finger(1, fingers),
            *(a for k in others for a in ([reference(k, fingers)] if fingers > 2 else []) + [finger(k, fingers)]),
        ],
        [
            *(spec1(k, fingers) for k in others),
            *(spec2(k, fingers) for k in others),
            *(spec3(i, fingers) for i in (1, *others)),
            spec4(fingers),
        ],
        name="glr" if fingers == 2 else f"glr(fingers={fingers})",
        alphabet=events(fingers),
        description=f"{'Two' if fingers == 2 else fingers} fingers grasp, lift, squeeze and replace an object, "
        "and learn its properties.",
    )


def timed() -> Problem:
    """Return the paper's task with slip at any time, forcible *inc_gripF** and a clock: section 7 of the paper.

    The self-loop of slip, which the paper had to remove, is back, and specification 4 wants each slip answered by more
    grip before it comes again.  Without forcing the load may never be applied, for slip might follow; with it, the
    supervisor answers every slip before the next tick.  Only :func:`supcon_forcing` knows of forcing: to
    :func:`synthesize` this is a problem like others, with *tick* one more uncontrollable event.

    >>> from thenar.explicit.forcing import supcon_forcing
    >>> from thenar.synthesis.api import synthesize
    >>> task = timed()
    >>> task
    Problem 'glr(timed)': 3 plants, 5 specs, 29 events (7 uncontrollable)
    >>> synthesize(task).size.states  # of a supervisor that never applies the load
    1756
    >>> supcon_forcing(task.plants, task.specs)
    ForcingSupervisor: 5,564 states, 17,284 transitions, 3,674 disablements, 162 states in which it forces
    """
    return Problem(
        [slip.finger(1), slip.finger(2), slip.sensor()],
        [spec1(), spec2(), spec3(1), spec3(2), slip.spec4()],
        name="glr(timed)",
        alphabet=slip.TIMED_EVENTS,
        description="Two fingers grasp, lift, squeeze and replace an object, and answer every slip in time.",
    )
