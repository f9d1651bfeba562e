"""A driver without physics: skills last as long as they should, detectors fire by chance where the plant can."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from random import Random
from typing import Any

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.runtime.driver import Detector, Signal, Skill

__all__ = ["FakeDriver", "detectors_for", "skills_for"]

Tamper = Callable[["FakeDriver", list[Signal]], Sequence[Signal]]


def skills_for(
    alphabet: Alphabet, *, expected_s: float = 0.02, limit_s: float = 0.5, commands: Sequence[str] = ()
) -> dict[str, Skill]:
    return {
        e.name: Skill(e.name, "command" if e.name in commands else "achievement", expected_s, limit_s)
        for e in alphabet
        if e.controllable
    }


def detectors_for(
    alphabet: Alphabet, *, odds: float = 0.1, expected_s: float = 0.05, limit_s: float = 2.0
) -> dict[str, Detector]:
    return {e.name: Detector(e.name, odds, expected_s, limit_s) for e in alphabet if not e.controllable}


class FakeDriver:
    """Follows ``plant`` for itself; ``chance(event, state)`` is the chance a tick that a detector fires.

    ``tamper`` turns what a tick would report into what it does report.
    """

    def __init__(
        self,
        plant: Automaton,
        alphabet: Alphabet,
        rng: Random,
        *,
        skills: Mapping[str, Skill] | None = None,
        detectors: Mapping[str, Detector] | None = None,
        chance: Callable[[str, str], float] = lambda event, state: 0.01,
        tamper: Tamper | None = None,
        period_s: float = 0.001,
    ) -> None:
        self.plant, self.rng, self.chance, self.tamper = plant, rng, chance, tamper
        self.skills: Mapping[str, Skill] = dict(skills if skills is not None else skills_for(alphabet))
        self.detectors: Mapping[str, Detector] = dict(detectors if detectors is not None else detectors_for(alphabet))
        self.period_s = period_s
        self.ticks = 0
        self.state = plant.initial
        self.running: str | None = None
        self.ready_at = 0.0
        self.numbers: dict[str, int] = {}
        self.calls: list[str] = []
        self.silent_since: dict[str, float] = {}
        self.unready: dict[str, str] = {}

    @property
    def time_s(self) -> float:
        return self.ticks * self.period_s

    def not_ready(self, event: str) -> str | None:
        return self.unready.get(event)

    def start(self, event: str) -> None:
        self.calls.append(f"start {event}")
        skill = self.skills[event]
        self.running = None
        if skill.commit == "command":
            self._follow(event)
        else:
            self.running = event
            self.ready_at = self.time_s + self.rng.uniform(0.5, 1.5) * skill.expected_s

    def abort(self, event: str) -> None:
        self.calls.append(f"abort {event}")
        self.running = None

    def tick(self) -> Sequence[Signal]:
        self.ticks += 1
        signals: list[Signal] = []
        interrupted = False
        for event in sorted(self.detectors, key=lambda e: (self.detectors[e].priority, self.detectors[e].finger, e)):
            if self._can(event) and self.rng.random() < self.chance(event, self.plant.states[self.state]):
                self._follow(event)
                interrupted = True
                signals.insert(0, self.signal(event))  # in the wrong order: the bus has to mend that
        if self.running is not None and self.time_s >= self.ready_at:
            event, self.running = self.running, None
            if not interrupted:  # otherwise the executor finds it stale
                self._follow(event)
            signals.insert(0, self.signal(event))
        return signals if self.tamper is None else self.tamper(self, signals)

    def heartbeat(self, event: str) -> float:
        return min(self.time_s, self.silent_since.get(event, self.time_s))

    def stop(self) -> None:
        self.calls.append("stop")

    def snapshot(self) -> dict[str, float]:
        return {"state": float(self.state), "noise": self.rng.random()}

    def overhear(self, entry: Mapping[str, Any]) -> None:
        """Follow the watchdog's events, which come from outside."""
        if entry.get("chosen_by") == "watchdog":
            self._follow(entry["event"])

    def signal(self, event: str) -> Signal:
        number = self.numbers[event] = self.numbers.get(event, -1) + 1
        return Signal(event, self.time_s, number)

    def _can(self, event: str) -> bool:
        return event in self.plant.alphabet and self.plant.step(self.state, event) is not None

    def _follow(self, event: str) -> None:
        if event in self.plant.alphabet:
            target = self.plant.step(self.state, event)
            assert target is not None, f"{event} is impossible in plant state {self.plant.states[self.state]}"
            self.state = target
