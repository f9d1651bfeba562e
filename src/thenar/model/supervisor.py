"""The supervisor (S, ψ): an automaton that follows the plant, and a feedback map that says what it disables."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thenar.errors import counted
from thenar.model.automaton import Automaton
from thenar.model.display import Displayable
from thenar.model.events import Event

__all__ = ["ControlPattern", "Supervisor"]


@dataclass(frozen=True, slots=True)
class ControlPattern:
    """What a supervisor says at one state: the events that may happen, and those that it disables.

    An event in neither is one that the plant cannot do there.

    >>> pattern = ControlPattern((Event("lift"),), (Event("squeeze"),))
    >>> print(pattern, "lift" in pattern, "squeeze" in pattern)
    enabled: lift; disabled: squeeze True False
    """

    enabled: tuple[Event, ...]
    disabled: tuple[Event, ...]

    def __contains__(self, event: str | Event) -> bool:
        """Return whether ``event`` is enabled."""
        name = event.name if isinstance(event, Event) else event
        return any(e.name == name for e in self.enabled)

    def __str__(self) -> str:
        enabled, disabled = (", ".join(e.name for e in group) or "-" for group in (self.enabled, self.disabled))
        return f"enabled: {enabled}; disabled: {disabled}"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Supervisor(Displayable):
    """A supervisor S = (S, ψ) with ψ: Σ × X → {0, 1} and ψ(σ, x) = 1 for every uncontrollable σ.

    ``automaton`` is S = (X, Σ, ξ, x0, Xm).  The disabled events, TCT's *control data*, lie in compressed
    sparse rows: ``disabled[disabled_offsets[x]:disabled_offsets[x + 1]]`` are the positions in the alphabet
    of the controllable events that the plant can do when the supervisor is in x, and that it must not do.

    A supervisor with an empty automaton means that no supervisor exists.

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> supervisor = synthesize(small_factory()).supervisor
    >>> supervisor.psi("start_1", 0), supervisor.psi("start_2", 0)
    (True, False)
    >>> print(supervisor.after("start_1, finish_1"))
    enabled: start_2; disabled: start_1
    """

    automaton: Automaton
    disabled_offsets: NDArray[np.int64]
    disabled: NDArray[np.int32]

    def __post_init__(self) -> None:
        for array in (self.disabled_offsets, self.disabled):
            array.flags.writeable = False

    def __reduce__(self) -> tuple[Any, ...]:
        # as an automaton's: the arrays of a pickle would be writable
        return type(self), tuple(getattr(self, f.name) for f in fields(self))

    @property
    def is_empty(self) -> bool:
        """True if no supervisor exists."""
        return self.automaton.is_empty

    @property
    def n_states(self) -> int:
        """|X|."""
        return self.automaton.n_states

    @property
    def n_transitions(self) -> int:
        """|ξ|."""
        return self.automaton.n_transitions

    def psi(self, event: str | Event, state: int) -> bool:
        """Return the feedback map ψ(event, state): False exactly if the supervisor disables the event there."""
        lo, hi = self.disabled_offsets[state], self.disabled_offsets[state + 1]
        return self.automaton.alphabet.index(event) not in self.disabled[lo:hi]

    def pattern(self, state: int) -> ControlPattern:
        """Return the control pattern at ``state``; raise UnknownName for a number that is no state's."""
        state = self.automaton.state(state)
        lo, hi = self.disabled_offsets[state], self.disabled_offsets[state + 1]
        disabled = tuple(self.automaton.alphabet[e] for e in self.disabled[lo:hi].tolist())
        return ControlPattern(self.automaton.enabled(state), disabled)

    def after(self, trace: Iterable[str] | str) -> ControlPattern | None:
        """Return the control pattern after ``trace``, or None if the supervised plant cannot do the trace."""
        from thenar.model.trace import Trace

        names = Trace(trace)
        states = self.automaton.run(names)
        return self.pattern(states[-1]) if len(states) == len(names) + 1 else None

    def __repr__(self) -> str:
        if self.is_empty:
            return "Supervisor: none exists"
        sizes = f"{counted(self.n_states, 'state')}, {counted(self.n_transitions, 'transition')}"
        return f"Supervisor: {sizes}, {counted(len(self.disabled), 'disablement')}"
