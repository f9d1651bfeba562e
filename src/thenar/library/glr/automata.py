"""The automata of the Grasp-Lift-Replace task: what a finger can do, and what the four specifications allow.

The paper prints them as figures, which are lost; these are rebuilt from its words and its published sizes.
See the page *The Grasp-Lift-Replace task* of the documentation for what is certain and what is not.
"""

from __future__ import annotations

from collections.abc import Iterable

from thenar.errors import InputError
from thenar.explicit.products import meet, selfloop, shuffle
from thenar.library.glr.events import EVENTS
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet

__all__ = ["adequate", "finger", "legal", "spec1", "spec2", "spec3", "spec4", "specification"]

ERROR_FREE = (
    "approach_1, approach_2, align_finger2*, prox_make_C1, prox_make_C2, suppress_vib1, suppress_vib2, "
    "orient_normal1, orient_normal2, apply_gripF*, apply_loadF*, remote_breakC*, dec_gripF*, incip_slip*, "
    "inc_gripF*, move_to_Z*, stiffness_EP*, remote_makeC*, prox_breakC_1, prox_breakC_2"
)


def finger(i: int) -> Automaton:
    """Return FINGERi, what finger ``i`` can do: the paper's Figure 4.  Finger 2 is finger 1 renamed.

    The upper half of the figure brings the finger into a secured contact, the paper's state X; the lower half
    lifts the object, measures it and puts it back.  Marked are the start, and the release after the task.

    >>> finger(1)
    Automaton 'FINGER1': 18 states (2 marked), 33 transitions, 20 events
    """
    if i not in (1, 2):
        raise InputError(f"the task has fingers 1 and 2, not {i!r}")
    approach_and_contact = [
        f"neutral -approach_{i}-> approached -align_finger2*-> aligned -prox_make_C{i}-> contact",
        "approached -detect_misalignment*-> misaligned -re-align_with_finger1*-> approached",
        *(f"{state} -retract_finger_{i}-> neutral" for state in ("approached", "misaligned", "aligned")),
        f"contact -suppress_vib{i}-> stable -orient_normal{i}-> secured",
        f"contact -unstable_contact_{i}-> bad_contact",
        f"stable -unstable_contact_{i},finger_{i}_obj_misalign-> bad_contact",
        f"bad_contact -prox_breakC_{i}-> neutral",
    ]
    lift_and_replace = [
        "secured -apply_gripF*-> gripped -apply_loadF*-> loaded -remote_breakC*-> lifted",
        "loaded -incip_slip*-> slipping -inc_gripF*-> loaded",
        "lifted -dec_gripF*-> grip_decreased -incip_slip*-> friction_slip -inc_gripF*-> lifted",
        f"lifted -move_to_Z*-> at_Z -stiffness_EP*-> squeezed -remote_makeC*-> replaced -prox_breakC_{i}-> released",
    ]
    give_up = ("secured", "gripped", "loaded", "slipping", "lifted", "grip_decreased", "friction_slip")
    return Automaton.from_transitions(
        [*approach_and_contact, *lift_and_replace, *(f"{state} -prox_breakC_{i}-> neutral" for state in give_up)],
        initial="neutral",
        marked=["neutral", "released"],
        events=EVENTS,
        name=f"FINGER{i}",
        meaning=f"what finger {i} can do",
    )


def spec1() -> Automaton:
    """Return specification 1: finger 1 approaches the object before finger 2.

    Once a finger is back both come back before a new approach, so the order holds for every attempt.
    """
    return specification(
        "SPEC1",
        "Finger 1 approaches the object before finger 2.",
        "both_back",
        [
            "both_back -approach_1-> finger1_out -approach_2-> both_out",
            "finger1_out -retract_finger_1,prox_breakC_1-> both_back",
            "both_out -retract_finger_1,prox_breakC_1-> finger1_back -retract_finger_2,prox_breakC_2-> both_back",
            "both_out -retract_finger_2,prox_breakC_2-> finger2_back -retract_finger_1,prox_breakC_1-> both_back",
        ],
    )


