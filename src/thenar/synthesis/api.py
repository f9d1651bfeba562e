"""The front door: one call from a Problem to a supervisor, its sizes and its reasons."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from thenar.errors import InputError, counted, did_you_mean
from thenar.explicit.exploration import Exploration, Extract, ticker
from thenar.model.automaton import Automaton
from thenar.model.display import Displayable
from thenar.model.limits import Limits, Progress
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor

if TYPE_CHECKING:
    from thenar.synthesis.explain import Explanation

__all__ = ["ENGINES", "Size", "SynthesisResult", "synthesize"]

ENGINES = ("explicit",)


class Size(NamedTuple):
    """How large something is.

    >>> Size(12, 25).states
    12
    """

    states: int
    transitions: int


@dataclass(frozen=True, eq=False, repr=False)
class SynthesisResult(Displayable):
    """What :func:`synthesize` found: true exactly if a supervisor exists.

    * ``supervisor``: the largest one; empty if none exists, and then ``reason`` says why
    * ``engine``, ``engine_reason``: which engine ran, and why that one
    * ``timings``: wall seconds of each phase
    * ``evidence``: the explored product with the rank and reason of every removed state; None where an
      automaton is empty, and there is nothing to explore

    >>> from thenar.library.classics import cat_and_mouse
    >>> result = synthesize(cat_and_mouse())
    >>> bool(result), result.size, result.reason
    (True, Size(states=6, transitions=9), None)
    """

    problem: Problem
    supervisor: Supervisor
    engine: str
    engine_reason: str
    timings: Mapping[str, float]
    evidence: Exploration | None
    extract: Extract | None

    def __bool__(self) -> bool:
        return not self.supervisor.is_empty

    @property
    def seconds(self) -> float:
        """Wall seconds of the whole synthesis."""
        return sum(self.timings.values())

    @property
    def size(self) -> Size:
        """States and transitions of the supervisor."""
        return Size(self.supervisor.n_states, self.supervisor.n_transitions)

    @property
    def explored(self) -> Size:
        """States and transitions of the product that were looked at."""
        return Size(self.evidence.n_states, self.evidence.native.n_transitions) if self.evidence else Size(0, 0)

    @cached_property
    def reason(self) -> Explanation | None:
        """Why no supervisor exists; None if one does."""
        from thenar.synthesis.explain import explain_empty

        return None if self else explain_empty(self)

    def __repr__(self) -> str:
        title = f"SynthesisResult {self.problem.name!r}" if self.problem.name else "SynthesisResult"
        if not self:
            return f"{title}: no supervisor exists"
        sizes = f"{counted(self.size.states, 'state')}, {counted(self.size.transitions, 'transition')}"
        return f"{title}: {sizes}, of {self.explored.states:,} explored ({self.engine})"


def synthesize(
    problem: Problem,
    engine: str = "auto",
    *,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> SynthesisResult:
    """Return the largest controllable, nonblocking supervisor for ``problem``.

    The supervisor is the part of plants || specs that survives when these states are removed until none is
    left to remove: those where the plants can do an uncontrollable event that a specification forbids, those
    from which an uncontrollable event leads to a removed state, and those from which no marked state can be
    reached.  It exists exactly if the initial state survives.   [Ramadge and Wonham 1987]

    ``engine`` is ``"auto"`` or ``"explicit"``; ``progress(states, transitions)`` is called a few times a
    second.  Time as for :func:`supcon`; memory some 40 bytes a state and 4 a transition of the product.  Raises
    InputError for an unknown engine and LimitReached at one of ``limits``; can be interrupted.

    >>> from thenar.library.classics import small_factory
    >>> result = synthesize(small_factory())
    >>> result.supervisor
    Supervisor: 12 states, 25 transitions, 6 disablements
    >>> print(result.supervisor.pattern(0))
    enabled: start_1; disabled: start_2
    """
    if engine not in ("auto", *ENGINES):
        valid = ", ".join(("auto", *ENGINES))
        raise InputError(f"unknown engine {engine!r}{did_you_mean(engine, ENGINES)}; there are: {valid}")
    why = "the only engine there is" if engine == "auto" else "asked for"
    empty = [a.name for a in problem.automata if a.is_empty]
    if empty:
        nothing = Supervisor(Automaton.empty(problem.alphabet), np.zeros(1, np.int64), np.zeros(0, np.int32))
        return SynthesisResult(problem, nothing, "explicit", why, {}, None, None)
    clock = [time.perf_counter()]
    tick = ticker(limits, progress)
    evidence = Exploration(problem.plants, problem.specs, problem.alphabet, tick)
    clock.append(time.perf_counter())
    evidence.native.fixpoint(tick)
    clock.append(time.perf_counter())
    extract = evidence.extract("supC", tick)
    supervisor = Supervisor(extract.automaton, extract.disabled_offsets, extract.disabled)
    clock.append(time.perf_counter())
    phases = ("explore", "fixpoint", "extract")
    timings = {phase: end - start for phase, start, end in zip(phases, clock, clock[1:], strict=False)}
    return SynthesisResult(problem, supervisor, "explicit", why, timings, evidence, extract)
