"""The events of the Grasp-Lift-Replace task, with the paper's meaning of each, and what the paper leaves out.

The order numbers the states.  The paper does not print its labels; this order fits the first state numbers
that it does print: finger 1's and the shared controllable events, finger 2's own, then the uncontrollable
ones.  A ``*`` marks an event that fingers share: all of them, or in an alignment finger 1 and one other.
"""

from __future__ import annotations

from functools import cache

from thenar.errors import InputError
from thenar.library.classics.arguments import check_count
from thenar.model.events import Alphabet, Event

__all__ = ["EVENTS", "EXTENDED_EVENTS", "LEAST", "alignment", "check_finger", "check_fingers", "events"]

LEAST = 2  # finger 1 is the reference with which a finger is aligned, and the object is gripped between fingers


def events(fingers: int = 2) -> Alphabet:
    """Return the 11 n + 6 events of a task with n fingers, 3 n of them uncontrollable; for two, the paper's 28.

    A finger has eight events of its own and each finger but the first three of its alignment with finger 1;
    nine are shared by all, for they act on the object, or tell of it.

    Raises InputError for fewer than two fingers.

    >>> events() == EVENTS, len(events(3))
    (True, 39)
    >>> [e.name for e in events(3) if "3" in e.name][:4]
    ['align_finger3*', 're-align_finger3_with_finger1*', 'approach_3', 'retract_finger_3']
    """
    check_fingers(fingers)
    return _in_label_order(fingers)


def alignment(k: int, fingers: int = 2) -> tuple[str, str, str]:
    """Return the events that fingers 1 and ``k`` share before contact: aligned, found misaligned, re-aligned.

    The paper's name of the first one says which finger it is that is aligned; those of the other two need not, with
    two fingers, and do with more.

    >>> alignment(2)
    ('align_finger2*', 'detect_misalignment*', 're-align_with_finger1*')
    >>> alignment(2, fingers=3)
    ('align_finger2*', 'detect_misalignment_2*', 're-align_finger2_with_finger1*')
    """
    check_finger(k, fingers, least=2)
    if fingers == 2:
        return "align_finger2*", "detect_misalignment*", "re-align_with_finger1*"
    return f"align_finger{k}*", f"detect_misalignment_{k}*", f"re-align_finger{k}_with_finger1*"


def check_fingers(fingers: object) -> None:
    """Raise InputError unless a task can have ``fingers`` fingers.

    >>> check_fingers(1)
    Traceback (most recent call last):
    thenar.errors.InputError: glr: fingers must be a whole number of fingers, at least 2, not 1
    """
    check_count("glr", "fingers", fingers, least=LEAST, things="fingers")


def check_finger(i: int, fingers: int, least: int = 1) -> None:
    """Raise InputError unless ``i`` is one of the fingers from ``least`` on."""
    check_fingers(fingers)
    if i not in range(least, fingers + 1):
        if least > 1:
            raise InputError(f"finger {i!r} of {fingers} is not aligned with finger 1; fingers from 2 on are")
        raise InputError(f"the task has {'fingers 1 and 2' if fingers == 2 else f'fingers 1 to {fingers}'}, not {i!r}")


def _own(i: int) -> dict[str, str]:
    """Return the controllable events of finger ``i`` alone."""
    return {
        f"approach_{i}": f"finger {i} approaches the object",
        f"retract_finger_{i}": f"finger {i} is withdrawn from the proposed contact location; no contact was made",
        f"prox_make_C{i}": f"finger {i} makes contact with the object",
        f"prox_breakC_{i}": f"finger {i} is retracted, and its contact with the object ends",
        f"suppress_vib{i}": f"the contact vibration between finger {i} and the object is suppressed",
        f"orient_normal{i}": f"finger {i} is rotated at the contact until it is normal to the object",
    }


def _own_uncontrollable(i: int) -> dict[str, str]:
    return {
        f"unstable_contact_{i}": f"the contact vibration of finger {i} cannot be suppressed; "
        "its contact is not stable enough to continue",
        f"finger_{i}_obj_misalign": f"finger {i} cannot be oriented normally to the object",
    }


_SHARED = {
    "apply_gripF*": "a horizontal force secures the object between the fingers",
    "apply_loadF*": "a vertical force is applied to overcome gravity",
    "inc_gripF*": "the grip force is increased by one increment, in response to slip",
    "remote_breakC*": "the object has broken contact with the table",
    "dec_gripF*": "the grip force is decreased to provoke incipient slip, which gives the coefficient of friction",
    "move_to_Z*": "the object is lifted to a given height",
    "stiffness_EP*": "the stiffness exploratory procedure: the object is squeezed, its deformation measured",
    "remote_makeC*": "the object is in contact with the table again",
}
_SHARED_UNCONTROLLABLE = {"incip_slip*": "incipient slip is sensed at a contact"}
_LEFT_OUT = {
    "obj_dropped*": "the object is lost out of the grasp",
    "timeout_1": "what finger 1, or both fingers together, do or wait for did not come in its time",
    "timeout_2": "what finger 2 alone does or waits for did not come in its time",
    "unexpected_contact_1": "finger 1 touches something while it moves free",
    "unexpected_contact_2": "finger 2 touches something while it moves free",
}


@cache
def _in_label_order(fingers: int) -> Alphabet:
    first = _own(1)
    approach = {"approach_1": first.pop("approach_1")}
    retract = {"retract_finger_1": first.pop("retract_finger_1")}
    others = range(2, fingers + 1)
    aligned, misaligned, realigned = zip(*(alignment(k, fingers) for k in others), strict=True)
    align = {
        e: f"before contact, finger {k} takes its contact location from finger 1, the reference"
        for k, e in zip(others, aligned, strict=True)
    }
    realign = {
        e: f"finger {k} is moved to a position opposite finger 1" for k, e in zip(others, realigned, strict=True)
    }
    detect = {e: f"finger {k} is not lined up in space with finger 1" for k, e in zip(others, misaligned, strict=True)}
    controllable = approach | align | retract | realign | first | _SHARED
    uncontrollable = _own_uncontrollable(1)
    for k in others:
        controllable |= _own(k)
        uncontrollable |= _own_uncontrollable(k)
    uncontrollable |= _SHARED_UNCONTROLLABLE | detect
    return Alphabet(
        [
            *(Event(name, meaning=meaning) for name, meaning in controllable.items()),
            *(Event(name, controllable=False, meaning=meaning) for name, meaning in uncontrollable.items()),
        ]
    )


EVENTS = events(2)
EXTENDED_EVENTS = Alphabet([*EVENTS, *(Event(name, controllable=False, meaning=m) for name, m in _LEFT_OUT.items())])
