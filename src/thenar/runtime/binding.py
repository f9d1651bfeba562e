"""Binding: every event of the model has its skill or its detector, or nothing moves."""

from __future__ import annotations

from thenar.errors import Mistake, ModelError, did_you_mean
from thenar.explicit.timed import TICK
from thenar.model.events import Alphabet
from thenar.runtime.driver import Driver

__all__ = ["TIMEOUT", "check_binding", "timeout_event"]

TIMEOUT = "timeout_"  # and the finger: the watchdog's own uncontrollable events


def timeout_event(finger: int) -> str:
    """Return the watchdog's event for ``finger``; what both fingers do together is finger 1's.

    >>> timeout_event(0), timeout_event(2)
    ('timeout_1', 'timeout_2')
    """
    return f"{TIMEOUT}{finger or 1}"


def check_binding(alphabet: Alphabet, driver: Driver) -> None:
    """Raise ModelError with every event of ``alphabet`` that ``driver`` cannot do or sense; O(|Σ|).

    A controllable event needs a skill; an uncontrollable one needs a detector, unless it is a watchdog's
    (``timeout_1``).  ``tick`` is the clock's, and must not be controllable.  Skills and detectors for other events do
    no harm.

    >>> check_binding(Alphabet(["lift"]), type("Hand", (), {"skills": {"lift*": None}, "detectors": {}}))
    Traceback (most recent call last):
    thenar.errors.ModelError: event 'lift': controllable, but the driver has no skill for it; did you mean 'lift*'?
    """
    mistakes = []
    for event in alphabet:
        kind, what, known = (
            ("controllable", "skill", driver.skills)
            if event.controllable
            else ("uncontrollable", "detector", driver.detectors)
        )
        if event.name == TICK.name and event.controllable:
            mistakes.append(Mistake("event 'tick'", "it is the clock's, which nobody starts: make it uncontrollable"))
            continue
        if event.name in known or (not event.controllable and event.name.startswith(TIMEOUT)):
            continue
        near = did_you_mean(event.name, known)
        mistakes.append(Mistake(f"event {event.name!r}", f"{kind}, but the driver has no {what} for it{near}"))
    if mistakes:
        raise ModelError(mistakes)
