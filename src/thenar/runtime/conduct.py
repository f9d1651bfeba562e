"""The conduct of a run: the policy is asked, and what it chooses is waited for, started, achieved or given up."""

from __future__ import annotations

import math
from collections.abc import Sequence

from thenar.errors import Fault
from thenar.runtime.course import Course
from thenar.runtime.driver import Detector, Driver
from thenar.runtime.watchdog import RunLimits, Watchdog

__all__ = ["Conduct"]

_POLL_PERIOD_S = 0.010  # how often a skill that is not ready is asked again


class Conduct:
    """What is under way in one run: nothing, a wait for a sensor or for a skill to be ready, or a skill.

    ``poll_s`` is when a skill that was not ready is to be asked again.
    """

    def __init__(self, course: Course, driver: Driver, watchdog: Watchdog, limits: RunLimits) -> None:
        self.course, self.loop, self.driver = course, course.loop, driver
        self.watchdog, self.limits = watchdog, limits
        self.by = f"policy:{course.policy.name}"
        self.running: int | None = None  # the event whose skill is under way
        self.commanded: int | None = None  # the command whose motion may still be under way
        self.asked = False  # the policy, in this state
        self.chosen: int | None = None  # by the policy, not yet ready
        self.patience_end_s = math.inf
        self.refused: dict[int, str] = {}  # what was chosen in this state, and why it did not get ready
        self.poll_s = math.inf

    def decide(self) -> None:
        """Ask the policy and do what it says; a command happens at once, and then it is asked again."""
        for _ in range(self.loop.supervisor.n_states + len(self.loop.events)):
            if (self.chosen is None and not self._ask()) or not self._start():
                return
        self.course.stop("commands without end: more in one tick than the supervisor has states")

    def reconsider(self) -> None:
        """Let the policy be asked anew."""
        self.asked, self.chosen, self.poll_s = False, None, math.inf
        self.refused.clear()

    def abort(self, why: str) -> None:
        """End what is under way, a skill or a wait."""
        self.reconsider()
        self.watchdog.rest()
        if self.commanded is not None:
            self.driver.abort(self.loop.events[self.commanded])  # what a command set going ends with what it led to
            self.commanded = None
        if self.running is not None:
            name, self.running = self.loop.events[self.running], None
            self.driver.abort(name)
            self.course.note("abort", event=name, why=why)

    def succeed(self, event: int) -> None:
        """Handle the success of a skill: it counts if the skill is the one under way, and is still enabled."""
        if event != self.running:
            self.course.note("stale", event=self.loop.events[event], why="its skill is not the one under way")
        elif event not in self.loop.enabled:
            self.abort("it is disabled now")
        else:
            self._execute(event)

    def tick(self, event: int) -> None:
        """Let the clock tick: a skill goes on if it still may, so does a wait for one; any other wait is over."""
        loop = self.loop
        at, offered = loop.at, (loop.enabled, loop.forced)
        self.course.advance(event, "clock")
        if self.running is not None:
            if self.running not in (loop.forced or loop.enabled):
                self.abort(f"{loop.names(loop.forced)[0]} is forced" if loop.forced else "it is disabled now")
        elif (loop.enabled, loop.forced) != offered or (self.chosen is None and loop.at != at):
            self.reconsider()
            self.watchdog.rest()

    def _execute(self, event: int) -> None:
        """Let a controllable event happen, unless the supervisor itself, asked once more, disables it."""
        supervisor, state = self.loop.supervisor, self.loop.supervisor_state
        self.running = None
        self.watchdog.rest()
        if not supervisor.psi(self.loop.events[event], state):
            self.course.violate(event, f"the supervisor disables it in state {state}")
        else:
            self.reconsider()
            self.course.advance(event, self.by)

    def _ask(self) -> bool:
        """Ask the policy; return whether it chose an event that is to be started."""
        loop, policy = self.loop, self.course.policy
        choices = [e for e in self._startable() if e not in self.refused]
        # nobody waits where something has to happen now
        awaited = [] if loop.forced else self._awaited()
        event = policy.choose(loop.supervisor_state, choices, bool(awaited)) if choices else None
        self.asked, self.poll_s = True, math.inf
        if event is None:
            self._idle(choices, awaited)
        elif event not in choices:
            raise Fault(f"policy {policy.name!r} chose {event!r}, which is not one of {choices}")
        elif loop.marked and not loop.forced and loop.row[event] in self.course.visited:
            self.course.finish()
        else:
            self.chosen, self.patience_end_s = event, self.course.now + self.limits.patience_s
        return self.chosen is not None

    def _startable(self) -> list[int]:
        """Return the events that may be started: of the forced ones, where something is forced."""
        loop = self.loop
        return [e for e in loop.forced or loop.enabled if loop.controllable[e]]

    def _awaited(self) -> list[Detector]:
        """Return the detectors of what may come by itself; the clock's, if the loop moves with it."""
        loop, detectors = self.loop, self.driver.detectors
        sensed = [e for e in loop.uncontrollable if e != loop.clock or loop.after(e) != loop.at]
        found = [detectors[name] for name in loop.names(sensed) if name in detectors]
        return [d for d in found if math.isfinite(d.expected_s)]

    def _start(self) -> bool:
        """Start the chosen skill if it is ready; return whether the policy is to be asked again."""
        event, course = self.chosen, self.course
        assert event is not None
        name = self.loop.events[event]
        why = self.driver.not_ready(name)
        if why is not None:
            self.poll_s = course.now + _POLL_PERIOD_S
            if course.now >= self.patience_end_s or self._another_is_ready(event):
                course.note("note", event=name, message=f"not ready: {why}")
                self.refused[event], self.chosen = f"{name}: {why}", None
            return self.chosen is None
        skill = self.driver.skills[name]
        course.note("start", event=name, chosen_by=self.by)
        self.driver.start(name)
        self.chosen, self.poll_s = None, math.inf
        self.commanded = event if skill.commit == "command" else None
        if skill.commit == "command":
            self._execute(event)
            return course.ended is None
        self.running = event
        self.watchdog.skill(skill, course.now)
        return False

    def _another_is_ready(self, event: int) -> bool:
        """Return whether anything else that may be started could start now: then nobody waits for ``event``."""
        others = (e for e in self._startable() if e != event and e not in self.refused)
        return any(self.driver.not_ready(self.loop.events[e]) is None for e in others)

    def _idle(self, choices: Sequence[int], detectors: Sequence[Detector]) -> None:
        """Start nothing: end the run, wait for what may come, or stop where nothing can."""
        loop, course, patience_s = self.loop, self.course, self.limits.patience_s
        where = f"plant state {loop.plant_name!r}, supervisor state {loop.supervisor_state}"
        if loop.marked and not loop.forced and (choices or not self.refused):
            course.finish()
        elif detectors and not loop.marked:
            self.watchdog.wait(detectors, course.now)
        elif choices:
            why = f"{' or '.join(loop.names(loop.forced))} is forced" if loop.forced else "nothing can come"
            course.stop(f"policy {course.policy.name!r} waits where {why}: {where}")
        elif self.refused:
            course.stop(f"nothing was ready within {patience_s:g} s: {'; '.join(self.refused.values())}")
        elif others := [e for e in loop.uncontrollable if e != loop.clock]:  # the watchdog's, or there were a detector
            self.watchdog.nothing(loop.events[others[0]], f"nothing else can happen in {where}", course.now)
        else:
            course.stop(f"nothing is enabled in {where}, which is not marked")
