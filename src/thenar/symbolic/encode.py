"""From a problem to levels, sets and relations."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import InputError
from thenar.model.automaton import Automaton
from thenar.model.expressions import TRUE, Expression
from thenar.model.extended import Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.limits import Limits
from thenar.model.problem import Problem
from thenar.symbolic.levels import Levels, automaton_part, variable_part

__all__ = ["Encoding", "EventRelation"]

MAX_CHOICES = 1 << 14  # combinations of guarded edges that one event may have


@dataclass(slots=True)
class _Moves:
    """How one automaton takes part in one event: plain (source, target) pairs, or edges with guards and updates."""

    part: int
    sources: NDArray[np.uint32]
    targets: NDArray[np.uint32]
    guarded: tuple[Edge, ...] = ()


@dataclass(slots=True)
class EventRelation:
    """What an event does, and where.

    * ``possible``: the plants can do it
    * ``offered``: the specifications that are automata let them
    * ``allowed``: all specifications let them
    * ``choice``: it may lead from one state to several
    """

    name: str
    controllable: bool
    relation: int
    possible: kernel.Set
    offered: kernel.Set
    allowed: kernel.Set
    choice: bool


class Encoding(Levels):
    """A problem as a forest of decision diagrams.

    ``parts`` are the plants, the specifications and the variables in the problem's order; ``order`` (n_parts,)
    lists them from the top level down.
    """

    def __init__(
        self,
        problem: Problem | ExtendedProblem,
        tick: kernel.Ticker,
        *,
        order: str | Sequence[str] = "auto",
        limits: Limits | None = None,
    ) -> None:
        self.problem = problem
        self.alphabet = problem.alphabet
        automata: list[Automaton | ExtendedAutomaton] = [*problem.plants, *problem.specs]
        self.n_plants = len(problem.plants)
        parts = [automaton_part(a) for a in automata]
        if isinstance(problem, ExtendedProblem):
            parts += [variable_part(v) for v in problem.variables]
        super().__init__(parts, tick)
        moves = self._moves(automata)
        conditions = (
            (*problem.plant_conditions, *problem.spec_conditions) if isinstance(problem, ExtendedProblem) else ()
        )
        edges = [self._event_support(m) for m in moves]
        for condition in conditions:
            used = self.support(condition.predicate)
            if condition.event is not None:
                used = used | set(edges[self.alphabet.index(condition.event)])
            edges.append(sorted(used))
        if isinstance(problem, ExtendedProblem):
            edges += [sorted(self.support(p)) for p in (problem.initial, problem.marked)]
        self.arrange(edges, order, limits)
        self._fill(problem, moves)

    # -- events --------------------------------------------------------------------------------------------

    def _moves(self, automata: Sequence[Automaton | ExtendedAutomaton]) -> list[list[_Moves]]:
        moves: list[list[_Moves]] = [[] for _ in self.alphabet]
        for k, a in enumerate(automata):
            where = [self.alphabet.index(name) for name in a.alphabet.names]
            if isinstance(a, ExtendedAutomaton):
                by_event: list[list[Edge]] = [[] for _ in a.alphabet]
                for edge in a.edges:
                    by_event[edge.event].append(edge)
                for e, own in enumerate(by_event):
                    plain = all(x.guard == TRUE and not x.updates for x in own)
                    sources, targets = (np.array([getattr(x, w) for x in own], np.uint32) for w in ("source", "target"))
                    moves[where[e]].append(_Moves(k, sources, targets, () if plain else tuple(own)))
            else:
                sources = np.repeat(np.arange(a.n_states, dtype=np.uint32), np.diff(a.offsets))
                by = np.argsort(a.events, kind="stable")
                bounds = np.searchsorted(a.events[by], np.arange(len(a.alphabet) + 1))
                targets = a.targets.astype(np.uint32)
                for e in range(len(a.alphabet)):
                    rows = by[bounds[e] : bounds[e + 1]]
                    moves[where[e]].append(_Moves(k, sources[rows], targets[rows]))
        return moves

    def _event_support(self, moves: Sequence[_Moves]) -> list[int]:
        used = {m.part for m in moves}
        for m in moves:
            for edge in m.guarded:
                used |= self.support(edge.guard)
                for variable, value in edge.updates:
                    used |= self.support(value) | {self.number[variable]}
        return sorted(used)

    def _fill(self, problem: Problem | ExtendedProblem, moves: list[list[_Moves]]) -> None:
        f = self.forest
        initial = [self.literal(k, p.initial) for k, p in enumerate(self.parts)]
        marked = [self.literal(k, p.marked) for k, p in enumerate(self.parts)]
        plant_needs: dict[str, list[kernel.Set]] = {}
        spec_needs: dict[str, list[kernel.Set]] = {}
        plant_invariants: list[kernel.Set] = []
        spec_invariants: list[kernel.Set] = []
        if isinstance(problem, ExtendedProblem):
            initial.append(self.predicate(problem.initial))
            marked.append(self.predicate(problem.marked))
            for needs, invariants, conditions in (
                (plant_needs, plant_invariants, problem.plant_conditions),
                (spec_needs, spec_invariants, problem.spec_conditions),
            ):
                for c in conditions:
                    where = invariants if c.event is None else needs.setdefault(c.event, [])
                    where.append(self.predicate(c.predicate))
        self.invariant = f.all_of(plant_invariants, self.tick)
        self.requirements = spec_invariants  # together they may be large where states are reached that are few
        self.initial = f.all_of(initial, self.tick) & self.invariant
        self.marked = f.all_of(marked, self.tick)
        self.events: list[EventRelation] = []
        for event, own in zip(self.alphabet, moves, strict=True):
            if own:  # an event that no automaton has never happens, whatever conditions say of it
                self.events.append(
                    self._event(
                        event.name,
                        event.controllable,
                        own,
                        plant_needs.get(event.name, ()),
                        spec_needs.get(event.name, ()),
                    )
                )

    def _event(
        self,
        name: str,
        controllable: bool,
        moves: Sequence[_Moves],
        plant_needs: Sequence[kernel.Set],
        spec_needs: Sequence[kernel.Set],
    ) -> EventRelation:
        plants = [m for m in moves if m.part < self.n_plants]
        if not any(m.guarded for m in moves) and not plant_needs and not spec_needs and self.invariant.is_everything:
            # a product of local steps: no relation is needed to know where it can happen
            relation = self._product(moves)
            possible = self._sources(plants)
            allowed = (
                possible
                if len(plants) == len(moves)
                else possible & self._sources([m for m in moves if m.part >= self.n_plants])
            )
            return EventRelation(name, controllable, relation, possible, allowed, allowed, _chooses(moves))
        relation = self._guarded(moves)
        of_plants = relation if len(plants) == len(moves) else self._guarded(plants)
        for needed in plant_needs:
            relation, of_plants = self.forest.restrict(relation, needed), self.forest.restrict(of_plants, needed)
        offered = relation
        for needed in spec_needs:
            relation = self.forest.restrict(relation, needed)
        possible, offers, allowed = (self._happens(r) for r in (of_plants, offered, relation))
        return EventRelation(name, controllable, relation, possible, offers, allowed, _chooses(moves))

    def _happens(self, relation: int) -> kernel.Set:
        """Return where ``relation`` leads somewhere; a step that would break an invariant of the plant does not."""
        if self.invariant.is_everything:
            return self.forest.domain(relation)
        return self.forest.image(self.invariant, self.forest.inverse(relation))

    def happens(self, edge: Edge) -> kernel.Set:
        """Return where the guard of ``edge`` holds and its updates stay within the ranges."""
        where = self.predicate(edge.guard)
        for _, relation in self._updates(dict(edge.updates), set()) if edge.updates else ():
            where &= self.forest.domain(relation)
        return where

    def _sources(self, moves: Sequence[_Moves]) -> kernel.Set:
        sets = []
        for m in moves:
            mask = np.zeros(self.parts[m.part].size, np.bool_)
            mask[m.sources] = True
            sets.append(self.literal(m.part, mask))
        return self.forest.all_of(sets, self.tick) if len(sets) > 1 else sets[0] if sets else self.forest.everything

    def _product(self, moves: Sequence[_Moves]) -> int:
        relation = 1
        for m in sorted(moves, key=lambda m: self.level[m.part]):
            relation = self.forest.shift(int(self.level[m.part]), m.sources, m.targets, relation)
        return relation

    def _guarded(self, moves: Sequence[_Moves]) -> int:
        """Return the relation of ``moves`` together: each choice of guarded edges, and the plain moves beside it."""
        plain = self._product([m for m in moves if not m.guarded])
        choices = [m.guarded for m in moves if m.guarded]
        if prod(map(len, choices)) > MAX_CHOICES:
            names = ", ".join(self.parts[m.part].name for m in moves if m.guarded)
            raise InputError(
                f"{prod(map(len, choices)):,} combinations of guarded edges of {names}; {MAX_CHOICES:,} are the most"
            )
        if not choices:
            return plain
        parts = [m.part for m in moves if m.guarded]
        moved = {m.part for m in moves}
        relations = []
        for chosen in itertools.product(*choices):
            local = [
                _Moves(p, np.array([x.source], np.uint32), np.array([x.target], np.uint32))
                for p, x in zip(parts, chosen, strict=True)
            ]
            steps = self.forest.join(self._product(local), plain)
            for where, update in self._updates(dict(u for x in chosen for u in x.updates), moved):
                # restricted last: guards speak of the states before, and leave alone what does not move
                one = self.forest.restrict(self.forest.join(steps, update), where)
                for x in chosen:
                    one = self.forest.restrict(one, self.predicate(x.guard))
                relations.append(one)
        return self._any(relations)

    def _any(self, relations: Sequence[int]) -> int:
        """Return what any of ``relations`` does, each put together with few others: all that is made is kept."""
        if len(relations) < 2:
            return relations[0] if relations else 0
        half = len(relations) // 2
        return self.forest.either(self._any(relations[:half]), self._any(relations[half:]))

    def _updates(self, updates: Mapping[str, Expression], moved: set[int]) -> list[tuple[kernel.Set, int]]:
        """Return relations that give each variable its new value, each with the states that it is for.

        What an update reads of a ``moved`` part, an automaton that moves at the same time, cannot be in the relation
        itself, which would say that the automaton stays.
        """
        reads = {p for x in updates.values() for p in self.support(x)}
        fixed = self.falling(reads & moved)
        result = []
        for values in itertools.product(*(range(self.parts[p].size) for p in fixed)):
            given = dict(zip(fixed, values, strict=True))
            masks = [np.arange(self.parts[p].size) == v for p, v in given.items()]
            where = self.forest.all_of([self.literal(p, m) for p, m in zip(given, masks, strict=True)], self.tick)
            relation = 1
            for group in _tied({v: (self.support(x) - moved) | {self.number[v]} for v, x in updates.items()}):
                relation = self.forest.join(relation, self._assign({v: updates[v] for v in group}, given))
            result.append((where, relation))
        return result

    def _assign(self, updates: Mapping[str, Expression], given: Mapping[int, int]) -> int:
        """Return the relation of simultaneous ``updates`` where the parts in ``given`` have the values there."""
        free = {p for v, x in updates.items() for p in (*self.support(x), self.number[v])} - set(given)
        parts = self.falling(free)
        sizes = [self.parts[p].size for p in parts]
        axes = [*given, *parts]
        chosen = tuple(given.values())
        new = {
            self.number[v]: np.broadcast_to(self.table_of(x, axes), [self.parts[p].size for p in axes])[chosen]
            for v, x in updates.items()
        }
        before = np.indices(sizes).reshape(len(parts), -1)
        columns = []
        possible = np.ones(prod(sizes), np.bool_)
        for k, p in enumerate(parts):
            after = before[k]
            if p in new:
                place = self.place(p)
                after = np.array([place.get(v, -1) for v in new[p].ravel().tolist()])
                possible &= after >= 0
            columns += [before[k], after]
        rows = np.stack(columns, axis=1)[possible]
        return self.forest.rows([int(self.level[p]) for p in parts], rows.astype(np.uint32).ravel())


def _chooses(moves: Sequence[_Moves]) -> bool:
    """Return whether some state may have two successors."""
    return any(len(np.unique(m.sources)) < len(m.sources) for m in moves)


def _tied(supports: Mapping[str, set[int]]) -> list[list[str]]:
    """Group the variables whose updates share a part."""
    groups: list[tuple[set[int], list[str]]] = []
    for variable, support in supports.items():
        touched = [g for g in groups if g[0] & support]
        groups = [g for g in groups if not g[0] & support]
        groups.append((support.union(*(g[0] for g in touched)), [*(v for g in touched for v in g[1]), variable]))
    return [names for _, names in groups]
