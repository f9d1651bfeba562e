"""On a sampled device: does a supervisor still mean the same when it is a program that reads, decides and writes?"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError, counted
from thenar.explicit.components import heights, strong_components, way_round
from thenar.explicit.control import closed_loop, obeyed
from thenar.explicit.exploration import Automata
from thenar.explicit.language import minimize
from thenar.explicit.reach import distance_to_marked, path_to
from thenar.explicit.rows import kept, sources
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace

__all__ = [
    "fit_for_sampling",
    "has_bounded_response",
    "is_avalanche_free",
    "is_choice_free",
    "is_confluent",
    "is_delay_insensitive",
    "is_interleave_insensitive",
    "is_nonblocking_under_control",
    "longest_burst",
]

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]
_SEVERAL = -1


def fit_for_sampling(supervisor: Supervisor, plant: Automata, commands: Iterable[str] | None = None) -> list[Check]:
    """Return what must hold for the closed loop S/G to run as a program with a scan cycle, each with its evidence.

    A scan reads the inputs, follows the events that they mean, starts commands that are enabled, and writes them.
    ``commands`` are the events that the program generates, by default all controllable ones; all other events are
    *inputs*.  The checks are the seven functions of this module.  Hardly any supervisor passes all of them, and not
    every program needs all: one that waits for the answer to each command, as :func:`thenar.execute` does, has no
    bursts to be confluent.  What fails tells where the program has to be more careful than the supervisor.

    In all of them L is the closed behaviour of S/G, and two strings *have the same future* if the same strings,
    and the same marked ones, can follow: then the supervisor will never tell them apart.  Avalanches are looked for in
    S alone, which is the program.  O(|δ| d log |δ|) for d events enabled in one state, after minimising S/G.

    [Balemi 1992; Fabian and Hellgren 1998; Dietrich, Malik, Wonham and Brandin 2002; Leduc, Wang and Ahmed 2014;
    Zaytoon and Riera 2017; Reijnen et al. 2019]

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> problem = small_factory()
    >>> for check in fit_for_sampling(synthesize(problem).supervisor, problem.plants):
    ...     print(check)
    bounded response: yes
    confluence: yes
    nonblocking under control: no after ε: no marked state is reached by who waits only where no command is enabled
    no choice: yes
    no avalanche: yes
    no simultaneity: yes
    no inexact synchronisation: yes
    """
    chosen = commands if commands is None or isinstance(commands, str) else list(commands)
    scan = _Scan(closed_loop(plant, supervisor), chosen)
    return [
        scan.bounded(),
        scan.confluent(),
        scan.nonblocking(),
        scan.choice_free(),
        is_avalanche_free(obeyed(supervisor), chosen and [c for c in chosen if c in supervisor.automaton.alphabet]),
        scan.interleave_insensitive(),
        scan.delay_insensitive(),
    ]


def has_bounded_response(loop: Automaton, commands: Iterable[str] | None = None) -> Check:
    """Return whether commands cannot follow each other for ever: a scan ends.

    No infinite string of ``commands`` is possible after a string of L.  If so, ``reason`` says how many can follow each
    other at most.  The witness goes once round a circle of commands.  With the inputs as ``commands`` it is the
    other half of what CIF calls bounded response.  O(|δ|).   [Dietrich et al. 2002; Reijnen et al. 2019]

    >>> loop = Automaton.from_transitions(["0 -on-> 1 -off-> 0", "1 -done-> 2"], initial="0", uncontrollable=["done"])
    >>> print(has_bounded_response(loop))
    bounded response: no after on, off: the commands on, off can follow each other without end
    >>> has_bounded_response(loop, commands=["on"]).reason
    'at most 1 command without an input in between'
    """
    return _Scan(loop, commands).bounded()


def longest_burst(loop: Automaton, commands: Iterable[str] | None = None) -> Trace | None:
    """Return a longest string of ``commands`` that is possible after some string of L; None if there is no longest.

    O(|δ|).

    >>> loop = Automaton.from_transitions(["0 -open-> 1 -fill,close-> 2 -full-> 3 -close-> 0"], initial="0",
    ...     uncontrollable=["full"])
    >>> longest_burst(loop)
    Trace('close, open, fill')
    """
    return _Scan(loop, commands).burst()


def is_confluent(loop: Automaton, commands: Iterable[str] | None = None) -> Check:
    """Return whether it does not matter which commands a scan starts, and in what order.

    For all strings t, t' of commands with st, st' ∈ L there are strings of commands r, r' such that str and st'r'
    have the same future: whatever was started, the rest can make up for it.  With bounded response all bursts after s
    then end alike.  The witness is s and a burst; its ``reason`` names another one that ends differently.  A state
    must reach one bottom component of the graph of commands only: O(|δ|).   [Dietrich et al. 2002; Newman 1942]

    >>> arrows = ["0 -left-> 1 -up-> 2", "0 -up-> 3 -left-> 2", "3 -stop-> 4"]
    >>> print(is_confluent(Automaton.from_transitions(arrows, initial="0", marked=["2"])))
    confluence: no after left, up: the commands up, stop instead of left, up lead to where nothing makes them meet again
    """
    return _Scan(loop, commands).confluent()


def is_nonblocking_under_control(loop: Automaton, commands: Iterable[str] | None = None) -> Check:
    """Return whether a marked state stays in reach of a program that starts commands as long as any is enabled.

    After each s ∈ L there is a string t such that st is marked, no command is enabled after it, and each input of
    t comes where no command is enabled: the program never waits while it could start something.  The witness is a
    shortest s without such a t.  O(|δ|).   [Dietrich et al. 2002, Malik 2003; CIF, controller properties checker]

    >>> loop = Automaton.from_transitions(["0 -try-> 1 -again-> 0", "1 -done-> 2"], initial="0", marked=["2"],
    ...     uncontrollable=["done"])
    >>> print(is_nonblocking_under_control(loop))
    nonblocking under control: no after ε: no marked state is reached by who waits only where no command is enabled
    """
    return _Scan(loop, commands).nonblocking()


def is_choice_free(loop: Automaton, commands: Iterable[str] | None = None) -> Check:
    """Return whether the program never has to choose: of two commands that are enabled either may come first.

    If sa, sb ∈ L for two commands a and b then sab, sba ∈ L, and they have the same future.  Otherwise
    the supervisor leaves a choice to the program, and what it always takes may keep it from ever getting
    elsewhere.  The witness is sa where b is lost, sab where sba leads elsewhere.  O(|δ| d log |δ|).
    [Fabian and Hellgren 1998: choice]

    >>> loop = Automaton.from_transitions(["fork -left-> tree", "fork -right-> house"], initial="fork")
    >>> print(is_choice_free(loop))
    no choice: no after left: command 'right' was enabled as well, and is not any more
    """
    return _Scan(loop, commands).choice_free()


def is_avalanche_free(loop: Automaton, commands: Iterable[str] | None = None) -> Check:
    """Return whether one change of an input moves the supervisor once.

    If su, suu ∈ L for an input u they have the same future.  Otherwise a program that tests one transition
    after the other while u is on in this scan goes through both of them, though u came once.  The witness is
    suu.  O(|δ| log |δ|).   [Fabian and Hellgren 1998: avalanche effect]

    >>> loop = Automaton.from_transitions(["0 -part-> 1 -part-> 2 -go-> 0"], initial="0", uncontrollable=["part"])
    >>> print(is_avalanche_free(loop))
    no avalanche: no after part, part: one 'part' can be taken for two
    """
    return _Scan(loop, commands).avalanche_free()


def is_interleave_insensitive(loop: Automaton, commands: Iterable[str] | None = None) -> Check:
    """Return whether the order of two inputs that are read in one scan does not matter.

    If su, sv ∈ L for two inputs u and v, and suv ∈ L or svu ∈ L, so that both can come, then both are in L
    and have the same future.  Inputs that exclude each other are no trouble.  The witness is suv, ``reason`` says
    what is different after svu.  O(|δ| d log |δ|).

    Two inputs at a time: three that come in one scan are not looked at where no two of them can follow each other
    directly.   [Fabian and Hellgren 1998: simultaneity; Leduc, Wang and Ahmed 2014 for strings of a sampling period]

    >>> race = ["0 -a-> 1 -b-> 2", "0 -b-> 3 -a-> 4 -prize-> 2"]
    >>> loop = Automaton.from_transitions(race, initial="0", uncontrollable=["a", "b"])
    >>> print(is_interleave_insensitive(loop))
    no simultaneity: no after a, b: b, a instead leads elsewhere, and a scan reads both at once
    """
    return _Scan(loop, commands).interleave_insensitive()


def is_delay_insensitive(loop: Automaton, commands: Iterable[str] | None = None) -> Check:
    """Return whether a command stays right when an input comes between the decision and the act.

    If sc, su ∈ L for a command c and an input u then suc ∈ L: c is still enabled after u.  And if scu ∈ L, by
    which the supervisor follows what it sees, it has the same future as suc, which is what the plant did.  The
    witness is su or suc.  O(|δ| d log |δ|).   [Balemi 1992: delay-insensitive languages; Fabian and Hellgren 1998:
    inexact synchronisation]

    >>> arrows = ["0 -lift-> 1 -slip-> 2", "0 -slip-> 3"]
    >>> print(is_delay_insensitive(Automaton.from_transitions(arrows, initial="0", uncontrollable=["slip"])))
    no inexact synchronisation: no after slip: command 'lift', decided on before 'slip', is not enabled any more
    """
    return _Scan(loop, commands).delay_insensitive()


@dataclass(frozen=True, slots=True)
class _Wrong:
    """What is wrong with a state: ``then`` what happens there, and a sentence about its end."""

    then: tuple[str, ...]
    reason: str


class _Scan:
    """A minimal closed loop, in which states with the same future are one, as a program sees it."""

    def __init__(self, loop: Automaton, commands: Iterable[str] | None) -> None:
        self.loop = a = minimize(loop)
        chosen = ~a.alphabet.uncontrollable if len(a.alphabet) else np.zeros(0, np.bool_)
        if isinstance(commands, str):
            raise InputError(f"commands is a list of events, not the text {commands!r}")
        if commands is not None:
            chosen = np.zeros(len(a.alphabet), np.bool_)
            chosen[[a.alphabet.index(name) for name in commands]] = True
        self.source = sources(a)
        #: (n_transitions,) whether it is a command
        self.command = chosen[a.events] if a.n_transitions else np.zeros(0, np.bool_)
        self.bursts = kept(a, self.command)
        self.keys = self.source * len(a.alphabet) + a.events

    # -- bursts of commands ------------------------------------------------------------------------------------

    def bounded(self) -> Check:
        """Answer :func:`has_bounded_response`."""
        title, height = "bounded response", heights(self.bursts)
        path = path_to(self.loop, height < 0)
        if path is None:
            many = counted(int(height.max(initial=0)), "command")
            return Check(title, True, reason=f"at most {many} without an input in between")
        trace, q = path
        onward, cycle = way_round(self.bursts, height, q)
        why = f"the commands {', '.join(cycle)} can follow each other without end"
        return Check(title, False, trace + onward + cycle, why)

    def burst(self) -> Trace | None:
        """Answer :func:`longest_burst`."""
        height = heights(self.bursts)
        if (height < 0).any():
            return None
        names: list[str] = []
        q = int(height.argmax()) if len(height) else -1
        while q >= 0 and height[q]:
            event, q = next((e, t) for e, t in self.bursts.row(q) if height[t] == height[q] - 1)
            names.append(self.loop.alphabet[event].name)
        return Trace(names)

    def confluent(self) -> Check:
        """Answer :func:`is_confluent`."""
        title, a = "confluence", self.bursts
        component = strong_components(a.offsets.tolist(), a.targets.tolist())
        # a component is numbered after those that it leads to
        first = component[a.targets] != component[self.source[self.command]]
        leaves, enters = component[self.source[self.command]][first], component[a.targets][first]
        ends = list(range(int(component.max(initial=-1)) + 1))
        for k in np.argsort(leaves, kind="stable").tolist():
            c, there = int(leaves[k]), ends[int(enters[k])]
            ends[c] = there if ends[c] in (c, there) else _SEVERAL
        end = np.array(ends, np.int64)[component]
        path = path_to(self.loop, end == _SEVERAL)
        if path is None:
            return Check(title, True)
        trace, q = path
        here = replace(a, initial=q)
        bottom = end == component
        one, last = path_to(here, bottom) or (Trace(), q)
        other, _ = path_to(here, bottom & (component != component[last])) or (Trace(), q)
        why = f"the commands {other} instead of {one} lead to where nothing makes them meet again"
        return Check(title, False, trace + one, why)

    def nonblocking(self) -> Check:
        """Answer :func:`is_nonblocking_under_control`."""
        title, a = "nonblocking under control", self.loop
        decides = np.zeros(a.n_states, np.bool_)
        decides[self.source[self.command]] = True
        obedient = replace(kept(a, self.command | ~decides[self.source]), marked=a.marked & ~decides)
        path = path_to(a, distance_to_marked(obedient) < 0)
        if path is None:
            return Check(title, True)
        why = "no marked state is reached by who waits only where no command is enabled"
        return Check(title, False, path[0], why)

    # -- two events of one state -------------------------------------------------------------------------------

    def choice_free(self) -> Check:
        """Answer :func:`is_choice_free`."""

        def wrong(i: int, j: int) -> _Wrong:
            a, b, ab, ba = self._orders(i, j)
            if ab < 0 or ba < 0:
                a, b = (a, b) if ab < 0 else (b, a)
                return _Wrong((a,), f"command {b!r} was enabled as well, and is not any more")
            return _Wrong((a, b), f"{b}, {a} instead leads elsewhere")

        return self._check("no choice", wrong, (True, True), lambda ab, ba: (ab != ba) | (ab < 0))

    def avalanche_free(self) -> Check:
        """Answer :func:`is_avalanche_free`."""

        title, a = "no avalanche", self.loop
        single = np.flatnonzero(~self.command)
        again = self._step(a.targets[single], a.events[single])
        moves = single[(again >= 0) & (again != a.targets[single])]
        states = np.zeros(a.n_states, np.bool_)
        states[self.source[moves]] = True
        path = path_to(a, states)
        if path is None:
            return Check(title, True)
        trace, q = path
        u = self._name(int(moves[np.argmax(self.source[moves] == q)]))
        return Check(title, False, Trace([*trace, u, u]), f"one {u!r} can be taken for two")

    def interleave_insensitive(self) -> Check:
        """Answer :func:`is_interleave_insensitive`."""

        def wrong(i: int, j: int) -> _Wrong:
            u, v, uv, vu = self._orders(i, j)
            if uv < 0 or vu < 0:
                u, v = (u, v) if vu < 0 else (v, u)
                return _Wrong((u, v), f"a scan reads both at once, and {u!r} cannot be followed after {v!r}")
            return _Wrong((u, v), f"{v}, {u} instead leads elsewhere, and a scan reads both at once")

        return self._check("no simultaneity", wrong, (False, False), lambda uv, vu: uv != vu)

    def delay_insensitive(self) -> Check:
        """Answer :func:`is_delay_insensitive`."""

        def wrong(i: int, j: int) -> _Wrong:
            c, u, _, uc = self._orders(i, j)
            if uc < 0:
                return _Wrong((u,), f"command {c!r}, decided on before {u!r}, is not enabled any more")
            return _Wrong((u, c), f"the program, which sees {c!r} before {u!r}, takes it for another state")

        title = "no inexact synchronisation"
        return self._check(title, wrong, (True, False), lambda cu, uc: (uc < 0) | ((cu >= 0) & (cu != uc)))

    def _check(
        self,
        title: str,
        wrong: Callable[[int, int], _Wrong],
        commands: tuple[bool, bool],
        bad: Callable[[Ints, Ints], Mask],
    ) -> Check:
        """Return whether no pair is ``bad``, as said by the states after both of its events in either order.

        Looked at are the pairs of transitions that leave the same state; ``commands`` says which of the two is one.
        """

        def failing(one: Ints, other: Ints) -> tuple[Ints, Ints]:
            straight, turned = (
                (self.command[a] == commands[0]) & (self.command[b] == commands[1])
                for a, b in ((one, other), (other, one))
            )
            turned &= ~straight
            i, j = (np.concatenate((a[straight], b[turned])) for a, b in ((one, other), (other, one)))
            worse = bad(*self._after_both(i, j))
            return i[worse], j[worse]

        m, offsets, states = len(self.source), self.loop.offsets, np.zeros(self.loop.n_states, np.bool_)
        for apart in range(1, int(np.diff(offsets).max(initial=0))):  # all pairs at once may be too many
            one = np.flatnonzero(self.source[: m - apart] == self.source[apart:])
            states[self.source[failing(one, one + apart)[0]]] = True
        path = path_to(self.loop, states)
        if path is None:
            return Check(title, True)
        trace, q = path
        row = np.arange(offsets[q], offsets[q + 1])
        pairs = (failing(row[:-apart], row[apart:]) for apart in range(1, len(row)))
        found = wrong(*min(pair for i, j in pairs for pair in zip(i.tolist(), j.tolist(), strict=True)))
        return Check(title, False, trace + found.then, found.reason)

    def _after_both(self, i: Ints, j: Ints) -> tuple[Ints, Ints]:
        """Return where the events of pairs of transitions lead, i first and j first."""
        events, targets = self.loop.events, self.loop.targets
        return self._step(targets[i], events[j]), self._step(targets[j], events[i])

    def _orders(self, i: int, j: int) -> tuple[str, str, int, int]:
        """Return the names of two events, and where they lead one after the other, and in the other order."""
        after, instead = self._after_both(np.array([i]), np.array([j]))
        return self._name(i), self._name(j), int(after[0]), int(instead[0])

    def _name(self, transition: int) -> str:
        return self.loop.alphabet[int(self.loop.events[transition])].name

    def _step(self, states: NDArray[np.int32], events: NDArray[np.int32]) -> Ints:
        """Return the state that each event leads to from its state, -1 where there is none."""
        keys = states.astype(np.int64) * len(self.loop.alphabet) + events
        place = np.minimum(np.searchsorted(self.keys, keys), len(self.keys) - 1)
        return np.where(self.keys[place] == keys, self.loop.targets[place], -1) if len(keys) else keys
