"""The front door: one call from a Problem to a supervisor, its sizes and its reasons."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from math import prod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from thenar.errors import InputError, LimitReached, about, counted, did_you_mean
from thenar.explicit.exploration import Exploration, Extract, ticker
from thenar.model.automaton import Automaton
from thenar.model.display import Displayable
from thenar.model.limits import Limits, Progress
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor

if TYPE_CHECKING:
    from thenar.explicit.flatten import Flat
    from thenar.model.extended import ExtendedProblem
    from thenar.symbolic.synthesis import SymbolicSupervisor
    from thenar.synthesis.explain import Explanation

__all__ = ["ENGINES", "Size", "SynthesisResult", "synthesize"]

ENGINES = ("explicit", "symbolic")
SURELY_SMALL = 1_000_000  # states of the product: milliseconds of exploration, not worth a thought
LISTED = 4_000_000  # states that engine "auto" lists one by one: about a second, and explanations are at hand
FEW = 64  # automata of a product that may turn out to be small after all
TRIED = 100_000  # states and transitions that are listed to find out: a few milliseconds
TRIED_BYTES = 1 << 30  # memory that engine "auto" gives to counting them
UNFOLDED = 2_000_000  # states of a symbolic supervisor that are listed when someone wants them one by one


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

    * ``engine``, ``engine_reason``: which engine ran, and why that one
    * ``timings``: wall seconds of each phase
    * ``evidence``: of the explicit engine, the explored product with the rank and reason of every removed
      state; None where an automaton is empty, and there is nothing to explore
    * ``symbolic``: of the symbolic engine, the supervisor as sets of states
    * ``flat``: of the explicit engine and an extended problem, that problem with its states listed

    >>> from thenar.library.classics import cat_and_mouse
    >>> result = synthesize(cat_and_mouse())
    >>> bool(result), result.size, result.reason
    (True, Size(states=6, transitions=9), None)
    """

    problem: Problem | ExtendedProblem
    engine: str
    engine_reason: str
    timings: Mapping[str, float]
    evidence: Exploration | None = None
    extract: Extract | None = None
    symbolic: SymbolicSupervisor | None = field(default=None)
    flat: Flat | None = field(default=None)

    def __bool__(self) -> bool:
        if self.symbolic is not None:
            return not self.symbolic.is_empty
        return self.extract is not None and not self.extract.automaton.is_empty

    @property
    def plain(self) -> Problem:
        """The problem as the explicit engine solved it: without variables and conditions.

        Raises InputError for an extended problem that the symbolic engine solved.
        """
        if self.flat is not None:
            return self.flat.problem
        if not isinstance(self.problem, Problem):
            raise InputError("this needs the states one by one: synthesize(problem, 'explicit')")
        return self.problem

    @property
    def seconds(self) -> float:
        """Wall seconds of the whole synthesis."""
        return sum(self.timings.values())

    @cached_property
    def supervisor(self) -> Supervisor:
        """The largest supervisor, state by state; empty if none exists, and then ``reason`` says why.

        Raises LimitReached for a symbolic one of more than 2 000 000 states.
        """
        if self.symbolic is not None:
            if self.symbolic.n_states > UNFOLDED:
                raise LimitReached("states", UNFOLDED, self.symbolic.n_states, 0)
            from thenar.synthesis.unfold import unfold

            return unfold(self.symbolic)
        if self.extract is None:
            return Supervisor(Automaton.empty(self.problem.alphabet), np.zeros(1, np.int64), np.zeros(0, np.int32))
        if self.flat is not None and not self.flat.is_plain:
            raise InputError("several initial states, or an event with several outcomes: no deterministic automaton")
        # what flattening added to the alphabet stands behind it, and never happens under supervision
        automaton = replace(self.extract.automaton, alphabet=self.problem.alphabet)
        return Supervisor(automaton, self.extract.disabled_offsets, self.extract.disabled)

    @cached_property
    def size(self) -> Size:
        """States and transitions of the supervisor, exactly; an event's several outcomes are one transition.

        Counting the transitions of a symbolic one may take longer than the synthesis; ``symbolic.n_states`` does not.
        """
        if self.symbolic is not None:
            return Size(self.symbolic.n_states, self.symbolic.n_transitions)
        if self.extract is None or self.evidence is None:
            return Size(0, 0)
        automaton = self.extract.automaton
        if self.flat is None:
            return Size(automaton.n_states, automaton.n_transitions)
        real = self.evidence.coordinates(self.extract.origin)[:, 0] < len(self.flat.states)
        return Size(int(real.sum()), int(np.diff(automaton.offsets)[real].sum()))

    @cached_property
    def explored(self) -> Size:
        """States and transitions of the product that were looked at; the symbolic engine counts states only."""
        if self.symbolic is not None:
            return Size(self.symbolic.reachable.count(), 0)
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
        if self.symbolic is not None:
            found, whole = about(self.symbolic.n_states), about(self.explored.states)
            return f"{title}: {found} states, of {whole} reachable (symbolic)"
        sizes = f"{counted(self.size.states, 'state')}, {counted(self.size.transitions, 'transition')}"
        return f"{title}: {sizes}, of {self.explored.states:,} explored ({self.engine})"


