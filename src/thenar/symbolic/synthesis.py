"""The largest supervisor, as a set of states."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import LimitReached, about, counted
from thenar.model.events import Event
from thenar.model.limits import Limits
from thenar.model.supervisor import ControlPattern
from thenar.model.trace import Trace
from thenar.symbolic.encode import Encoding, EventRelation

__all__ = ["Removal", "SymbolicSupervisor", "explore", "reach", "supremal"]

FIRST_STEPS = 32  # for each part and event: about what it takes to encode the problem once more
ROOM = 4  # how many times the memory of an encoding its reverse may take


class Removal(NamedTuple):
    """States removed in one round: ``states``, from which uncontrollable events lead to ``seeds``.

    ``reason`` is ``"illegal"`` (a specification is broken in the seeds) or ``"blocking"``.
    """

    reason: str
    seeds: kernel.Set
    states: kernel.Set


class SymbolicSupervisor:
    """The largest supervisor of a problem, as sets of states; empty if none exists.

    * ``reachable``: states that plants and specifications can reach together
    * ``safe``: those of them that the supervisor may let the plants enter
    * ``controlled``: those that it does let them reach
    * ``removals``: what was removed, round by round, and why

    >>> from thenar.library.classics import dining
    >>> from thenar.synthesis.api import synthesize
    >>> supervisor = synthesize(dining(100), "symbolic").symbolic
    >>> supervisor.n_states
    189482250299273866835746159841800035873
    >>> "take_left_2" in supervisor.after("take_left_1")
    True
    """

    def __init__(
        self,
        encoding: Encoding,
        reachable: kernel.Set,
        safe: kernel.Set,
        controlled: kernel.Set,
        removals: Sequence[Removal] = (),
    ) -> None:
        self.encoding = encoding
        self.reachable, self.safe, self.controlled = reachable, safe, controlled
        self.removals = tuple(removals)
        self.events = {e.name: e for e in encoding.events}

    @property
    def is_empty(self) -> bool:
        """True if no supervisor exists."""
        return not self.controlled

    @cached_property
    def n_states(self) -> int:
        """States of the supervised plant, exactly."""
        return self.controlled.count()

    @cached_property
    def n_transitions(self) -> int:
        """Pairs of a state of the supervised plant and an event that may happen there, exactly."""
        events = self.encoding.events
        single = [e.relation for e in events if not e.choice]
        several = sum((self.controlled & self.enabled(e)).count() for e in events if e.choice)
        return self.encoding.forest.count_steps(self.controlled, single, self.encoding.tick) + several

    def enabled(self, event: EventRelation) -> kernel.Set:
        """Return states in which ``event`` can happen and leads to safe ones only."""
        f = self.encoding.forest
        back = f.inverse(event.relation)
        enabled = f.image(self.safe, back)
        return enabled - f.image(self.reachable - self.safe, back) if event.choice else enabled

    def vectors(self, limit: int) -> NDArray[np.uint32]:
        """Return (n, parts) uint32: the value of each part of the encoding in each state, at most ``limit`` states."""
        levels = self.controlled.vectors(limit).reshape(-1, len(self.encoding.parts))
        columns = np.empty_like(levels)
        columns[:, self.encoding.order] = levels
        return columns

    def after(self, trace: Iterable[str] | str) -> ControlPattern | None:
        """Return the control pattern after ``trace``, or None if the supervised plant cannot do the trace.

        Where the trace does not tell the state, an event is enabled or disabled if it is so in one of those possible.
        """
        states = self.states_after(trace)
        return self.pattern(states) if states else None

    def states_after(self, trace: Iterable[str] | str) -> kernel.Set:
        """Return the states of the supervised plant that ``trace`` may have led to."""
        states = self.encoding.initial & self.controlled
        for name in Trace(trace):
            states = self.follow(states, name)
        return states

    def follow(self, states: kernel.Set, name: str) -> kernel.Set:
        """Return the states that the event called ``name`` may lead to from ``states``; none where it is disabled."""
        self.encoding.alphabet.index(name)
        event = self.events.get(name)
        if event is None:
            return self.encoding.forest.nothing
        forest = self.encoding.forest
        entered = forest.image(states, event.relation) & self.reachable
        if event.choice and entered - self.safe:  # disabled as a whole where one outcome must not be
            entered = forest.image(
                states - forest.image(entered - self.safe, forest.inverse(event.relation)), event.relation
            )
        return entered & self.safe

    def pattern(self, states: kernel.Set) -> ControlPattern:
        """Return what is enabled, and what the plant could do but is disabled, somewhere in ``states``."""
        enabled: list[Event] = []
        disabled: list[Event] = []
        forest, events = self.encoding.forest, self.encoding.events
        first = states.vectors(2)
        if len(first) == len(self.encoding.parts):  # in one state it is enough to look where each event leads
            possible = forest.contains(first, [e.possible for e in events])
            leads = forest.lead_into(self.safe, first, [e.relation for e in events])
        for k, e in enumerate(events):
            if len(first) == len(self.encoding.parts) and not (e.choice and possible[k]):
                may, does = possible[k], leads[k]
            else:
                here = states & e.possible
                may, does = bool(here), bool(here and self.follow(here, e.name))
            if may:
                (enabled if does else disabled).append(self.encoding.alphabet[e.name])
        return ControlPattern(tuple(enabled), tuple(disabled))

    def __repr__(self) -> str:
        if self.is_empty:
            return "SymbolicSupervisor: none exists"
        nodes = counted(self.controlled.n_nodes, "node")
        return f"SymbolicSupervisor: {about(self.n_states)} states in {nodes}"


def explore(encoding: Encoding) -> tuple[Encoding, kernel.Set]:
    """Return the states that plants and specifications reach, on ``encoding`` or on the same with its levels reversed.

    An order of levels and its reverse may cost the same by any measure of spans, and yet one of them take a hundred
    times as long.  Where the search for an order says that both are as good, they are given steps by turns, ever more,
    until one of them has found all states: that takes a few times as long as the better one, and nothing if the first
    is done soon.  Steps, not seconds: the same problem gets the same order every time.
    """
    run = _Run(encoding)
    if not encoding.reversible:
        return encoding, run.until_done()
    steps = FIRST_STEPS * (len(encoding.parts) + len(encoding.events))
    found = run(steps)
    if found is None:
        run, found = _raced(run, steps)
    return run.encoding, found


def reach(encoding: Encoding) -> kernel.Set:
    """Return the states that plants and specifications reach together, by saturation."""
    return _Run(encoding).until_done()


class _Run:
    """A search for all reachable states that can be interrupted and taken up again."""

    def __init__(self, encoding: Encoding) -> None:
        self.encoding = encoding
        self.forward = encoding.forest.saturation([e.relation for e in encoding.events])

    def __call__(self, steps: int | None) -> kernel.Set | None:
        return self.forward(self.encoding.initial, self.encoding.invariant, self.encoding.tick, steps)

    def until_done(self) -> kernel.Set:
        return self.forward(self.encoding.initial, self.encoding.invariant, self.encoding.tick)


def _raced(run: _Run, steps: int) -> tuple[_Run, kernel.Set]:
    """Return what is done first: ``run``, which had ``steps``, or the same in reverse; one may run out of memory."""
    encoding = run.encoding
    most, own = encoding.forest.max_bytes, encoding.forest.bytes
    names = [encoding.parts[k].name for k in encoding.order[::-1]]
    runs = [run]
    with _out_of_memory():
        room = Limits(bytes=min(ROOM * own, max(0, most - own)))
        runs.append(_Run(Encoding(encoding.problem, encoding.tick, order=names, limits=room)))
    while len(runs) > 1:
        other, run = runs
        steps *= 2
        run.encoding.forest.max_bytes = max(0, most - other.encoding.forest.bytes)
        found, runs = None, [other]
        with _out_of_memory():
            found, runs = run(steps), [run, other]
        run.encoding.forest.max_bytes = most
        if found is not None:
            return run, found
    return runs[0], runs[0].until_done()


@contextmanager
def _out_of_memory() -> Iterator[None]:
    try:
        yield
    except LimitReached as reached:
        if reached.limit != "bytes":
            raise


def supremal(encoding: Encoding, reachable: kernel.Set) -> SymbolicSupervisor:
    """Return the largest controllable, nonblocking supervisor of ``encoding``.

    Of the ``reachable`` states (see :func:`reach`) the illegal ones are removed, and those from which
    uncontrollable events lead there; then, until nothing changes, those from which no marked state can be
    reached, and those from which uncontrollable events lead to them.  A controllable event that may lead from
    one state to several is disabled where one of these is removed.
    """
    f, tick = encoding.forest, encoding.tick
    events = encoding.events
    illegal = [e.possible - e.allowed for e in events if not e.controllable]
    bad = reachable & f.any_of([s for s in illegal if s], tick) | reachable - f.all_of(
        encoding.requirements, tick, reachable
    )
    inverse = {e.name: f.inverse(e.relation) for e in events}
    uncontrolled = f.saturation([inverse[e.name] for e in events if not e.controllable])
    removals = [Removal("illegal", bad, uncontrolled(bad, reachable, tick))] if bad else []
    safe = reachable - removals[0].states if removals else reachable
    choices = any(e.controllable and e.choice for e in events)
    backward = f.saturation([inverse[e.name] for e in events])
    while safe:
        if choices:
            backward = f.saturation([f.inverse(r) for r in _kept(encoding, inverse, reachable - safe)])
        blocking = safe - backward(encoding.marked & safe, safe, tick)
        if not blocking:
            break
        removals.append(Removal("blocking", blocking, uncontrolled(blocking, safe, tick)))
        safe -= removals[-1].states
    if not removals:
        return SymbolicSupervisor(encoding, reachable, safe, reachable)
    forward = f.saturation(_kept(encoding, inverse, reachable - safe))
    return SymbolicSupervisor(encoding, reachable, safe, forward(encoding.initial & safe, safe, tick), removals)


def _kept(encoding: Encoding, inverse: dict[str, int], removed: kernel.Set) -> Sequence[int]:
    """Return what the events still do when one that may lead to ``removed`` is disabled wherever it may."""
    f = encoding.forest
    return [
        f.restrict(e.relation, ~f.image(removed, inverse[e.name])) if e.controllable and e.choice else e.relation
        for e in encoding.events
    ]
