"""The watchdogs: nothing takes longer than it may, and no detector falls silent unnoticed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from thenar.errors import Fault
from thenar.runtime.binding import timeout_event
from thenar.runtime.bus import MAX_DELAY_S
from thenar.runtime.driver import Detector, Driver, Skill

__all__ = ["RunLimits", "Watchdog"]

HEARTBEAT_PERIOD_S = 0.010  # how often the detectors are asked whether they are alive


@dataclass(frozen=True, slots=True)
class RunLimits:
    """How long what may take, in seconds of the driver's time, before a run is stopped.

    >>> RunLimits(run_s=30.0).silence_s
    0.05
    """

    run_s: float = 120.0  # the whole run
    patience_s: float = 2.0  # for a skill that was chosen to be ready
    silence_s: float = 0.050  # between two looks of a detector at its signals
    delay_s: float = MAX_DELAY_S  # from an event to its delivery


class Watchdog:
    """Watches one skill or one wait at a time, the heartbeats of ``detectors`` and the length of the run.

    ``message`` says what is overdue after ``deadline_s``, and ``event`` is the uncontrollable event for it.

    >>> class Hand:
    ...     time_s = 1.0
    >>> watchdog = Watchdog(Hand(), [], RunLimits())
    >>> watchdog.skill(Skill("lift", "achievement", 0.5, 3.0, finger=2), 1.0)
    >>> watchdog.deadline_s, watchdog.event, watchdog.message
    (4.0, 'timeout_2', "skill 'lift' did not end within 3 s")
    """

    __slots__ = ("_detectors", "_driver", "_heartbeat_s", "_limits", "_run_end_s", "deadline_s", "event", "message")

    def __init__(self, driver: Driver, detectors: Sequence[str], limits: RunLimits) -> None:
        self._driver, self._detectors, self._limits = driver, tuple(detectors), limits
        self._heartbeat_s = driver.time_s + HEARTBEAT_PERIOD_S
        self._run_end_s = driver.time_s + limits.run_s
        self.rest()

    @property
    def due_s(self) -> float:
        """When :meth:`look` is to be called next."""
        return min(self._heartbeat_s, self._run_end_s, self.deadline_s)

    def rest(self) -> None:
        """Watch neither a skill nor a wait."""
        self.deadline_s, self.event, self.message = math.inf, "", ""

    def skill(self, skill: Skill, now_s: float) -> None:
        """Watch ``skill``, which starts now."""
        self.deadline_s, self.event = now_s + skill.limit_s, timeout_event(skill.finger)
        self.message = f"skill {skill.event!r} did not end within {skill.limit_s:g} s"

    def wait(self, detectors: Sequence[Detector], now_s: float) -> None:
        """Watch the wait for one of ``detectors``, which starts now."""
        longest = max(detectors, key=lambda d: d.limit_s)
        self.deadline_s, self.event = now_s + longest.limit_s, timeout_event(longest.finger)
        names = " or ".join(d.event for d in detectors)
        self.message = f"waited {longest.limit_s:g} s for {names}: nothing was detected"

    def nothing(self, event: str, message: str, now_s: float) -> None:
        """Let ``event``, a watchdog's own, come after the patience: nothing else can."""
        self.deadline_s, self.event, self.message = now_s + self._limits.patience_s, event, message

    def look(self, now_s: float) -> None:
        """Raise Fault for a detector that does not look any more, and at the end of the time for the run."""
        if now_s >= self._run_end_s:
            raise Fault(f"the run did not end within {self._limits.run_s:g} s")
        if now_s >= self._heartbeat_s:
            self._heartbeat_s = now_s + HEARTBEAT_PERIOD_S
            for event in self._detectors:
                seen = self._driver.heartbeat(event)
                if not now_s - seen <= self._limits.silence_s:
                    raise Fault(f"detector {event!r} is silent since {seen:.3f} s")
