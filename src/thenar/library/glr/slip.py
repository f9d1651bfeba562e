"""Slip as it is: it can come at any time while the object is held, and more grip must answer it before it comes again.

Section 7 of the paper says why its model has no self-loop of slip: slip without end and without more grip is illegal,
so controllability would end the task before slip could occur at all; the theory has no means to say that *inc_gripF**
must follow, only that it can.  Here the self-loop is back, and inc_gripF* is forcible: it preempts the tick of a clock.
"""

from __future__ import annotations

from dataclasses import replace

from thenar.explicit.timed import TICK
from thenar.library.glr import automata
from thenar.library.glr.automata import specification
from thenar.library.glr.events import EVENTS
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet

__all__ = ["TIMED_EVENTS", "finger", "sensor", "spec4"]

TIMED_EVENTS = Alphabet([TICK, *(replace(e, forcible=e.name == "inc_gripF*") for e in EVENTS)])

HELD = ("loaded", "lifted", "at_Z", "squeezed")
HANDLES = "dec_gripF*,move_to_Z*,stiffness_EP*,remote_makeC*"


def finger(i: int) -> Automaton:
    """Return FINGERi with the self-loop of slip that the paper had to remove: its *slipping* is *loaded* again.

    In each state that holds the object against gravity slip can come, once and again, and the grip can be increased.

    >>> finger(1)
    Automaton 'FINGER1': 16 states (2 marked), 37 transitions, 20 events
    """
    paper = automata.finger(i)
    removed = {"slipping": "loaded", "friction_slip": "grip_decreased"}
    return Automaton.from_transitions(
        [
            *(t for t in paper.transitions() if not removed.keys() & {t[0], t[2]}),
            *(f"{state} -incip_slip*,inc_gripF*-> {state}" for state in HELD),
            "grip_decreased -incip_slip*-> grip_decreased -inc_gripF*-> lifted",
        ],
        initial="neutral",
        marked=["neutral", "released"],
        events=TIMED_EVENTS,
        name=paper.name,
        meaning=f"{paper.meaning}, with slip at any time while it holds the object",
    )


def sensor() -> Automaton:
    """Return SENSOR, the slip sensor: having told of slip it tells of it again after a tick, or after more grip.

    >>> list(sensor().transitions())[:2]
    [('ready', 'tick', 'ready'), ('ready', 'inc_gripF*', 'ready')]
    """
    return Automaton.from_transitions(
        [
            "ready -incip_slip*-> has_told -tick,inc_gripF*-> ready",
            "ready -tick,inc_gripF*-> ready",
        ],
        initial="ready",
        marked=["ready", "has_told"],
        events=TIMED_EVENTS,
        name="SENSOR",
        meaning="how soon slip can be sensed again",
    )


def spec4() -> Automaton:
    """Return specification 4, which now also says that slip is answered by more grip, before it comes again.

    Until then nothing else is done with the object.  No answer is needed where the task ends: at the third slip while
    loading, and when a finger has lost contact.  Then both fingers return.
    """
    paper = automata.spec4()
    moved = {("not_loading", "incip_slip*"): "slip_0", ("not_loading", "inc_gripF*"): None}
    lines = [(s, event, moved.get((s, event), t)) for s, event, t in paper.transitions()]
    return specification(
        paper.name,
        "Slip is answered by an increase of the grip force before it comes again, and before anything else is done "
        f"with the object. {paper.meaning}",
        "not_loading",
        [
            *(f"{s} -{event}-> {t}" for s, event, t in lines if t is not None),
            "slip_0 -inc_gripF*-> not_loading",
            "slip_0 -approach_1-> not_loading",
            "slip_3 -incip_slip*-> slip_3",
            f"not_loading -{HANDLES}-> not_loading",
        ],
        TIMED_EVENTS,
    )
