"""What the paper's alphabet leaves out: a lost object, a skill without an end, a touch where nothing should be.

With the paper's 28 events a block that is pulled out of the grasp leaves a perfect trace (*remote_makeC* fires when it
hits the table), and a missing object ends in silence.  Here five more events, none of them controllable, end
what the fingers do; two more specifications say what must follow.
"""

from __future__ import annotations

from thenar.library.glr import automata
from thenar.library.glr.automata import specification
from thenar.library.glr.events import EVENTS, EXTENDED_EVENTS
from thenar.model.automaton import Automaton

__all__ = ["RETRIES", "finger", "spec1", "spec5", "spec6"]

RETRIES = 2  # further attempts at the task after a failure; the third failure ends it, as in specifications 2 to 4

FREE = ("neutral", "approached", "misaligned", "aligned")
TOUCHING = ("contact", "stable", "bad_contact", "secured")
ON_TABLE = ("gripped", "loaded", "slipping")
IN_AIR = ("lifted", "grip_decreased", "friction_slip", "at_Z", "squeezed")
COMES_BACK = ("retract_finger_1", "retract_finger_2", "prox_breakC_1", "prox_breakC_2")
FAILURES = "timeout_1,timeout_2,unexpected_contact_1,unexpected_contact_2"


def finger(i: int) -> Automaton:
    """Return FINGERi with its failures: the paper's finger, and four states from which it can only come back.

    ``approach_i`` occurs when the finger has arrived, so it is still *neutral* while it is on its way.  From
    *failed_free* it retracts, from *failed_holding* and *failed_touching* it breaks contact, which also is what it
    does when the object is gone; until it does, what a *failed_holding* finger holds can still be lost.  A release
    that takes too long (*late*) is done again and ends the task like one in time.

    >>> finger(1)
    Automaton 'FINGER1': 22 states (2 marked), 68 transitions, 23 events
    """
    paper = automata.finger(i)
    return Automaton.from_transitions(
        [
            *paper.transitions(),
            *(f"{state} -timeout_{i}-> failed_free" for state in FREE),
            # not in "aligned": there the guarded move expects a contact
            *(f"{state} -unexpected_contact_{i}-> failed_free" for state in FREE if state != "aligned"),
            f"failed_free -retract_finger_{i}-> neutral",
            *(f"{state} -timeout_{i}-> failed_touching" for state in TOUCHING),
            *(f"{state} -timeout_{i}-> failed_holding" for state in (*ON_TABLE, *IN_AIR)),
            *(f"{state} -obj_dropped*-> failed_touching" for state in (*ON_TABLE, *IN_AIR, "failed_holding")),
            *(f"{state} -prox_breakC_{i}-> neutral" for state in ("failed_touching", "failed_holding")),
            # the way back of a finger that is well while the other one failed; the paper has it up to friction_slip
            *(f"{state} -prox_breakC_{i}-> neutral" for state in ("at_Z", "squeezed")),
            f"replaced -timeout_{i}-> late -prox_breakC_{i}-> released",
        ],
        initial="neutral",
        marked=["neutral", "released"],
        events=EXTENDED_EVENTS,
        name=paper.name,
        meaning=f"{paper.meaning}, and how it can fail",
    )


def spec1() -> Automaton:
    """Return specification 1, for which a finger that failed is out until it is back, wherever it was."""
    paper = automata.spec1()
    return specification(
        paper.name,
        f"{paper.meaning} A finger that failed is out until it is back.",
        "both_back",
        [
            *(f"{s} -{event}-> {t}" for s, event, t in paper.transitions()),
            *(
                f"{state} -timeout_{i},unexpected_contact_{i}-> {after}"
                for state, after_1, after_2 in (
                    ("both_back", "finger2_back", "finger1_back"),
                    ("finger1_out", "finger1_out", "both_out"),
                    ("finger1_back", "both_out", "finger1_back"),
                    ("finger2_back", "finger2_back", "both_out"),
                    ("both_out", "both_out", "both_out"),
                )
                for i, after in ((1, after_1), (2, after_2))
            ),
        ],
        EXTENDED_EVENTS,
    )


def spec5() -> Automaton:
    """Return specification 5: after a failure both fingers come back, and few failures are forgiven.

    Every report of a failure counts, also one while the fingers come back: an approach that fails before it occurs
    cannot be told from that.
    """
    onward = ",".join(e.name for e in EVENTS if e.controllable and e.name not in COMES_BACK)
    lines = []
    for k in range(RETRIES + 1):
        after = f"coming_back_{k + 1}" if k < RETRIES else "ended"
        lines += [
            f"failures_{k} -{onward}-> failures_{k}",
            f"failures_{k} -{FAILURES}-> {after}",
            f"failures_{k} -obj_dropped*-> ended",
        ]
        if k > 0:
            lines += [
                f"coming_back_{k} -approach_1-> failures_{k}",
                f"coming_back_{k} -{FAILURES}-> {after}",
                f"coming_back_{k} -obj_dropped*-> ended",
            ]
    return specification(
        "SPEC5",
        "After a timeout or an unexpected contact both fingers come back before anything else, and the task may be "
        f"tried again; after failure {RETRIES + 1}, or when the object is dropped, it ends.",
        "failures_0",
        [*lines, f"ended -{FAILURES},obj_dropped*-> ended"],
        EXTENDED_EVENTS,
    )


def spec6() -> Automaton:
    """Return specification 6: the object is not let go in the air as long as there is another way on."""
    return specification(
        "SPEC6",
        "The object is let go in the air only when it is lost or a skill did not end; then it is not approached again, "
        "for nobody knows where it lies.",
        "on_table",
        [
            "on_table -remote_breakC*-> in_air -remote_makeC*-> on_table",
            "on_table -approach_1,prox_breakC_1,prox_breakC_2,timeout_1,timeout_2,obj_dropped*-> on_table",
            "in_air -timeout_1,timeout_2,obj_dropped*-> failed_in_air",
            "failed_in_air -prox_breakC_1,prox_breakC_2,timeout_1,timeout_2,obj_dropped*-> failed_in_air",
        ],
        EXTENDED_EVENTS,
    )
