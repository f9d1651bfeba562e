"""The executor: runs a supervisor on a driver, one event at a time, until the task is done or must be stopped."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from thenar.errors import Fault
from thenar.explicit.timed import TICK
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Trace
from thenar.runtime.binding import check_binding
from thenar.runtime.bus import EventBus
from thenar.runtime.clock import Clock, VirtualClock
from thenar.runtime.conduct import Conduct
from thenar.runtime.course import Course
from thenar.runtime.driver import Driver, Signal
from thenar.runtime.follow import Follower
from thenar.runtime.policy import Policy
from thenar.runtime.record import Entry, Journal, Sink
from thenar.runtime.run import STOPPED, Run
from thenar.runtime.watchdog import RunLimits, Watchdog

__all__ = ["RunLimits", "execute"]

OnEntry = Callable[[Entry], object]
OnTick = Callable[[float, str | None, str | None], object]

_PROGRESS_PERIOD_S = 0.050  # 20 Hz, what an eye can follow


def execute(
    supervisor: Supervisor,
    plant: Automaton,
    driver: Driver,
    policy: Policy,
    *,
    through: Sequence[str] = (),
    clock: Clock | None = None,
    log: Sink | None = None,
    on_entry: OnEntry | None = None,
    on_tick: OnTick | None = None,
    limits: RunLimits | None = None,
) -> Run:
    """Run ``supervisor`` on ``driver`` until the task ends; ``plant`` is the product of the problem's plants.

    Uncontrollable events are followed, or stop the run where the plant's model does not define them; of the
    enabled controllable events ``policy`` chooses one at a time.  If its skill is not ready the policy is asked
    again without it; if nothing else is ready either, the run waits for it, so long as its patience lasts.

    The run ends in a marked state where nothing is enabled, the policy starts nothing, or its choice leads to a
    state of the supervisor that was visited before.  It is complete if all events of ``through`` happened since
    the last marked state.

    An event called ``tick`` is the clock's: it comes when nothing has happened for as long as the driver's detector of
    that name expects.  A tick that leads to another state lets a policy that waits choose anew.  Where the supervisor
    forces (:func:`supcon_forcing`) the policy chooses among the forced events only, at once; a tick that comes first
    all the same is a violation.  No uncontrollable event is started, though it be forcible: :func:`fit_to_run` tells
    where a supervisor counts on that.

    What takes too long is the event ``timeout_1`` or ``timeout_2`` where the plant can do it.  Otherwise it, and
    any Fault or other exception, is a safe stop: the Run says why, and so does the last entry of the log.
    ``on_entry`` is called with each entry, ``on_tick(time_s, last event, running skill)`` 20 times a second of
    the driver's time.  O(|Σ|) an event, and well below 1 µs for a tick without one.

    Raises ModelError, before anything moves, if an event has no skill or no detector, InputError if there is no
    supervisor; KeyboardInterrupt again after the safe stop and the end of the log.

    >>> from thenar.explicit.products import sync
    >>> from thenar.library.classics import small_factory
    >>> from thenar.runtime.driver import Detector, Skill
    >>> from thenar.runtime.policy import Priority
    >>> from thenar.synthesis.api import synthesize
    >>> class Factory:
    ...     time_s, period_s, events = 0.0, 0.1, ["finish_1", "finish_2", "break_1", "break_2"]
    ...     skills = {e: Skill(e, "command", 0.0, 1.0) for e in ["start_1", "start_2", "repair_1", "repair_2"]}
    ...     detectors = {e: Detector(e, odds=0.1, expected_s=1.0, limit_s=5.0) for e in events}
    ...     def tick(self):
    ...         self.time_s += self.period_s
    ...         return [Signal("finish_" + self.machine, self.time_s, 0)]
    ...     def start(self, event):
    ...         self.machine = event[-1]
    ...     not_ready = lambda self, event: None
    ...     heartbeat = lambda self, event: self.time_s
    ...     snapshot = dict
    ...     stop = abort = lambda self, event=None: None
    >>> problem = small_factory()
    >>> supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants)
    >>> policy = Priority(supervisor, ["finish_1", "finish_2", "start_2"])
    >>> run = execute(supervisor, plant, Factory(), policy, through=["finish_2"])
    >>> run.outcome, run.trace
    ('complete', Trace('start_1, finish_1, start_2, finish_2'))
    """
    check_binding(supervisor.automaton.alphabet, driver)
    limits = limits or RunLimits()
    course = Course(Follower(supervisor, plant), driver, policy, through, Journal(log, on_entry))
    own = [e.name for e in course.loop.alphabet if not e.controllable and e.name in driver.detectors]
    watchdog = Watchdog(driver, [name for name in own if name != TICK.name], limits)
    conduct = Conduct(course, driver, watchdog, limits)
    return _Execution(course, conduct, driver, watchdog, limits, on_tick).run(clock or VirtualClock())


class _Execution:
    """One run: what comes in is put into the loop, and what is due is done."""

    def __init__(
        self,
        course: Course,
        conduct: Conduct,
        driver: Driver,
        watchdog: Watchdog,
        limits: RunLimits,
        on_tick: OnTick | None,
    ) -> None:
        self.course, self.conduct, self.loop = course, conduct, course.loop
        self.driver, self.watchdog, self.on_tick = driver, watchdog, on_tick
        self.bus = EventBus(self.loop.alphabet, driver, max_delay_s=limits.delay_s)
        clocked = self.loop.clock is not None
        self.tick_period_s = driver.detectors[TICK.name].expected_s if clocked else math.inf
        self.due_s = course.now
        self.progress_s = course.now if on_tick else math.inf

    def run(self, clock: Clock) -> Run:
        """Run to the end, come what may."""
        error: BaseException | None = None
        try:
            self.course.begin()
            self.conduct.decide()
            self._turn(clock)
        except Fault as fault:
            error = fault
            self.course.stop(str(fault))
        except KeyboardInterrupt as interrupt:
            error = interrupt
            self.course.stop("interrupted from the keyboard")
        except Exception as failure:
            error = failure
            self.course.stop(f"{type(failure).__name__}: {failure}")
        return self._finish(error)

    def _turn(self, clock: Clock) -> None:
        """Tick until the run has ended; a tick without news is one comparison."""
        course, driver, tick, pace = self.course, self.driver, self.driver.tick, clock.pace
        last = driver.time_s
        while course.ended is None:
            signals = tick()
            now = driver.time_s
            if not now > last:
                raise Fault(f"the driver's clock stands still at {last:.3f} s")
            last = now
            pace(now)
            if signals or now >= self.due_s:
                self._attend(signals, now)

    def _attend(self, signals: Sequence[Signal], now: float) -> None:
        """Handle a tick in which something came, or something is due."""
        course, conduct, watchdog = self.course, self.conduct, self.watchdog
        course.now = now
        try:
            arranged = self.bus.arrange(signals, now, self._alarms())
        except Fault:
            for signal in signals:
                course.note("note", event=signal.event, message="came in the tick of a fault; not handled")
            raise
        for signal in arranged:
            if course.ended is None:
                self._happen(signal)
            else:
                course.note("note", event=signal.event, message="came when the run had ended")
        if course.ended is None and now >= course.event_s + self.tick_period_s:
            self._pass_time()
        if course.ended is None:
            watchdog.look(now)
        if course.ended is None and now >= watchdog.deadline_s:
            course.stop(watchdog.message)
        if course.ended is None and conduct.running is None and (not conduct.asked or now >= conduct.poll_s):
            conduct.decide()
        if now >= self.progress_s and self.on_tick:
            self.progress_s = now + _PROGRESS_PERIOD_S
            running = None if conduct.running is None else self.loop.events[conduct.running]
            self.on_tick(now, course.trace[-1] if course.trace else None, running)
        self.due_s = min(watchdog.due_s, conduct.poll_s, self.progress_s, course.event_s + self.tick_period_s)

    def _alarms(self) -> list[str]:
        """Return the watchdog's event, if something is overdue and the plant can do it."""
        watchdog, alphabet = self.watchdog, self.loop.alphabet
        if self.course.now < watchdog.deadline_s or watchdog.event not in alphabet:
            return []
        if alphabet[watchdog.event].controllable or not self.loop.possible(alphabet.index(watchdog.event)):
            return []
        self.course.note("note", event=watchdog.event, message=watchdog.message)
        return [watchdog.event]

    def _happen(self, signal: Signal) -> None:
        """Handle one event."""
        name, loop, course = signal.event, self.loop, self.course
        if name not in loop.alphabet:
            course.note("note", event=name, message="not an event of the model; ignored")
            return
        event = loop.alphabet.index(name)
        is_alarm = signal.number < 0
        if loop.controllable[event]:
            self.conduct.succeed(event)
        elif is_alarm and course.now < self.watchdog.deadline_s:
            course.note("stale", event=name, why="another event came first")
        elif not loop.possible(event):
            course.violate(event, f"the plant's model cannot do it in state {loop.plant_name!r}")
        elif event not in loop.row:
            course.violate(event, f"the supervisor does not follow it from state {loop.supervisor_state}")
        else:
            course.advance(event, "watchdog" if is_alarm else "detector")
            self.conduct.abort(f"{name} came first")

    def _pass_time(self) -> None:
        """Let the clock tick; what goes on goes on, if it still may."""
        loop, course, event = self.loop, self.course, self.loop.clock
        assert event is not None
        if not loop.possible(event):
            course.violate(event, f"the plant's model lets no time pass in state {loop.plant_name!r}")
        elif loop.forced and event not in loop.row:
            forced = " or ".join(loop.names(loop.forced))
            course.violate(event, f"{forced} was forced, and did not come before it")
        elif event not in loop.row:
            course.violate(event, f"the supervisor does not follow it from state {loop.supervisor_state}")
        else:
            self.conduct.tick(event)

    def _finish(self, error: BaseException | None) -> Run:
        """Stop the driver if that is called for, write the last entry and return the run."""
        course = self.course
        outcome, message = course.ended or (STOPPED, "")
        try:
            self.driver.stop()
            course.now = max(course.now, self.driver.time_s)
        except Exception as failure:
            message += f"; and the driver does not stop: {type(failure).__name__}: {failure}"
        try:
            course.note("end", outcome=outcome, message=message, violations=list(course.violations))
        except Exception as failure:  # a full disk must not hide why the run ended
            message += f"; and the log has no end: {failure}"
        if isinstance(error, KeyboardInterrupt):
            raise error
        trace, entries = Trace(course.trace), tuple(course.journal.entries)
        return Run(outcome, message, trace, entries, tuple(course.violations), course.now, error)
