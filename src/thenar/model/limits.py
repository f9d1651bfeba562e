"""How far a computation may go, and how it tells where it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from thenar.errors import InputError

__all__ = ["Limits", "Progress"]

Progress: TypeAlias = Callable[[int, int], object]
"""Called a few times a second with the states and transitions found so far; it may raise to stop the work."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds on a computation; at one of them it stops with LimitReached.  None is no bound.

    ``bytes`` counts what the kernel holds, not what the process uses.

    >>> from thenar.explicit.products import sync
    >>> from thenar.library.classics import transfer_line
    >>> sync(*transfer_line(5).plants, limits=Limits(states=1000))
    Traceback (most recent call last):
    thenar.errors.LimitReached: stopped at the limit of 1,000 states: ... found so far; ...
    """

    states: int | None = None
    transitions: int | None = None
    bytes: int | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        for name in ("states", "transitions", "bytes"):
            bound = getattr(self, name)
            if bound is not None and not (isinstance(bound, int) and 0 <= bound < 1 << 63):
                raise InputError(f"limit {name}={bound!r}: a whole number from 0 to 2**63 - 1, or None")
        if self.seconds is not None and not self.seconds >= 0:
            raise InputError(f"limit seconds={self.seconds!r}: a number from 0 on, or None")
