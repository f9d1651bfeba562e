"""Modular synthesis: small supervisors that are together the largest one, and the proof that they are.

The problem falls apart into groups that share no event.  In a group each specification gets a supervisor of its own,
which looks at as few plants as it needs; then it is found out whether they are in conflict.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import prod

from thenar.errors import InputError, LimitReached, about, counted, did_you_mean
from thenar.explicit.abstraction import MOST, is_nonconflicting_by_abstraction
from thenar.explicit.exploration import Exploration, common_alphabet, ticker
from thenar.explicit.reach import is_nonconflicting
from thenar.model.automaton import Automaton
from thenar.model.display import Displayable
from thenar.model.events import Alphabet
from thenar.model.limits import Limits, Progress
from thenar.model.problem import Problem
from thenar.model.supervisor import ControlPattern
from thenar.model.trace import Trace
from thenar.synthesis.api import ENGINES, SURELY_SMALL, Size, SynthesisResult, synthesize

__all__ = ["Group", "Local", "ModularResult", "synthesize_modular"]

LOCALLY = 20_000  # states that a local supervisor's product may have before its specification is left to the whole


@dataclass(frozen=True, eq=False, slots=True)
class Local:
    """What ``specs``, mostly one, need: a supervisor, ``result``, that looks at ``plants``; None if they need none.

    They need none if with ``plants`` they do not block, and never have to forbid what cannot be disabled.  With
    ``is_open`` that was too large to be found out.
    """

    specs: tuple[Automaton, ...]
    plants: tuple[Automaton, ...] = ()
    result: SynthesisResult | None = None
    is_open: bool = False

    @property
    def parts(self) -> tuple[Automaton, ...]:
        """What takes part in the closed loop: the supervisor, or the specifications as they are."""
        if self.result is None:
            return self.specs
        return (replace(self.result.supervisor.automaton, name=f"S({', '.join(s.name for s in self.specs)})"),)

    @property
    def is_empty(self) -> bool:
        """True if these specifications alone leave nothing."""
        return self.result is not None and not self.result


@dataclass(frozen=True, eq=False)
class Group:
    """Plants and specifications that share events with each other and with no others.

    * ``alphabet``: their events, in the order of the problem
    * ``locals``: what the specifications need
    * ``route``: ``"local"`` if the local supervisors are enough; ``"coordinated"`` if they are in conflict, or leave a
      specification open; ``"none"`` if there is no supervisor
    * ``parts``: automata whose product is what the local supervisors leave
    * ``whole``: the largest controllable and nonblocking part of that, where it had to be found
    """

    plants: tuple[Automaton, ...]
    specs: tuple[Automaton, ...]
    alphabet: Alphabet
    locals: tuple[Local, ...]
    route: str
    parts: tuple[Automaton, ...] = ()
    whole: SynthesisResult | None = None

    @property
    def supervisors(self) -> Iterator[SynthesisResult]:
        """The local supervisors, then the coordinator."""
        yield from (x.result for x in self.locals if x.result is not None)
        if self.route == "coordinated" and self.whole is not None:
            yield self.whole

    @cached_property
    def closed_loop(self) -> SynthesisResult:
        """The supervised plants of this group, if a supervisor exists; found with diagrams if nobody has yet."""
        return self.whole or synthesize(Problem(self.parts, alphabet=self.alphabet), "symbolic")

    def after(self, trace: Trace) -> tuple[set[str], set[str]] | None:
        """Return the events that are enabled and those that are disabled after ``trace``; None if it cannot happen."""
        if self.route == "coordinated":
            pattern = (self.closed_loop.symbolic or self.closed_loop.supervisor).after(trace)
            enabled = None if pattern is None else {e.name for e in pattern.enabled}
        else:
            enabled = _possible(self.parts, self.alphabet, trace)
        possible = _possible(self.plants, self.alphabet, trace)
        return None if enabled is None or possible is None else (enabled, possible - enabled)


@dataclass(frozen=True, eq=False, repr=False)
class ModularResult(Displayable):
    """What :func:`synthesize_modular` found: true exactly if a supervisor exists.

    * ``groups``: solved in order, up to the first that has no supervisor
    * ``timings``: wall seconds of finding the local supervisors, and of finding out whether they conflict

    >>> from thenar.library.classics import transfer_line
    >>> result = synthesize_modular(transfer_line(3))
    >>> result
    ModularResult 'transfer_line(3)': 21,952 states; 3 groups, 3 local supervisors, no conflict
    >>> [spec.name for spec in result.groups[0].locals[0].specs]
    ['L1_B1', 'L1_B2']
    """

    problem: Problem
    groups: tuple[Group, ...]
    timings: Mapping[str, float]

    def __bool__(self) -> bool:
        return self.groups[-1].route != "none"

    @property
    def seconds(self) -> float:
        """Wall seconds of the whole synthesis."""
        return sum(self.timings.values())

    @property
    def supervisors(self) -> tuple[SynthesisResult, ...]:
        """The local supervisors and the coordinators; with the specifications that need none, they are the largest one.

        Empty if no supervisor exists.
        """
        return tuple(s for g in self.groups for s in g.supervisors) if self else ()

    @property
    def how(self) -> str:
        """In which way it was found, in words."""
        coordinators = sum(g.route == "coordinated" for g in self.groups)
        needed = sum(x.result is not None for g in self.groups for x in g.locals)
        last = counted(coordinators, "coordinator") if coordinators else "no conflict"
        last = last if self else "the last group has no supervisor"
        return f"{counted(len(self.groups), 'group')}, {counted(needed, 'local supervisor')}, {last}"

    @cached_property
    def n_states(self) -> int:
        """States of the supervised plant, exactly; counted with diagrams where nobody has yet."""
        found = [g.closed_loop for g in self.groups] if self else []
        return prod(r.symbolic.n_states if r.symbolic else r.size.states for r in found) if self else 0

    @cached_property
    def size(self) -> Size:
        """States and transitions of the supervised plant, exactly; transitions take longer to count than states."""
        sizes = [g.closed_loop.size for g in self.groups] if self else []
        # a transition moves one group and leaves the others where they are
        return Size(self.n_states, sum(s.transitions * (self.n_states // s.states) for s in sizes))

    def after(self, trace: Iterable[str] | str) -> ControlPattern | None:
        """Return the control pattern after ``trace``, or None if the supervised plant cannot do the trace.

        An event is enabled if the plants can do it and every supervisor that knows it enables it.  The automata are
        followed side by side, O(|trace|) steps each.  Raises UnknownName for an unknown event.

        >>> from thenar.library.classics import small_factory
        >>> print(synthesize_modular(small_factory()).after("start_1, finish_1"))
        enabled: start_2; disabled: start_1
        """
        names, alphabet = Trace(trace), self.problem.alphabet
        known = {e for g in self.groups for e in g.alphabet.names}
        enabled: set[str] = set()
        disabled: set[str] = set()
        if not {alphabet[e].name for e in names} <= known or not self:
            return None
        for group in self.groups:
            found = group.after(Trace(e for e in names if e in group.alphabet))
            if found is None:
                return None
            enabled |= found[0]
            disabled |= found[1]
        return ControlPattern(*(tuple(e for e in alphabet if e.name in chosen) for chosen in (enabled, disabled)))

    def __repr__(self) -> str:
        title = f"ModularResult {self.problem.name!r}" if self.problem.name else "ModularResult"
        return f"{title}: {about(self.n_states)} states; {self.how}" if self else f"{title}: no supervisor exists"


def synthesize_modular(
    problem: Problem, *, engine: str = "auto", limits: Limits | None = None, progress: Progress | None = None
) -> ModularResult:
    """Return supervisors, most of them small, that are together the largest controllable, nonblocking one.

    1. Automata that share no event, not even by way of others, are independent: each *group* is solved on its own.
    2. A specification E gets a supervisor for itself and those plants P that it needs.  From P || E the states are
       removed that have no way to a marked one, or an uncontrollable event of P alone that E forbids or that
       leads to a removed state (*halfway synthesis*).  Nothing that any supervisor of the whole could leave is lost.
       If no uncontrollable event needs to be disabled for this, it can be enforced, too.  If one
       does, a plant that shares it is added to P, for that may know that the event cannot happen here.
    3. If the plants under these supervisors are nonblocking, they are together the largest supervisor.  If
       not, pairs that block by themselves are merged, as if they were one specification; and if that is not enough, the
       group gets a coordinator: the largest nonblocking, controllable part of what they leave.

    Verdict and closed loop are, state by state, those of :func:`synthesize`; docs/modular.md has the proof.

    ``engine`` is for the third step: ``"symbolic"`` takes decision diagrams, ``"explicit"`` lists the states, or, if
    there may be many, first hides and merges (:func:`is_nonconflicting_by_abstraction`), ``"auto"`` takes what
    suits the number of states.  Raises InputError for an unknown engine, or a problem with variables or conditions;
    LimitReached at one of ``limits``, which hold for each step on its own.
    [Wonham and Ramadge 1988; de Queiroz and Cury 2000; Flordal, Malik, Fabian and Åkesson 2007]

    >>> from thenar.library import glr
    >>> synthesize_modular(glr.problem(fingers=10))
    ModularResult 'glr(fingers=10)': 1.79e19 states; 1 group, 10 local supervisors, no conflict
    """
    if engine not in ("auto", *ENGINES):
        valid = ", ".join(("auto", *ENGINES))
        raise InputError(f"unknown engine {engine!r}{did_you_mean(engine, ENGINES)}; there are: {valid}")
    if not isinstance(problem, Problem):
        raise InputError("modular synthesis takes automata only; ask synthesize for one with variables or conditions")
    groups = []
    timings = {"local": 0.0, "join": 0.0}
    for plants, specs in _independent(problem):
        groups.append(_Solver(plants, specs, problem.alphabet, engine, limits, progress).solve(timings))
        if groups[-1].route == "none":
            break
    return ModularResult(problem, tuple(groups), timings)


def _independent(problem: Problem) -> list[tuple[list[Automaton], list[Automaton]]]:
    """Return the plants and specifications of each group, in the problem's order."""
    leader = list(range(len(problem.automata)))

    def find(k: int) -> int:
        while leader[k] != k:
            leader[k] = k = leader[leader[k]]
        return k

    first: dict[str, int] = {}
    for k, a in enumerate(problem.automata):
        for e in a.alphabet.names:
            low, high = sorted((find(first.setdefault(e, k)), find(k)))
            leader[high] = low
    groups: dict[int, tuple[list[Automaton], list[Automaton]]] = {}
    for k, a in enumerate(problem.automata):
        groups.setdefault(find(k), ([], []))[k >= len(problem.plants)].append(a)
    return list(groups.values())


