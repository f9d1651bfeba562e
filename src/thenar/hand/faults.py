"""Faults of the hand itself, put in on purpose: each must end in a safe stop that names it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError, UnknownName
from thenar.hand.detectors import DETECTORS
from thenar.hand.driver import HandDriver
from thenar.hand.hand import Hand
from thenar.hand.scenarios import Disturbance
from thenar.hand.sensing import Profile, SensorModel
from thenar.hand.skills import SKILLS
from thenar.hand.world import CHANNELS, PERIOD_S, World
from thenar.runtime.driver import Signal

__all__ = ["FAULTS", "Fault", "FaultyDriver", "FaultySensors", "fault"]

FAULTS = {
    "silent": "a detector looks no more",
    "double": "an event is delivered twice",
    "late": "an event is delivered 40 ms late",
    "unordered": "an event is dated before one that was handled",
    "nan": "a sensor reports no number",
    "endless": "a skill never ends",
}
FROM_S = 3.0  # s of the run from which a sensor is broken
LATE_TICKS = 40


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault and the part that has it: an event, or a sensor's channel.

    >>> fault("silent:incip_slip")
    Fault(kind='silent', part='incip_slip*')
    """

    kind: str
    part: str


def fault(text: str) -> Fault:
    """Read ``KIND:PART``, such as ``nan:force_x_1``; the ``*`` of an event may be left out.

    Raises InputError for a text of another shape, UnknownName for a kind or a part that does not exist.
    """
    match = re.fullmatch(r"(\w+):(\S+)", text)
    if not match:
        raise InputError(f"fault {text!r}: write KIND:PART, such as silent:incip_slip or nan:force_x_1")
    kind, part = match.groups()
    if kind not in FAULTS:
        raise UnknownName("fault", kind, FAULTS)
    achieved = [event for event, skill in SKILLS.items() if skill.plan.commit == "achievement"]
    known: list[str] = {  # a command delivers nothing that could be doubled, late or missing
        "nan": [*CHANNELS],
        "endless": achieved,
        "silent": [*DETECTORS],
    }.get(kind, [*achieved, *DETECTORS])
    found = part + "*" if part not in known and part + "*" in known else part
    if found not in known:
        what = {
            "nan": "sensor",
            "silent": "event with a detector",
            "endless": "event with a skill that ends",
        }.get(kind, "event with a detector or a skill that ends")
        raise UnknownName(what, part, known)
    return Fault(kind, found)


class FaultySensors(SensorModel):
    """A sensor model with one channel that reports no number any more."""

    def __init__(self, profile: Profile, seed: int, channel: str) -> None:
        super().__init__(profile, seed)
        self._channel, self._reads = CHANNELS.index(channel), 0

    def read(self, raw: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the readings, one of them not a number from FROM_S on."""
        values = super().read(raw)
        self._reads += 1
        if self._reads * PERIOD_S >= FROM_S:
            values = values.copy()
            values[self._channel] = np.nan
        return values


class FaultyDriver(HandDriver):
    """A driver whose messages, or one of whose skills or detectors, are at fault."""

    def __init__(
        self, world: World, sensors: SensorModel, hand: Hand, disturb: Disturbance | None, fault: Fault
    ) -> None:
        super().__init__(world, sensors, hand, disturb)
        self._fault = fault
        self._held: list[tuple[int, Signal]] = []
        self._last_s = 0.0

    def tick(self) -> Sequence[Signal]:
        """Advance, and spoil what is delivered."""
        if self._fault.kind == "silent" and self.time_s >= FROM_S:
            self.hand.detectors[self._fault.part].hangs = True
        signals = [s for signal in super().tick() for s in self._spoilt(signal)]
        signals += [signal for due, signal in self._held if due == self.world.ticks]
        self._last_s = max([self._last_s, *(s.time_s for s in signals)])
        return signals

    def _spoilt(self, signal: Signal) -> Iterator[Signal]:
        kind = self._fault.kind
        if signal.event != self._fault.part:
            yield signal
        elif kind == "double":
            yield signal
            self._held.append((self.world.ticks + 1, signal))
        elif kind == "late":
            self._held.append((self.world.ticks + LATE_TICKS, signal))
        elif kind == "unordered":
            yield Signal(signal.event, self._last_s - self.period_s, signal.number)
        # an endless skill delivers nothing
