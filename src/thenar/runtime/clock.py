"""The clock of a run: whether a simulated second takes a second.  Nothing else in the floor looks at the wall clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import isfinite
from typing import Protocol

from thenar.errors import InputError

__all__ = ["Clock", "RealClock", "VirtualClock"]

_PAUSE_S = 0.25  # what is further behind was paused, not slow: it is not made up for
_SLACK_S = 1e-3  # a sleep shorter than this costs more than it is worth; the next tick makes up for it


class Clock(Protocol):
    """What the executor calls once a tick, with the driver's time in seconds."""

    def pace(self, time_s: float) -> None:
        """Return when the wall clock has caught up with ``time_s``."""


class VirtualClock:
    """Never waits: the run is as quick as the machine.

    >>> VirtualClock().pace(3600.0)
    """

    __slots__ = ()

    def pace(self, time_s: float) -> None:
        """Return at once."""


class RealClock:
    """Paces a run to the wall clock: ``rate`` simulated seconds a second; a run that is too slow is not hurried.

    The first call sets the start.  ``now`` and ``sleep`` are the machine's, and arguments so that a test can
    stand in for them.  Raises InputError for a rate that is not above 0.

    >>> slept = []
    >>> clock = RealClock(rate=2.0, now=lambda: 100.0, sleep=slept.append)
    >>> clock.pace(0.0)
    >>> clock.pace(0.5)
    >>> slept
    [0.25]
    """

    __slots__ = ("_now", "_offset", "_rate", "_sleep")

    def __init__(
        self,
        rate: float = 1.0,
        *,
        now: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], object] = time.sleep,
    ) -> None:
        if not (isfinite(rate) and rate > 0):
            raise InputError(f"a clock runs at a rate above 0, not {rate!r}")
        self._rate, self._now, self._sleep = rate, now, sleep
        self._offset: float | None = None

    def pace(self, time_s: float) -> None:
        """Sleep until the wall clock has caught up with ``time_s``."""
        due, now = time_s / self._rate, self._now()
        if self._offset is None:
            self._offset = now - due
        ahead = due + self._offset - now
        if ahead < -_PAUSE_S:  # a person was asked, the process was stopped: go on from here at the same pace
            self._offset = now - due
        elif ahead >= _SLACK_S:
            self._sleep(ahead)