def synthesize(
    problem: Problem | ExtendedProblem,
    engine: str = "auto",
    *,
    order: str | Sequence[str] = "auto",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> SynthesisResult:
    """Return the largest controllable, nonblocking supervisor for ``problem``.

    The supervisor is the part of plants || specs that survives when these states are removed until none is
    left to remove: those where the plants can do an uncontrollable event that a specification forbids, those
    from which an uncontrollable event leads to a removed state, and those from which no marked state can be
    reached.  It exists exactly if the initial state survives.   [Ramadge and Wonham 1987]

    * ``"explicit"`` lists the states: time as for :func:`supcon`; memory some 40 bytes a state and 4 a transition
      of the product
    * ``"symbolic"`` works on sets of states: time and memory depend on how well the parts can be told apart, not
      on the number of states; ``order`` lists the parts from the top level of the diagrams, or says how to order them
    * ``"auto"`` takes the first for up to four million states, else the second, and says why

    ``progress(states, transitions)`` is called a few times a second; of diagrams it gets nodes and steps.  Raises
    InputError for an unknown engine and LimitReached at one of ``limits``; can be interrupted.

    >>> from thenar.library.classics import small_factory, transfer_line
    >>> result = synthesize(small_factory())
    >>> result.supervisor
    Supervisor: 12 states, 25 transitions, 6 disablements
    >>> print(result.supervisor.pattern(0))
    enabled: start_1; disabled: start_2
    >>> many = synthesize(transfer_line(20))
    >>> many.engine, many.size.states == 28 ** 20
    ('symbolic', True)
    """
    if engine not in ("auto", *ENGINES):
        valid = ", ".join(("auto", *ENGINES))
        raise InputError(f"unknown engine {engine!r}{did_you_mean(engine, ENGINES)}; there are: {valid}")
    start = time.perf_counter()
    if isinstance(problem, Problem) and any(a.is_empty for a in problem.automata):
        return SynthesisResult(problem, "explicit", "an automaton has no states", {})
    if not isinstance(problem, Problem):
        if engine == "explicit" or not all(a.states for a in problem.automata):  # a part without states: none exists
            return _flattened(problem, limits, progress)
        return _symbolic(problem, "the problem has variables or conditions", order, limits, progress)
    if engine == "explicit":
        return _explicit(problem, "asked for", limits, progress)
    if engine == "symbolic":
        return _symbolic(problem, "asked for", order, limits, progress)
    most = prod(a.n_states for a in problem.automata)
    if most <= SURELY_SMALL:
        return _explicit(problem, f"the product has at most {most:,} states", limits, progress)
    if len(problem.automata) <= FEW:
        bounds = limits or Limits()
        tried = replace(
            bounds, states=min(bounds.states or TRIED, TRIED), transitions=min(bounds.transitions or TRIED, TRIED)
        )
        try:
            return _explicit(problem, f"the product has at most {TRIED:,} transitions", tried, progress)
        except LimitReached as reached:
            if reached.limit not in ("states", "transitions"):
                raise
    return _counted(problem, order, limits, progress, start)


def _counted(
    problem: Problem, order: str | Sequence[str], limits: Limits | None, progress: Progress | None, begun: float
) -> SynthesisResult:
    """Count the states first: diagrams mostly do that in no time; then take the engine that suits the number."""
    from thenar.symbolic.encode import Encoding
    from thenar.symbolic.synthesis import explore, supremal

    bounds = limits or Limits()
    tried = replace(bounds, bytes=TRIED_BYTES if bounds.bytes is None else min(bounds.bytes, TRIED_BYTES))
    start = time.perf_counter()
    try:
        with _of_diagrams():
            encoding = Encoding(problem, ticker(tried, progress, start - begun), order=order, limits=tried)
            encoded = time.perf_counter()
            encoding, reachable = explore(encoding)
            n = reachable.count()
    except LimitReached as reached:
        if reached.limit != "bytes":
            raise
        spent = time.perf_counter() - begun
        return _explicit(problem, f"diagrams take more than {TRIED_BYTES >> 20} MiB", limits, progress, spent)
    why = f"the product has {about(n)} reachable states"
    if n <= LISTED:
        return _explicit(problem, why, limits, progress, time.perf_counter() - begun)
    encoding.bound(limits)
    with _of_diagrams():
        supervisor = supremal(encoding, reachable)
    encoding.at_leisure()
    clock = (start, encoded, time.perf_counter())
    return SynthesisResult(problem, "symbolic", why, _phases(("encode", "saturate"), clock), symbolic=supervisor)


def _flattened(problem: ExtendedProblem, limits: Limits | None, progress: Progress | None) -> SynthesisResult:
    """List the states of ``problem``, then synthesise."""
    from thenar.explicit.flatten import flatten

    start = time.perf_counter()
    flat = flatten(problem, ticker(limits, progress))
    seconds = time.perf_counter() - start
    if any(a.is_empty for a in flat.problem.automata):
        return SynthesisResult(problem, "explicit", "asked for", {"flatten": seconds}, flat=flat)
    found = _explicit(flat.problem, "asked for", limits, progress, seconds)
    return replace(found, problem=problem, flat=flat, timings={"flatten": seconds, **found.timings})


def _explicit(
    problem: Problem, why: str, limits: Limits | None, progress: Progress | None, spent: float = 0.0
) -> SynthesisResult:
    clock = [time.perf_counter()]
    tick = ticker(limits, progress, spent)
    evidence = Exploration(problem.plants, problem.specs, problem.alphabet, tick)
    clock.append(time.perf_counter())
    evidence.native.fixpoint(tick)
    clock.append(time.perf_counter())
    extract = evidence.extract("supC", tick)
    clock.append(time.perf_counter())
    return SynthesisResult(
        problem, "explicit", why, _phases(("explore", "fixpoint", "extract"), clock), evidence, extract
    )


def _symbolic(
    problem: Problem | ExtendedProblem,
    why: str,
    order: str | Sequence[str],
    limits: Limits | None,
    progress: Progress | None,
) -> SynthesisResult:
    from thenar.symbolic.encode import Encoding
    from thenar.symbolic.synthesis import explore, supremal

    clock = [time.perf_counter()]
    with _of_diagrams():
        encoding = Encoding(problem, ticker(limits, progress), order=order, limits=limits)
        clock.append(time.perf_counter())
        supervisor = supremal(*explore(encoding))
    supervisor.encoding.at_leisure()
    clock.append(time.perf_counter())
    return SynthesisResult(problem, "symbolic", why, _phases(("encode", "saturate"), clock), symbolic=supervisor)


@contextmanager
def _of_diagrams() -> Iterator[None]:
    """Say of a computation that is stopped how large its diagrams were: no state had been found one by one."""
    try:
        yield
    except LimitReached as reached:
        found = f"the diagrams had {reached.states:,} nodes by then"
        raise LimitReached(reached.limit, reached.bound, 0, 0, found) from None


def _phases(names: Sequence[str], clock: Sequence[float]) -> dict[str, float]:
    return {name: end - start for name, (start, end) in zip(names, pairwise(clock), strict=True)}
