"""The automata of the Grasp-Lift-Replace task: what a finger can do, and what the four specifications allow.

The paper prints them as figures, which are lost; these are rebuilt from its words and its published sizes.
See the page *The Grasp-Lift-Replace task* of the documentation for what is certain and what is not.

The paper has two ``fingers``.  With more, each further finger is finger 2 renamed, and what the paper says of
fingers 1 and 2 is said of finger 1 and each other one, in an automaton for each pair: none grows with their number.
"""

from __future__ import annotations

from collections.abc import Iterable

from thenar.explicit.products import meet, selfloop, shuffle
from thenar.library.glr.events import EVENTS, alignment, check_finger, check_fingers, events
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.trace import Trace

__all__ = [
    "ERROR_FREE",
    "adequate",
    "finger",
    "legal",
    "nominal",
    "reference",
    "spec1",
    "spec2",
    "spec3",
    "spec4",
    "specification",
]

ERROR_FREE = (  # the paper's A, as printed
    "approach_1, approach_2, align_finger2*, prox_make_C1, prox_make_C2, suppress_vib1, suppress_vib2, "
    "orient_normal1, orient_normal2, apply_gripF*, apply_loadF*, remote_breakC*, dec_gripF*, incip_slip*, "
    "inc_gripF*, move_to_Z*, stiffness_EP*, remote_makeC*, prox_breakC_1, prox_breakC_2"
)


def finger(i: int, fingers: int = 2) -> Automaton:
    """Return FINGERi, what finger ``i`` can do: the paper's Figure 4.  Finger 2 is finger 1 renamed.

    The upper half of the figure brings the finger into a secured contact, the paper's state X; the lower half
    lifts the object, measures it and puts it back.  Marked are the start, and the release after the task.

    Of more than two fingers each is aligned with finger 1, one at a time and in any order.  Finger 1 alone would
    need a state for each set of fingers that are aligned already, so its part in the alignments is not in FINGER1, but
    in one :func:`reference` for each other finger.

    Raises InputError unless the task has a finger ``i``.

    >>> finger(1)
    Automaton 'FINGER1': 18 states (2 marked), 33 transitions, 20 events
    >>> finger(1, fingers=3)
    Automaton 'FINGER1': 16 states (2 marked), 28 transitions, 17 events
    """
    check_finger(i, fingers)
    if i == 1 and fingers > 2:
        approach = ["neutral -approach_1-> approached -prox_make_C1-> contact"]
        can_retract: tuple[str, ...] = ("approached",)
    else:
        aligned, misaligned, realigned = alignment(max(i, 2), fingers)
        approach = [
            f"neutral -approach_{i}-> approached -{aligned}-> aligned -prox_make_C{i}-> contact",
            f"approached -{misaligned}-> misaligned -{realigned}-> approached",
        ]
        can_retract = ("approached", "misaligned", "aligned")
    approach_and_contact = [
        *approach,
        *(f"{state} -retract_finger_{i}-> neutral" for state in can_retract),
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
        events=events(fingers),
        name=f"FINGER{i}",
        meaning=f"what finger {i} can do",
    )


def reference(k: int, fingers: int) -> Automaton:
    """Return REFERENCEk, finger 1's part in the alignment of finger ``k``, of more than two.

    Finger 1 is the reference for all others: once it has approached it can be aligned with each of them, and it can
    make contact when it is with all.  FINGER1 || REFERENCE2 is the FINGER1 of the paper's task.

    >>> reference(3, fingers=3)
    Automaton 'REFERENCE3': 4 states (1 marked), 8 transitions, 6 events
    """
    aligned, misaligned, realigned = alignment(k, fingers)
    return Automaton.from_transitions(
        [
            f"idle -approach_1-> approached -{aligned}-> aligned -prox_make_C1-> idle",
            f"approached -{misaligned}-> misaligned -{realigned}-> approached",
            *(f"{state} -retract_finger_1-> idle" for state in ("approached", "misaligned", "aligned")),
        ],
        initial="idle",
        marked=["idle"],
        events=events(fingers),
        name=f"REFERENCE{k}",
        meaning=f"what finger 1 can do as the reference for finger {k}",
    )


def spec1(k: int = 2, fingers: int = 2) -> Automaton:
    """Return specification 1 for finger ``k``: finger 1 approaches the object before it.

    Once one of the two is back both come back before a new approach, so the order holds for every attempt.  In which
    order the others follow finger 1 is left open.
    """
    check_finger(k, fingers, least=2)
    return specification(
        _numbered("SPEC1", k, fingers),
        f"Finger 1 approaches the object before finger {k}.",
        "both_back",
        [
            f"both_back -approach_1-> finger1_out -approach_{k}-> both_out",
            "finger1_out -retract_finger_1,prox_breakC_1-> both_back",
            f"both_out -retract_finger_1,prox_breakC_1-> finger1_back -retract_finger_{k},prox_breakC_{k}-> both_back",
            f"both_out -retract_finger_{k},prox_breakC_{k}-> finger{k}_back "
            "-retract_finger_1,prox_breakC_1-> both_back",
        ],
        events(fingers),
    )


