"""What an executor drives: the plant in the loop, real or simulated, seen as skills, detectors and a clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

__all__ = ["Detector", "Driver", "Signal", "Skill"]


@dataclass(frozen=True, slots=True)
class Skill:
    """What a driver does for one controllable event.

    ``commit`` says when the event occurs: a ``"command"`` the moment that it is issued, an ``"achievement"`` when
    the skill reports success.  ``expected_s`` is how long it takes when nothing goes wrong (policies plan with it),
    ``limit_s`` when the watchdog ends it; a command ends with the event that it leads to, so it has none.

    >>> Skill("approach_1", "achievement", expected_s=0.8, limit_s=3.0, finger=1).commit
    'achievement'
    """

    event: str
    commit: Literal["command", "achievement"]
    expected_s: float
    limit_s: float
    finger: int = 0  # 0: both


@dataclass(frozen=True, slots=True)
class Detector:
    """What turns signals into one uncontrollable event.

    ``odds`` is the expected share of the cases in which it fires before a skill that it races with is done;
    ``expected_s`` is how long the run waits for it when nothing else goes on, ``limit_s`` how long at most; infinite
    for one that comes only while a skill is under way, so that waiting for it is in vain.
    Of two events in one tick the one of lower ``priority`` comes first.

    >>> Detector("incip_slip*", odds=0.2, expected_s=0.6, limit_s=5.0).priority
    0
    """

    event: str
    odds: float
    expected_s: float
    limit_s: float
    priority: int = 0
    finger: int = 0


@dataclass(frozen=True, slots=True)
class Signal:
    """A driver's report that ``event`` happened at ``time_s`` of its clock: a detector fired, or a skill succeeded.

    ``number`` counts the signals of one source from 0 without a gap, so that a lost or a doubled one shows.

    >>> Signal("incip_slip*", 1.25, 0).event
    'incip_slip*'
    """

    event: str
    time_s: float
    number: int


class Driver(Protocol):
    """The plant in the loop.  One call of :meth:`tick` is one control period; nothing in it waits or sleeps.

    >>> sorted(name for name in vars(Driver) if not name.startswith("_"))
    ['abort', 'heartbeat', 'not_ready', 'snapshot', 'start', 'stop', 'tick', 'time_s']
    """

    skills: Mapping[str, Skill]
    detectors: Mapping[str, Detector]
    period_s: float

    @property
    def time_s(self) -> float:
        """The driver's clock."""

    def not_ready(self, event: str) -> str | None:
        """Return why the skill of ``event`` cannot start now (its precondition), None if it can."""

    def start(self, event: str) -> None:
        """Start the skill of ``event``; whatever skill was under way is superseded."""

    def abort(self, event: str) -> None:
        """End the skill of ``event`` before it is done, and hold still."""

    def tick(self) -> Sequence[Signal]:
        """Advance by one period and return what happened in it.

        Raises :class:`~thenar.errors.Fault` if the plant itself is not to be trusted any more: a sensor
        that reports no number, an actuator that does not answer.
        """

    def heartbeat(self, event: str) -> float:
        """Return when the detector of ``event`` last looked at its signals, whether or not it is armed."""

    def stop(self) -> None:
        """Bring everything to a safe stand-still; may be called at any time, more than once."""

    def snapshot(self) -> dict[str, float]:
        """Return what the sensors read now, by channel name."""