class _Solver:
    """One group."""

    def __init__(
        self,
        plants: list[Automaton],
        specs: list[Automaton],
        order: Alphabet,
        engine: str,
        limits: Limits | None,
        progress: Progress | None,
    ) -> None:
        self.plants, self.specs, self.engine = plants, specs, engine
        self.limits, self.progress = limits or Limits(), progress
        self.most = sys.maxsize if self.limits.states is None else self.limits.states
        names = {e for a in (*plants, *specs) for e in a.alphabet.names}
        self.alphabet = Alphabet(e for e in order if e.name in names)
        self.owners: dict[str, list[int]] = {e: [] for e in names}  # the plants that take part in an event
        for k, plant in enumerate(plants):
            for e in plant.alphabet.names:
                self.owners[e].append(k)

    def solve(self, timings: dict[str, float]) -> Group:
        start = time.perf_counter()
        clusters: list[Local] = []
        if any(a.is_empty for a in (*self.plants, *self.specs)):
            return self._group(clusters, "none")
        for spec in self.specs:
            clusters.append(self._supervise((spec,)))
            if clusters[-1].is_empty:
                return self._group(clusters, "none")
        local = time.perf_counter()
        timings["local"] += local - start
        group = self._join(clusters)
        if group.route == "coordinated":
            merged = self._merge(clusters)
            if len(merged) < len(clusters):
                group = self._join(merged)
        timings["join"] += time.perf_counter() - local
        return group

    def _supervise(self, specs: tuple[Automaton, ...]) -> Local:
        """Find the plants that ``specs`` need to be enforced, and the supervisor that does it."""
        chosen: list[int] = []
        most = min(LOCALLY, self.most)
        while True:
            local = tuple(self.plants[k] for k in sorted(chosen))
            known = common_alphabet([*local, *specs])
            alphabet = Alphabet(e for e in self.alphabet if e.name in known)
            ours = [not e.controllable and all(k in chosen for k in self.owners[e.name]) for e in alphabet]
            tick = ticker(replace(self.limits, states=most), self.progress)
            try:
                halfway = Exploration(local or (_idle(),), specs, alphabet, tick, uncontrollable=ours)
            except LimitReached as reached:
                if reached.limit != "states":
                    raise
                return Local(specs, local, is_open=True)
            halfway.native.fixpoint(tick)
            left = halfway.extract("", tick)
            asked = [e.name for k, e in enumerate(alphabet) if not e.controllable and k in left.disabled]
            if not asked:
                break
            # of the plants that might forbid it, the one that has most to do with what is looked at
            having = [k for k in self.owners[asked[0]] if k not in chosen]
            chosen.append(max(having, key=lambda k: (sum(e in known for e in self.plants[k].alphabet.names), -k)))
        if left.automaton.n_states == halfway.n_states:
            return Local(specs, local)
        problem = Problem(local or (_idle(),), specs, name=", ".join(s.name for s in specs), alphabet=alphabet)
        return Local(specs, local, synthesize(problem, "explicit", limits=self.limits))

    def _merge(self, clusters: Sequence[Local]) -> list[Local]:
        """Merge clusters that block by themselves, two at a time, as long as there are any."""
        done: list[tuple[Local, set[str]]] = []
        todo = list(clusters)
        for cluster in todo:  # grows while it is read
            events = {e for part in cluster.parts for e in part.alphabet.names}
            for k, (other, theirs) in enumerate(done):
                if not events.isdisjoint(theirs) and _are_at_odds(cluster, other):
                    merged = self._supervise(other.specs + cluster.specs)
                    if not merged.is_open:
                        del done[k]
                        todo.append(merged)
                        break
            else:
                done.append((cluster, events))
        return [cluster for cluster, _ in done]

    def _join(self, clusters: Sequence[Local]) -> Group:
        """Find out whether what ``clusters`` leave is nonblocking, and coordinate it if not."""
        if any(c.is_empty for c in clusters):
            return self._group(clusters, "none")
        followed = {id(p) for c in clusters if c.result is not None for p in c.plants}
        parts = [part for c in clusters if not c.is_open for part in c.parts]
        large = [spec for c in clusters if c.is_open for spec in c.specs]
        rest = [p for p in self.plants if id(p) not in followed]
        plants, specs = (self.plants, parts + large) if large else (rest + parts, [])
        automata, n = _with_own_names([*plants, *specs]), len(plants)
        if self.engine == "explicit" and not large and prod(a.n_states for a in automata) > SURELY_SMALL:
            try:
                if is_nonconflicting_by_abstraction(*automata, most=min(MOST, self.most)):
                    return self._group(clusters, "local", automata)
            except LimitReached:
                pass  # the whole product may be smaller than that of two factors
        problem = Problem(automata[:n] or [_idle()], automata[n:], alphabet=self.alphabet)
        whole = synthesize(problem, self.engine, limits=self.limits, progress=self.progress)
        route = "none" if not whole else "coordinated" if large or _removed(whole) else "local"
        return self._group(clusters, route, automata, whole)

    def _group(
        self,
        locals_: Sequence[Local],
        route: str,
        parts: tuple[Automaton, ...] = (),
        whole: SynthesisResult | None = None,
    ) -> Group:
        return Group(tuple(self.plants), tuple(self.specs), self.alphabet, tuple(locals_), route, parts, whole)


