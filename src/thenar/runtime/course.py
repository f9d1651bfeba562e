"""The course of a run: what has happened, where that has led, how it ended, and the log of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from thenar.runtime.driver import Driver
from thenar.runtime.follow import Follower
from thenar.runtime.policy import Policy
from thenar.runtime.record import Journal
from thenar.runtime.run import COMPLETE, GAVE_UP, STOPPED

__all__ = ["Course"]


class Course:
    """What has happened in one run; each event is followed, told to ``policy`` and written down.

    ``through`` are the goal events; ``now`` is the driver's time, and ``event_s`` that of the last event.
    ``ended`` is the outcome and a message as soon as the run is to end.
    """

    def __init__(
        self, loop: Follower, driver: Driver, policy: Policy, through: Sequence[str], journal: Journal
    ) -> None:
        self.loop, self.driver, self.policy, self.journal = loop, driver, policy, journal
        self.goals = {loop.alphabet.index(name) for name in through}
        self.done: set[int] = set()  # the goals, since the last marked state
        self.visited = {loop.supervisor_state}
        self.trace: list[str] = []
        self.violations: list[str] = []
        self.ended: tuple[str, str] | None = None
        self.now = self.event_s = driver.time_s

    def begin(self) -> None:
        """Tell the policy that the run begins, and write the first entry."""
        self.policy.begin()
        self.note("begin", policy=self.policy.name, **self.loop.describe(), sensors=self.driver.snapshot())

    def advance(self, event: int, chosen_by: str) -> None:
        """Let an event happen in plant and supervisor."""
        loop = self.loop
        if loop.marked:
            self.done.clear()
        loop.step(event)
        self.done |= self.goals & {event}
        self.visited.add(loop.supervisor_state)
        self.trace.append(loop.events[event])
        self.event_s = self.now
        self.policy.saw(event, loop.supervisor_state)
        sensors = self.driver.snapshot()
        self.note("event", event=loop.events[event], **loop.describe(), chosen_by=chosen_by, sensors=sensors)

    def violate(self, event: int, why: str) -> None:
        """End the run: the plant does what its model cannot, or something disabled was about to be executed."""
        prevented = self.loop.controllable[event]
        what = "disabled event about to be executed" if prevented else "model violation"
        message = f"{what}: {self.loop.events[event]!r}: {why}"
        self.violations.append(message)
        self.stop(message)
        kind, sensors = "prevented" if prevented else "violation", self.driver.snapshot()
        self.note(kind, event=self.loop.events[event], message=message, sensors=sensors)

    def finish(self) -> None:
        """End the run in a marked state."""
        missing = [self.loop.events[e] for e in sorted(self.goals - self.done)]
        where = f"marked state {self.loop.plant_name!r}"
        if missing:
            self.ended = GAVE_UP, f"ended in {where} without {', '.join(missing)}"
        else:
            self.ended = COMPLETE, f"ended in {where}"

    def stop(self, message: str) -> None:
        """End the run, by a safe stop."""
        self.ended = STOPPED, message

    def note(self, kind: str, **fields: Any) -> None:
        """Write an entry."""
        self.journal.note(kind, self.now, **fields)
