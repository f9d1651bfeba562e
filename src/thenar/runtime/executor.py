"""The executor: runs a supervisor on a driver, one event at a time, until the task is done or must be stopped."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from thenar.errors import Fault
from thenar.explicit.timed import TICK
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Trace
from thenar.runtime.binding import check_binding
from thenar.runtime.bus import EventBus
from thenar.runtime.clock import Clock, VirtualClock
from thenar.runtime.driver import Detector, Driver, Signal
from thenar.runtime.follow import Follower
from thenar.runtime.policy import Policy
from thenar.runtime.record import Entry, Journal, Sink
from thenar.runtime.run import COMPLETE, GAVE_UP, STOPPED, Run
from thenar.runtime.watchdog import RunLimits, Watchdog

__all__ = ["RunLimits", "execute"]

OnEntry = Callable[[Entry], object]
OnTick = Callable[[float, str | None, str | None], object]

_POLL_PERIOD_S = 0.010  # how often a skill that is not ready is asked again
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

    An event ``tick`` is the clock's: it comes when nothing has happened for as long as the driver's detector of that
    name expects.  Where the supervisor forces (:func:`supcon_forcing`) the policy chooses among the forced events only,
    at once; a tick that comes first all the same is a violation.

    What takes too long is the event ``timeout_1`` or ``timeout_2`` where the plant can do it.  Otherwise it, and
    any Fault or other exception, is a safe stop: the Run says why, and so does the last entry of the log.
    ``on_entry`` is called with each entry, ``on_tick(time_s, last event, running skill)`` 20 times a second of
    the driver's time.  O(|Σ|) an event, and well below 1 µs for a tick without one.

    Raises ModelError, before anything moves, if an event has no skill or no detector, InputError if there is no
    supervisor; KeyboardInterrupt again after the safe stop and the end of the log.

    >>> from thenar.explicit.products import sync
    >>> from thenar.library.classics import small_factory
    >>> from thenar.runtime.driver import Skill
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
    loop, journal = Follower(supervisor, plant), Journal(log, on_entry)
    execution = _Execution(loop, driver, policy, through, limits or RunLimits(), journal, on_tick)
    return execution.run(clock or VirtualClock())


class _Execution:
    """One run: where the loop is, what is under way, and when something is due."""

    def __init__(
        self,
        loop: Follower,
        driver: Driver,
        policy: Policy,
        through: Sequence[str],
        limits: RunLimits,
        journal: Journal,
        on_tick: OnTick | None,
    ) -> None:
        self.loop, self.driver, self.policy = loop, driver, policy
        self.journal, self.on_tick = journal, on_tick
        self.bus = EventBus(loop.alphabet, driver, max_delay_s=limits.delay_s)
        own = [e.name for e in loop.alphabet if not e.controllable and e.name in driver.detectors and e != TICK]
        self.watchdog, self.limits = Watchdog(driver, own, limits), limits
        self.by = f"policy:{policy.name}"
        self.goals = {loop.alphabet.index(name) for name in through}
        self.done: set[int] = set()  # the goals, since the last marked state
        self.clock = next((k for k, e in enumerate(loop.alphabet) if e == TICK), None)
        self.tick_period_s = math.inf if self.clock is None else driver.detectors[TICK.name].expected_s
        self.visited = {loop.supervisor_state}
        self.trace: list[str] = []
        self.violations: list[str] = []
        self.ended: tuple[str, str] | None = None

        self.now = driver.time_s
        self.tick_s = self.now + self.tick_period_s
        self.running: int | None = None  # the event whose skill is under way
        self.commanded: int | None = None  # the command whose motion may still be under way
        self.asked = False  # the policy, in this state
        self.chosen: int | None = None  # by the policy, not yet ready
        self.patience_end_s = math.inf
        self.refused: dict[int, str] = {}  # what was chosen in this state, and why it did not get ready
        self.due_s = self.now
        self.poll_s = math.inf
        self.progress_s = self.now if on_tick else math.inf

    def run(self, clock: Clock) -> Run:
        """Run to the end, come what may."""
        error: BaseException | None = None
        try:
            self.policy.begin()
            self._note("begin", policy=self.policy.name, **self.loop.describe(), sensors=self.driver.snapshot())
            self._decide()
            self._turn(clock)
        except Fault as fault:
            error, self.ended = fault, (STOPPED, str(fault))
        except KeyboardInterrupt as interrupt:
            error, self.ended = interrupt, (STOPPED, "interrupted from the keyboard")
        except Exception as failure:
            error, self.ended = failure, (STOPPED, f"{type(failure).__name__}: {failure}")
        return self._finish(error)

    def _turn(self, clock: Clock) -> None:
        """Tick until the run has ended; a tick without news is one comparison."""
        driver, tick, pace = self.driver, self.driver.tick, clock.pace
        last = driver.time_s
        while self.ended is None:
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
        self.now = now
        try:
            arranged = self.bus.arrange(signals, now, self._alarms())
        except Fault:
            for signal in signals:
                self._note("note", event=signal.event, message="came in the tick of a fault; not handled")
            raise
        for signal in arranged:
            if self.ended is None:
                self._happen(signal)
            else:
                self._note("note", event=signal.event, message="came when the run had ended")
        if self.ended is None and now >= self.tick_s:
            self._pass_time()
        if self.ended is None:
            self.watchdog.look(now)
        if self.ended is None and now >= self.watchdog.deadline_s:
            self.ended = STOPPED, self.watchdog.message
        if self.ended is None and self.running is None and (not self.asked or now >= self.poll_s):
            self._decide()
        if now >= self.progress_s and self.on_tick:
            self.progress_s = now + _PROGRESS_PERIOD_S
            running = None if self.running is None else self.loop.events[self.running]
            self.on_tick(now, self.trace[-1] if self.trace else None, running)
        self.due_s = min(self.watchdog.due_s, self.poll_s, self.progress_s, self.tick_s)

    def _finish(self, error: BaseException | None) -> Run:
        """Stop the driver if that is called for, write the last entry and return the run."""
        outcome, message = self.ended or (STOPPED, "")
        try:
            self.driver.stop()
            self.now = max(self.now, self.driver.time_s)
        except Exception as failure:
            message += f"; and the driver does not stop: {type(failure).__name__}: {failure}"
        try:
            self._note("end", outcome=outcome, message=message, violations=list(self.violations))
        except Exception as failure:  # a full disk must not hide why the run ended
            message += f"; and the log has no end: {failure}"
        if isinstance(error, KeyboardInterrupt):
            raise error
        trace, entries, violations = Trace(self.trace), tuple(self.journal.entries), tuple(self.violations)
        return Run(outcome, message, trace, entries, violations, self.now, error)

    # -- events --------------------------------------------------------------------------------------------

    def _alarms(self) -> list[str]:
        """Return the watchdog's event, if something is overdue and the plant can do it."""
        watchdog, alphabet = self.watchdog, self.loop.alphabet
        if self.now < watchdog.deadline_s or watchdog.event not in alphabet:
            return []
        if alphabet[watchdog.event].controllable or not self.loop.possible(alphabet.index(watchdog.event)):
            return []
        self._note("note", event=watchdog.event, message=watchdog.message)
        return [watchdog.event]

    def _happen(self, signal: Signal) -> None:
        """Handle one event."""
        name, loop = signal.event, self.loop
        if name not in loop.alphabet:
            self._note("note", event=name, message="not an event of the model; ignored")
            return
        event = loop.alphabet.index(name)
        is_alarm = signal.number < 0
        if loop.controllable[event]:
            self._complete(event)
        elif is_alarm and self.now < self.watchdog.deadline_s:
            self._note("stale", event=name, why="another event came first")
        elif not loop.possible(event):
            self._violate(event, f"the plant's model cannot do it in state {loop.plant_name!r}")
        elif event not in loop.row:
            self._violate(event, f"the supervisor does not follow it from state {loop.supervisor_state}")
        else:
            self._advance(event, "watchdog" if is_alarm else "detector")
            self._abort(f"{name} came first")

    def _complete(self, event: int) -> None:
        """Handle the success of a skill: it counts if the skill is the one under way, and is still enabled."""
        if event != self.running:
            self._note("stale", event=self.loop.events[event], why="its skill is not the one under way")
        elif event not in self.loop.enabled:
            self._abort("it is disabled now")
        else:
            self._execute(event)

    def _execute(self, event: int) -> None:
        """Let a controllable event happen, unless the supervisor itself, asked once more, disables it."""
        supervisor, state = self.loop.supervisor, self.loop.supervisor_state
        self.running = None
        self.watchdog.rest()
        if not supervisor.psi(self.loop.events[event], state):
            self._violate(event, f"the supervisor disables it in state {state}")
        else:
            self._reconsider()
            self._advance(event, self.by)

    def _pass_time(self) -> None:
        """Let the clock tick; what goes on goes on, if it still may."""
        loop, event = self.loop, self.clock
        assert event is not None
        before = loop.enabled, loop.forced
        if not loop.possible(event):
            self._violate(event, f"the plant's model lets no time pass in state {loop.plant_name!r}")
        elif loop.forced and event not in loop.row:
            self._violate(event, f"{' or '.join(loop.names(loop.forced))} was forced, and did not come before it")
        elif event not in loop.row:
            self._violate(event, f"the supervisor does not follow it from state {loop.supervisor_state}")
        else:
            self._advance(event, "clock")
            if self.running is not None and self.running not in (loop.forced or loop.enabled):
                self._abort(f"{loop.names(loop.forced)[0]} is forced" if loop.forced else "it is disabled now")
            elif (loop.enabled, loop.forced) != before:
                self._reconsider()

    def _advance(self, event: int, chosen_by: str) -> None:
        """Let an event happen in plant and supervisor."""
        loop = self.loop
        if loop.marked:
            self.done.clear()
        loop.step(event)
        self.done |= self.goals & {event}
        self.visited.add(loop.supervisor_state)
        self.trace.append(loop.events[event])
        self.tick_s = self.now + self.tick_period_s
        self.policy.saw(event, loop.supervisor_state)
        sensors = self.driver.snapshot()
        self._note("event", event=loop.events[event], **self.loop.describe(), chosen_by=chosen_by, sensors=sensors)

    def _abort(self, why: str) -> None:
        """End what is under way, a skill or a wait."""
        self._reconsider()
        self.watchdog.rest()
        if self.commanded is not None:
            self.driver.abort(self.loop.events[self.commanded])  # what a command set going ends with what it led to
            self.commanded = None
        if self.running is not None:
            name, self.running = self.loop.events[self.running], None
            self.driver.abort(name)
            self._note("abort", event=name, why=why)

    def _reconsider(self) -> None:
        """Let the policy be asked anew."""
        self.asked, self.chosen, self.poll_s = False, None, math.inf
        self.refused.clear()

    def _violate(self, event: int, why: str) -> None:
        """End the run: the plant does what its model cannot, or something disabled was about to be executed."""
        prevented = self.loop.controllable[event]
        what = "disabled event about to be executed" if prevented else "model violation"
        message = f"{what}: {self.loop.events[event]!r}: {why}"
        self.violations.append(message)
        self.ended = STOPPED, message
        kind, sensors = "prevented" if prevented else "violation", self.driver.snapshot()
        self._note(kind, event=self.loop.events[event], message=message, sensors=sensors)

    # -- choices -------------------------------------------------------------------------------------------

    def _decide(self) -> None:
        """Ask the policy and do what it says; a command happens at once, and then it is asked again."""
        for _ in range(self.loop.supervisor.n_states + len(self.loop.events)):
            if (self.chosen is None and not self._ask()) or not self._start():
                return
        self.ended = STOPPED, "commands without end: more in one tick than the supervisor has states"

    def _ask(self) -> bool:
        """Ask the policy; return whether it chose an event that is to be started."""
        loop = self.loop
        choices = [e for e in loop.forced or loop.enabled if loop.controllable[e] and e not in self.refused]
        sensed = [
            self.driver.detectors[name] for name in loop.names(loop.uncontrollable) if name in self.driver.detectors
        ]
        awaited = [d for d in sensed if math.isfinite(d.expected_s) and (d.event != TICK.name or self._time_helps())]
        if loop.forced:
            awaited = []  # nobody waits where something has to happen now
        event = self.policy.choose(loop.supervisor_state, choices, bool(awaited)) if choices else None
        self.asked, self.poll_s = True, math.inf
        if event is None:
            self._idle(choices, awaited)
        elif event not in choices:
            raise Fault(f"policy {self.policy.name!r} chose {event!r}, which is not one of {choices}")
        elif loop.marked and not loop.forced and loop.row[event] in self.visited:
            self._end()
        else:
            self.chosen, self.patience_end_s = event, self.now + self.limits.patience_s
        return self.chosen is not None

    def _start(self) -> bool:
        """Start the chosen skill if it is ready; return whether the policy is to be asked again."""
        event = self.chosen
        assert event is not None
        name = self.loop.events[event]
        why = self.driver.not_ready(name)
        if why is not None:
            self.poll_s = self.now + _POLL_PERIOD_S
            if self.now >= self.patience_end_s or self._another_is_ready(event):
                self._note("note", event=name, message=f"not ready: {why}")
                self.refused[event], self.chosen = f"{name}: {why}", None
            return self.chosen is None
        skill = self.driver.skills[name]
        self._note("start", event=name, chosen_by=self.by)
        self.driver.start(name)
        self.chosen, self.poll_s = None, math.inf
        self.commanded = event if skill.commit == "command" else None
        if skill.commit == "command":
            self._execute(event)
            return self.ended is None
        self.running = event
        self.watchdog.skill(skill, self.now)
        return False

    def _another_is_ready(self, event: int) -> bool:
        """Return whether anything else that is enabled could start now: then nobody waits for ``event``."""
        loop, not_ready = self.loop, self.driver.not_ready
        others = (e for e in loop.enabled if loop.controllable[e] and e != event and e not in self.refused)
        return any(not_ready(loop.events[e]) is None for e in others)

    def _idle(self, choices: Sequence[int], detectors: Sequence[Detector]) -> None:
        """Start nothing: end the run, wait for what may come, or stop where nothing can."""
        loop, patience_s = self.loop, self.limits.patience_s
        where = f"plant state {loop.plant_name!r}, supervisor state {loop.supervisor_state}"
        if loop.marked and not loop.forced and (choices or not self.refused):
            self._end()
        elif detectors and not loop.marked:
            self.watchdog.wait(detectors, self.now)
        elif choices:
            why = f"{' or '.join(loop.names(loop.forced))} is forced" if loop.forced else "nothing can come"
            self.ended = STOPPED, f"policy {self.policy.name!r} waits where {why}: {where}"
        elif self.refused:
            self.ended = STOPPED, f"nothing was ready within {patience_s:g} s: {'; '.join(self.refused.values())}"
        elif others := [e for e in loop.uncontrollable if e != self.clock]:  # the watchdog's, or there were a detector
            self.watchdog.nothing(loop.events[others[0]], f"nothing else can happen in {where}", self.now)
        else:
            self.ended = STOPPED, f"nothing is enabled in {where}, which is not marked"

    def _time_helps(self) -> bool:
        """Return whether the supervisor's state is another one after a tick."""
        return self.clock is not None and self.loop.row.get(self.clock) != self.loop.supervisor_state

    def _end(self) -> None:
        """End the run in a marked state."""
        missing = [self.loop.events[e] for e in sorted(self.goals - self.done)]
        where = f"marked state {self.loop.plant_name!r}"
        if missing:
            self.ended = GAVE_UP, f"ended in {where} without {', '.join(missing)}"
        else:
            self.ended = COMPLETE, f"ended in {where}"

    def _note(self, kind: str, **fields: Any) -> None:
        self.journal.note(kind, self.now, **fields)