def _idle() -> Automaton:
    """Return a plant that has no say in anything."""
    return Automaton.from_transitions([], initial="0", marked=["0"])


def _are_at_odds(a: Local, b: Local) -> bool:
    """Return whether the two block by themselves; False if that would take long to find out."""
    parts = a.parts + b.parts
    small = not a.is_open and not b.is_open and prod(p.n_states for p in parts) <= LOCALLY
    return small and not is_nonconflicting(*parts)


def _removed(result: SynthesisResult) -> bool:
    """Return whether a state that the parts can reach is not in the supervisor."""
    if result.symbolic is not None:
        return bool(result.symbolic.reachable - result.symbolic.controlled)
    return result.explored.states > result.size.states


def _with_own_names(automata: Sequence[Automaton]) -> tuple[Automaton, ...]:
    """Return ``automata`` without the names that several of them have: problems do not take these."""
    counts = Counter(a.name for a in automata)
    return tuple(a if counts[a.name] == 1 else replace(a, name="") for a in automata)


def _possible(automata: Sequence[Automaton], alphabet: Alphabet, trace: Trace) -> set[str] | None:
    """Return what all that know it can do after ``trace``; None if one of them cannot do the trace."""
    names = set(alphabet.names)
    for a in automata:
        own = Trace(e for e in trace if e in a.alphabet)
        states = a.run(own)
        if len(states) <= len(own):
            return None
        names -= set(a.alphabet.names) - {e.name for e in a.enabled(states[-1])}
    return names