def spec2(k: int = 2, fingers: int = 2) -> Automaton:
    """Return specification 2 for finger ``k``: at most two consecutive attempts, per approach, to align it."""
    _, misaligned, realigned = alignment(k, fingers)
    states = ["aligned_0", "misaligned_1", "realigned_1", "misaligned_2", "realigned_2", "misaligned_3"]
    whom = "the fingers" if fingers == 2 else f"finger {k} with finger 1"
    return specification(
        _numbered("SPEC2", k, fingers),
        f"Only two consecutive attempts, per approach, are allowed for aligning {whom} before contact.",
        "aligned_0",
        [
            f"aligned_0 -{misaligned}-> misaligned_1 -{realigned}-> realigned_1",
            f"realigned_1 -{misaligned}-> misaligned_2 -{realigned}-> realigned_2",
            f"realigned_2 -{misaligned}-> misaligned_3",
            *(f"{state} -approach_1-> aligned_0" for state in states),
        ],
        events(fingers),
    )


def spec3(i: int, fingers: int = 2) -> Automaton:
    """Return finger ``i``'s part of specification 3; the specification is the shuffle of all fingers' parts."""
    check_finger(i, fingers)
    return specification(
        f"SPEC3_{i}",
        f"After the third unsuccessful attempt of finger {i} to make contact the task ends.",
        "failures_0",
        [f"failures_{k} -unstable_contact_{i}-> failures_{k + 1}" for k in range(3)],
        events(fingers),
    )


def spec4(fingers: int = 2) -> Automaton:
    """Return specification 4: at most two adjustments of the grip force if slip follows the load force."""
    check_fingers(fingers)
    loading = ["loading", "slip_1", "adjusted_1", "slip_2", "adjusted_2", "slip_3"]
    return specification(
        "SPEC4",
        "If incipient slip is detected just after the load force is applied, the grip force may be adjusted twice; "
        f"if slip is sensed a third time, the task ends and {'both' if fingers == 2 else 'all'} fingers return.",
        "not_loading",
        [
            "not_loading -apply_loadF*-> loading",
            "not_loading -incip_slip*,inc_gripF*,remote_breakC*-> not_loading",
            "loading -incip_slip*-> slip_1 -inc_gripF*-> adjusted_1",
            "adjusted_1 -incip_slip*-> slip_2 -inc_gripF*-> adjusted_2 -incip_slip*-> slip_3",
            *(f"{state} -remote_breakC*-> not_loading" for state in ("loading", "adjusted_1", "adjusted_2")),
            *(f"{state} -approach_1-> not_loading" for state in ("not_loading", *loading)),
        ],
        events(fingers),
    )


def _numbered(name: str, k: int, fingers: int) -> str:
    """Return the name of finger ``k``'s part of a specification of which the paper's two fingers need only one."""
    return name if fingers == 2 else f"{name}_{k}"


def legal() -> Automaton:
    """Return E = Spec1 ∩ Spec2 ∩ Spec3 ∩ Spec4, each with all other events self-looped, as the paper forms it."""
    specs = [spec1(), spec2(), shuffle(spec3(1), spec3(2), name="SPEC3"), spec4()]
    return meet(*(selfloop(s, [e for e in EVENTS if e.name not in s.alphabet]) for s in specs), name="E")


def nominal(fingers: int = 2) -> Trace:
    """Return the 6 n + 8 events of the task without an error, the fingers one after the other in each step.

    >>> nominal() == Trace(ERROR_FREE)
    True
    >>> len(nominal(3)), nominal(3)[:5]
    (26, Trace('approach_1, approach_2, approach_3, align_finger2*, align_finger3*'))
    """
    check_fingers(fingers)
    numbers = range(1, fingers + 1)
    return Trace(
        [
            *(f"approach_{i}" for i in numbers),
            *(f"align_finger{k}*" for k in numbers[1:]),
            *(f"{step}{i}" for step in ("prox_make_C", "suppress_vib", "orient_normal") for i in numbers),
            *("apply_gripF*", "apply_loadF*", "remote_breakC*", "dec_gripF*", "incip_slip*", "inc_gripF*"),
            *("move_to_Z*", "stiffness_EP*", "remote_makeC*"),
            *(f"prox_breakC_{i}" for i in numbers),
        ]
    )


def adequate(fingers: int = 2) -> Automaton:
    """Return A, the minimally adequate language: the task without an error, from start to release."""
    names = nominal(fingers)
    return Automaton.from_transitions(
        [(str(k), event, str(k + 1)) for k, event in enumerate(names)],
        initial="0",
        marked=[str(len(names))],
        events=events(fingers),
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
