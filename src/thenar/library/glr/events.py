"""The 28 events of the Grasp-Lift-Replace task, with the paper's meaning of each, and what the paper leaves out.

The order numbers the states.  The paper does not print its labels; this order fits the first state numbers
that it does print: finger 1's and the shared controllable events, finger 2's own, then the uncontrollable
ones.  A ``*`` marks an event that both fingers share.
"""

from __future__ import annotations

from thenar.model.events import Alphabet, Event

__all__ = ["EVENTS", "EXTENDED_EVENTS"]


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

_ALIGN = {"align_finger2*": "before contact, finger 2 takes its contact location from finger 1, the reference"}
_REALIGN = {"re-align_with_finger1*": "finger 2 is moved to a position opposite finger 1"}
_UNCONTROLLABLE_SHARED = {
    "incip_slip*": "incipient slip is sensed at a contact",
    "detect_misalignment*": "finger 2 is not lined up in space with finger 1",
}
_LEFT_OUT = {
    "obj_dropped*": "the object is lost out of the grasp",
    "timeout_1": "what finger 1, or both fingers together, do or wait for did not come in its time",
    "timeout_2": "what finger 2 alone does or waits for did not come in its time",
    "unexpected_contact_1": "finger 1 touches something while it moves free",
    "unexpected_contact_2": "finger 2 touches something while it moves free",
}


def _in_label_order() -> Alphabet:
    first = _own(1)
    approach = {"approach_1": first.pop("approach_1")}
    retract = {"retract_finger_1": first.pop("retract_finger_1")}
    controllable = approach | _ALIGN | retract | _REALIGN | first | _SHARED | _own(2)
    uncontrollable = _own_uncontrollable(1) | _own_uncontrollable(2) | _UNCONTROLLABLE_SHARED
    return Alphabet(
        [
            *(Event(name, meaning=meaning) for name, meaning in controllable.items()),
            *(Event(name, controllable=False, meaning=meaning) for name, meaning in uncontrollable.items()),
        ]
    )


EVENTS = _in_label_order()
EXTENDED_EVENTS = Alphabet([*EVENTS, *(Event(name, controllable=False, meaning=m) for name, m in _LEFT_OUT.items())])
