"""What an execution comes back with."""

from __future__ import annotations

from dataclasses import dataclass, field

from thenar.model.trace import Trace
from thenar.runtime.record import Entry

__all__ = ["COMPLETE", "GAVE_UP", "STOPPED", "Run"]

COMPLETE, GAVE_UP, STOPPED = "complete", "gave_up", "stopped"


@dataclass(frozen=True, slots=True)
class Run:
    """The log of an execution, and how it ended.

    * ``outcome``: ``"complete"`` (a marked state, the goal events done), ``"gave_up"`` (a marked state without
      them) or ``"stopped"`` (a safe stop); ``message`` says it in words
    * ``trace``: the events that happened, all accepted by S/G
    * ``entries``: the log, as it was written
    * ``violations``: where the plant left its model, or the executor the supervisor
    * ``time_s``: the driver's time at the end
    * ``error``: what ended the run, if that was an exception

    >>> run = Run("gave_up", "back at the start", Trace("lift, drop"), (), (), 3.5)
    >>> run
    Run: gave up after 3.500 s, 2 events: back at the start
    >>> run.discrete_success
    False
    """

    outcome: str
    message: str
    trace: Trace
    entries: tuple[Entry, ...] = field(repr=False)
    violations: tuple[str, ...]
    time_s: float
    error: BaseException | None = field(default=None, compare=False)

    @property
    def status(self) -> str:
        """``"done"`` if the run ended in a marked state, else ``"stopped"``."""
        return STOPPED if self.outcome == STOPPED else "done"

    @property
    def discrete_success(self) -> bool:
        """Whether the run ended in a marked state with the goal events done."""
        return self.outcome == COMPLETE

    def __repr__(self) -> str:
        n = len(self.trace)
        events = f"{n} event{'s' * (n != 1)}"
        return f"Run: {self.outcome.replace('_', ' ')} after {self.time_s:.3f} s, {events}: {self.message}"