def spec2() -> Automaton:
    """Return specification 2: at most two consecutive attempts, per approach, to align the fingers."""
    states = ["aligned_0", "misaligned_1", "realigned_1", "misaligned_2", "realigned_2", "misaligned_3"]
    return specification(
        "SPEC2",
        "Only two consecutive attempts, per approach, are allowed for aligning the fingers before contact.",
        "aligned_0",
        [
            "aligned_0 -detect_misalignment*-> misaligned_1 -re-align_with_finger1*-> realigned_1",
            "realigned_1 -detect_misalignment*-> misaligned_2 -re-align_with_finger1*-> realigned_2",
            "realigned_2 -detect_misalignment*-> misaligned_3",
            *(f"{state} -approach_1-> aligned_0" for state in states),
        ],
    )


def spec3(i: int) -> Automaton:
    """Return finger ``i``'s half of specification 3; the specification is the shuffle of both halves."""
    return specification(
        f"SPEC3_{i}",
        f"After the third unsuccessful attempt of finger {i} to make contact the task ends.",
        "failures_0",
        [f"failures_{k} -unstable_contact_{i}-> failures_{k + 1}" for k in range(3)],
    )


def spec4() -> Automaton:
    """Return specification 4: at most two adjustments of the grip force if slip follows the load force."""
    loading = ["loading", "slip_1", "adjusted_1", "slip_2", "adjusted_2", "slip_3"]
    return specification(
        "SPEC4",
        "If incipient slip is detected just after the load force is applied, the grip force may be adjusted twice; "
        "if slip is sensed a third time, the task ends and both fingers return.",
        "not_loading",
        [
            "not_loading -apply_loadF*-> loading",
            "not_loading -incip_slip*,inc_gripF*,remote_breakC*-> not_loading",
            "loading -incip_slip*-> slip_1 -inc_gripF*-> adjusted_1",
            "adjusted_1 -incip_slip*-> slip_2 -inc_gripF*-> adjusted_2 -incip_slip*-> slip_3",
            *(f"{state} -remote_breakC*-> not_loading" for state in ("loading", "adjusted_1", "adjusted_2")),
            *(f"{state} -approach_1-> not_loading" for state in ("not_loading", *loading)),
        ],
    )


def legal() -> Automaton:
    """Return E = Spec1 ∩ Spec2 ∩ Spec3 ∩ Spec4, each with all other events self-looped, as the paper forms it."""
    specs = [spec1(), spec2(), shuffle(spec3(1), spec3(2), name="SPEC3"), spec4()]
    return meet(*(selfloop(s, [e for e in EVENTS if e.name not in s.alphabet]) for s in specs), name="E")


def adequate() -> Automaton:
    """Return A, the minimally adequate language: the task without an error, from start to release."""
    names = ERROR_FREE.split(", ")
    return Automaton.from_transitions(
        [(str(k), event, str(k + 1)) for k, event in enumerate(names)],
        initial="0",
        marked=[str(len(names))],
        events=EVENTS,
        name="A",
        meaning="the task without an error",
    )


def specification(
    name: str, says: str, initial: str, transitions: Iterable[str], events: Alphabet = EVENTS
) -> Automaton:
    """Return a specification, every state of which is marked: it says what may happen, not when the task is done.

    >>> specification("ONCE", "The fingers are aligned once.", "0", ["0 -align_finger2*-> 1"])
    Automaton 'ONCE': 2 states (2 marked), 1 transition, 1 event
    """
    lines = list(transitions)
    unmarked = Automaton.from_transitions(lines, initial=initial, events=events)
    states = [unmarked.states[q] for q in range(unmarked.n_states)]
    return Automaton.from_transitions(lines, initial=initial, marked=states, events=events, name=name, meaning=says)
