"""Forcing: events that a supervisor can make happen, before the clock ticks or before others come.

Let Σ_for be the forcible events, and Σ_pre those that forcing *preempts*: ``tick`` in timed systems; any events,
or all, in untimed ones.  K is *forcibly controllable* with respect to G if after every string s of its closure

* every uncontrollable event that G can do and that is not in Σ_pre is one of K; and
* either every uncontrollable event that G can do and that is in Σ_pre is one of K (nothing is forced),
* or a forcible event is one of K, and no other event of Σ_pre is (one of the forcible ones is forced).

So what is preempted is preempted together: a forced event comes before all of Σ_pre.  Any union of such languages is
one, too: if one of them forces nothing after s, it brings all that the union must have there; if all that have s force
something there, so does the union.  Hence a largest one exists within any specification, and among the nonblocking
ones as well; :func:`supcon_forcing` computes it.  With Σ_pre = {tick} this is the controllability of Brandin and
Wonham; with all events nothing but what is forced happens where something is (compare Reniers and Cai); with no
forcible events, or an empty Σ_pre, it is Ramadge's and Wonham's.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import InputError, UnknownName, counted
from thenar.explicit.control import forbidden
from thenar.explicit.exploration import Automata, Exploration, as_tuple, common_alphabet, ticker
from thenar.explicit.reach import path_to, restrict
from thenar.explicit.rows import bytemask, entries, kept, row_offsets, sources
from thenar.explicit.timed import TICK
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.limits import Limits, Progress
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace

__all__ = ["ForcingSupervisor", "is_forcibly_controllable", "supcon_forcing"]

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ForcingSupervisor(Supervisor):
    """A supervisor that also forces: in some of its states one of the forcible events has to be started at once.

    There the events of ``preempted`` are not enabled, though the plant could do them, uncontrollable ones too.
    ``forcing``: (n_states,) bool, the states in which it forces.  Otherwise it is a :class:`Supervisor`.

    >>> alphabet = Alphabet([TICK, Event("stop", forcible=True)])
    >>> plant = Automaton.from_transitions(
    ...     ["0 -tick-> 1 -stop-> 0", "1 -tick-> 1"], initial="0", marked=["0"], events=alphabet)
    >>> spec = Automaton.from_transitions(["0 -tick-> 1 -stop-> 0"], initial="0", marked=["0", "1"], events=alphabet)
    >>> supervisor = supcon_forcing(plant, spec)
    >>> supervisor
    ForcingSupervisor: 2 states, 2 transitions, 0 disablements, 1 state in which it forces
    >>> supervisor.forced("0|0"), supervisor.forced("1|1")
    ((), (Event('stop', controllable, forcible),))
    """

    forcing: Bools
    preempted: tuple[str, ...]

    def __post_init__(self) -> None:
        Supervisor.__post_init__(self)  # not super(): a slotted dataclass is another class than the one written here
        self.forcing.flags.writeable = False

    def forced(self, state: str | int) -> tuple[Event, ...]:
        """Return the events one of which is to be forced in ``state``; none where nothing has to be forced."""
        x = self.automaton.state(state)
        return tuple(e for e in self.automaton.enabled(x) if e.forcible) if self.forcing[x] else ()

    def __repr__(self) -> str:
        if self.is_empty:
            return "ForcingSupervisor: none exists"
        sizes = f"{counted(self.n_states, 'state')}, {counted(self.n_transitions, 'transition')}"
        forces = counted(int(self.forcing.sum()), "state")
        return f"ForcingSupervisor: {sizes}, {counted(len(self.disabled), 'disablement')}, {forces} in which it forces"


def supcon_forcing(
    plant: Automata,
    spec: Automata,
    *,
    preempted: Iterable[str] | None = (TICK.name,),
    name: str = "supC",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> ForcingSupervisor:
    """Return the largest forcibly controllable, nonblocking part of what ``plant`` does and ``spec`` allows.

    Forcible are the events with :attr:`Event.forcible`, controllable or not; ``preempted`` are the events that a forced
    one comes before, None for all.  A state is removed if a preempted event would lead out of what is left and no
    forcible one stays inside; where one does, it is forced, and every other preempted event goes.  The rest is as in
    :func:`supcon`, and so are numbering, cost and errors.  No more is forced than must be.

    Raises InputError if a preempted event is none of the problem.   [Golaszewski and Ramadge 1987; Brandin and
    Wonham 1994; Wonham and Cai 2019, ch. 9; Reniers and Cai 2024]

    >>> from thenar.explicit.timed import timed
    >>> jump = Event("jump", forcible=True)
    >>> bus = Automaton.from_transitions(["a -pass-> g"], initial="a", marked=["a", "g"], uncontrollable=["pass"])
    >>> man = Automaton.from_transitions(["r -jump-> c"], initial="r", marked=["r", "c"], events=[jump])
    >>> street = [timed(bus, {"pass": (2, 2)}), timed(man, {"jump": (1, None)})]
    >>> saved = Automaton.from_transitions(["0 -jump-> 1 -pass-> 2"], initial="0", marked=["2"],
    ...     events=[jump, *bus.alphabet])
    >>> supervisor = supcon_forcing(street, saved)
    >>> supervisor
    ForcingSupervisor: 5 states, 5 transitions, 0 disablements, 1 state in which it forces
    >>> [(supervisor.automaton.states[x], supervisor.forced(x)) for x in range(5) if supervisor.forcing[x]]
    [('a|1|r|0|0', (Event('jump', controllable, forcible),))]
    """
    plants, specs = as_tuple(plant), as_tuple(spec)
    alphabet = common_alphabet((*plants, *specs))
    kinds = _Kinds.of(alphabet, preempted)
    if any(a.is_empty for a in (*plants, *specs)):
        return _none(alphabet, name, kinds)
    tick = ticker(limits, progress)
    exploration = Exploration(plants, specs, alphabet, tick, uncontrollable=kinds.hard)
    exploration.native.fixpoint(tick)  # as if preempted events were controllable: what goes now goes anyway
    whole = exploration.extract(name, tick)
    if whole.automaton.is_empty:
        return _none(alphabet, name, kinds)
    owner = np.repeat(np.arange(whole.automaton.n_states), np.diff(whole.disabled_offsets))
    game = _Game(whole.automaton, kinds, owner, whole.disabled)
    game.play(tick)
    return game.result(tick)


def is_forcibly_controllable(
    spec: Automata,
    plant: Automata,
    *,
    preempted: Iterable[str] | None = (TICK.name,),
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Check:
    """Return whether ``spec`` is forcibly controllable with respect to ``plant``, on the strings that both can do.

    The witness leads to where it is not, on a shortest way, and ends with the event in question.  O(|δ|) of their
    product.  Errors as for :func:`supcon_forcing`, sources too.

    >>> alphabet = Alphabet([TICK, Event("stop", forcible=True)])
    >>> plant = Automaton.from_transitions(["0 -tick-> 1 -stop-> 0", "1 -tick-> 1"], initial="0", events=alphabet)
    >>> spec = Automaton.from_transitions(["0 -tick-> 1 -stop-> 0"], initial="0", events=alphabet)
    >>> never = Automaton.from_transitions(["0 -tick-> 1"], initial="0", events=alphabet, alphabet=["stop"])
    >>> print(is_forcibly_controllable(spec, plant))
    forcibly controllable: yes
    >>> print(is_forcibly_controllable(never, plant))
    forcibly controllable: no after tick, tick: 'tick' is forbidden in state '1|1', and no forcible event is left there
    """
    title = "forcibly controllable"
    plants, specs = as_tuple(plant), as_tuple(spec)
    alphabet = common_alphabet((*plants, *specs))
    kinds = _Kinds.of(alphabet, preempted)
    if any(a.is_empty for a in (*plants, *specs)):
        return Check(title, True)
    tick = ticker(limits, progress)
    # nothing is illegal to the kernel: then all that is forbidden is listed, also what nothing preempts
    exploration = Exploration(plants, specs, alphabet, tick, uncontrollable=np.zeros_like(kinds.hard))
    whole = exploration.extract("", tick)
    a = whole.automaton
    source, owner = sources(a), np.repeat(np.arange(a.n_states), np.diff(whole.disabled_offsets))
    breaks, forces, can_force, keeps = (np.zeros(a.n_states, np.bool_) for _ in range(4))
    breaks[owner[kinds.hard[whole.disabled]]] = True
    forces[owner[kinds.free[whole.disabled]]] = True
    can_force[source[kinds.forcible[a.events]]] = True
    keeps[source[kinds.gone[a.events]]] = True
    found = path_to(a, breaks | (forces & (~can_force | keeps)))
    if found is None:
        return Check(title, True)
    trace, x = found
    if breaks[x]:
        lost = forbidden(exploration, int(whole.origin[x]), uncontrollable_only=True)
        event, by, q = next((e, by, q) for e, by, q in lost if kinds.hard[alphabet.index(e)])
        why = f"{event!r}, which nothing preempts, is forbidden by {by.name!r} in state {by.states[q]!r}"
        return Check(title, False, Trace([*trace, event]), why)
    free = next(alphabet[e].name for e in whole.disabled[owner == x].tolist() if kinds.free[e])
    where = f"{free!r} is forbidden in state {a.states[x]!r}"
    if not can_force[x]:
        why = f"{where}, and no forcible event is left there"
        return Check(title, False, Trace([*trace, free]), why)
    kept_event = next(alphabet[e].name for e, _ in a.row(x) if kinds.gone[e])
    why = f"{where}; the event forced there would preempt {kept_event!r} too, which is allowed"
    return Check(title, False, Trace([*trace, kept_event]), why)


@dataclass(frozen=True, slots=True)
class _Kinds:
    """What the events of an alphabet are to forcing, a mask each.

    * ``hard``: uncontrollable, and nothing preempts it
    * ``free``: uncontrollable, and forcing preempts it
    * ``gone``: preempted where another event is forced; a forcible one may be what is forced
    """

    hard: Bools
    free: Bools
    gone: Bools
    forcible: Bools
    preempted: tuple[str, ...]

    @classmethod
    def of(cls, alphabet: Alphabet, preempted: Iterable[str] | None) -> _Kinds:
        """Sort the events; raise InputError for one of ``preempted`` that is not in ``alphabet``."""
        if isinstance(preempted, str):
            raise InputError(f"preempted is a list of events, not the text {preempted!r}")
        chosen = alphabet.names if preempted is None else tuple(preempted)
        for event in chosen:
            if event not in alphabet:
                hint = UnknownName("event", event, alphabet.names)
                raise InputError(f"{hint}: name the events that forced ones preempt, or preempted=None for all")
        before = np.array([e in chosen for e in alphabet.names], np.bool_)
        forcible = np.array([e.forcible for e in alphabet], np.bool_)
        free = alphabet.uncontrollable
        return cls(free & ~before, free & before, before & ~forcible, forcible, chosen)


def _none(alphabet: Alphabet, name: str, kinds: _Kinds) -> ForcingSupervisor:
    nothing = np.zeros(0, np.bool_)
    offsets, disabled = np.zeros(1, np.int64), np.zeros(0, np.int32)
    return ForcingSupervisor(Automaton.empty(alphabet, name), offsets, disabled, nothing, kinds.preempted)


class _Game:
    """The states that are left, and where an event has to be forced; both only ever change in one direction.

    ``owner``, ``lost``: the states of events that the plants can do and the specifications forbid, and these events.
    """

    def __init__(self, automaton: Automaton, kinds: _Kinds, owner: Ints, lost: NDArray[np.int32]) -> None:
        self.a, self.kinds, self.owner, self.lost = automaton, kinds, owner, lost
        n = automaton.n_states
        self.source, self.event, self.target = sources(automaton), automaton.events, automaton.targets
        self.left = np.ones(n, np.bool_)
        self.forces = np.zeros(n, np.bool_)
        self.forces[owner[kinds.free[lost]]] = True
        #: forcible transitions of each state that stay within what is left
        self.ways = np.bincount(self.source[kinds.forcible[self.event]], minlength=n)
        self.into = np.argsort(self.target, kind="stable")  # transitions by the state that they enter
        self.into_offsets = row_offsets(np.bincount(self.target, minlength=n))

    def play(self, tick: kernel.Ticker) -> None:
        """Remove states until nothing forces the removal of another; O(|δ|), and O(|δ|) for each round of blocking."""
        self.remove(np.flatnonzero(self.forces & (self.ways == 0)), tick)
        while self.left[self.a.initial]:
            stays = kept(self.a, self.stays())
            way = kernel.distance_to(stays.offsets, stays.events, stays.targets, bytemask(stays.marked), tick)
            blocking = np.flatnonzero(self.left & (way < 0))
            if not len(blocking):
                return
            self.remove(blocking, tick)

    def remove(self, states: Ints, tick: kernel.Ticker) -> None:
        """Remove ``states``, and all from which something that cannot be helped leads to a removed one."""
        kinds = self.kinds
        while len(states):
            tick.look(self.a.n_states, self.a.n_transitions)
            self.left[states] = False
            edges = self.into[entries(self.into_offsets, states)]
            source, event = self.source[edges], self.event[edges]
            self.forces[source[kinds.free[event]]] = True
            np.subtract.at(self.ways, source[kinds.forcible[event]], 1)
            helpless = kinds.hard[event] | (self.forces[source] & (self.ways[source] == 0))
            states = np.unique(source[helpless & self.left[source]])

    def stays(self) -> Bools:
        """Return (n_transitions,) bool: the transitions among what is left, without those that are preempted."""
        preempted = self.forces[self.source] & self.kinds.gone[self.event]
        stays: Bools = self.left[self.source] & self.left[self.target] & ~preempted
        return stays

    def result(self, tick: kernel.Ticker) -> ForcingSupervisor:
        """Return what is left, numbered breadth-first, with what is disabled and where something is forced."""
        a, kinds = self.a, self.kinds
        if not self.left[a.initial]:
            return _none(a.alphabet, a.name, kinds)
        stays = self.stays()
        rest = restrict(kept(a, stays), self.left)
        part = Exploration((rest,), (), a.alphabet, tick, uncontrollable=np.zeros_like(kinds.hard))
        found = part.extract(a.name, tick)
        states = np.flatnonzero(self.left)[part.coordinates(found.origin)[:, 0]]
        controllable = ~a.alphabet.uncontrollable
        taken = self.left[self.source] & ~stays
        state = np.concatenate((self.source[taken], self.owner))
        event = np.concatenate((self.event[taken], self.lost))
        number = np.full(a.n_states, -1, np.int64)
        number[states] = np.arange(len(states))
        mine = controllable[event] & (number[state] >= 0)
        pairs = np.unique(np.stack((number[state[mine]], event[mine]), axis=1), axis=0)
        offsets = row_offsets(np.bincount(pairs[:, 0], minlength=len(states)))
        return ForcingSupervisor(
            found.automaton,
            offsets,
            pairs[:, 1].astype(np.int32),
            self.forces[states],
            kinds.preempted,
        )
