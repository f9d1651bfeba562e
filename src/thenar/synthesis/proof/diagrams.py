"""The checker of certificates that hold sets of states: a proof check in plain Python, on its own decision diagrams.

A certificate holds the automata of a problem, an order of them, and sets of states of their product as diagrams: K,
the states that the supervisor lets the plants reach, and for each round k = 1, 2, ... of removals its seeds S(k) and
all that it removed, R(k), with a reason.  What the automata can do is taken from the statement alone.  Checked is

* *legal*:        in no state of K can the plants do an uncontrollable event that a specification forbids,
* *controllable*: every uncontrollable event that is possible in K leads into K,
* *nonblocking*:  from each state of K a marked one can be reached within K,
* *largest*:      every other transition from K leads to K or to some R(k), and R(k) had to be removed:
  its seeds are states where the plants can do an uncontrollable event that a specification forbids; or none of them
  is marked, and all transitions from them lead to S(k), R(1), ..., R(k-1); and from every state of R(k) uncontrollable
  events lead, within R(k), to a seed,
* *faithful*:     the initial state is in K, and every state of K can be reached from it within K; or K is empty, and
  the initial state is in some R(k).

The states that a controllable and nonblocking restriction reaches are a set X that is legal, controllable and
nonblocking in this sense.  No state of R(k) is in X, by induction over k.  A seed that is illegal is not.  Nor is
one that blocks: from there X would have a way to a marked state, within X, so outside R(1), ..., R(k-1); but such a
way stays in S(k), where nothing is marked.  And from any other state of R(k) uncontrollable events, which X cannot
avoid, lead to a seed.  So every way from the initial state within X stays within K, for where it left K first it
would enter some R(k).  K itself is such a set X, so it is the largest: its behaviour is the supremal one.  If the
initial state is in R(k), it is in no X, and no supervisor exists.   [Ramadge and Wonham 1987]

R(k) may be larger or smaller than in the synthesis, and have states that cannot be reached; there is only one K.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from thenar.synthesis.proof.container import Arrays, Statement, Wrong, claim, ints
from thenar.synthesis.proof.mdd import EVERYTHING, NOTHING, Diagrams, Node, Relation, deep
from thenar.synthesis.proof.saturation import Closure

__all__ = ["SetsOfStates"]

ILLEGAL, BLOCKING = 1, 3  # as where states are listed
SHOWN = 8  # automata in the name of a state


@dataclass(frozen=True, slots=True)
class Step:
    """What an event does: ``relation``; the plants can do it in ``can``, the specifications let them in ``may``."""

    event: str
    free: bool
    relation: Relation
    back: Relation
    can: Node
    may: Node


class SetsOfStates:
    """What a certificate claims of a problem, as sets of states."""

    def __init__(self, problem: Statement, arrays: Arrays) -> None:
        self.problem = problem
        n = len(problem.automata)
        self.order = ints(arrays, "order").tolist()  # from the top level down
        claim(sorted(self.order) == list(range(n)), "malformed: order")
        self.level = {k: n - place for place, k in enumerate(self.order)}  # of each automaton
        self.diagrams = Diagrams([len(problem.automata[k].marked) for k in reversed(self.order)])
        roots, reasons = ints(arrays, "roots").tolist(), ints(arrays, "reasons").tolist()
        claim(len(roots) == 1 + 2 * len(reasons), "malformed: roots")
        claim(all(r in (ILLEGAL, BLOCKING) for r in reasons), "malformed: unknown reason")
        nodes = self._load(ints(arrays, "node_levels").tolist(), ints(arrays, "node_children").tolist())
        claim(all(0 <= r < len(nodes) for r in roots), "malformed: roots")
        self.K, *rest = (nodes[r] for r in roots)
        self.rounds = list(zip(reasons, rest[::2], rest[1::2], strict=True))
        with deep(n):
            self.n_nodes = self.diagrams.n_nodes({self.K, *rest})
            self.steps = self._steps()
        automata = problem.automata
        self.initial = self.diagrams.cube({self.level[k]: [a.initial] for k, a in enumerate(automata)})
        self.marked = self.diagrams.cube(
            {self.level[k]: np.flatnonzero(a.marked).tolist() for k, a in enumerate(automata)}
        )
        self.removed = NOTHING
        self.sizes = 0, 0, 0

    def _load(self, levels: list[int], children: list[int]) -> list[Node]:
        """Return the nodes that the certificate lists, from the bottom up, made again here; the first two are given."""
        nodes, at = [NOTHING, EVERYTHING], 0
        d = self.diagrams
        for level in levels:
            claim(1 <= level <= d.n_levels, "malformed: a node at no level")
            numbers = children[at : at + d.sizes[level]]
            at += d.sizes[level]
            claim(at <= len(children), "malformed: a node lacks children")
            claim(
                all(0 <= c < len(nodes) and d.level[nodes[c]] < level for c in numbers), "malformed: a child of a node"
            )
            nodes.append(d.make(level, tuple(nodes[c] for c in numbers)))
        claim(at == len(children), "malformed: children of no node")
        return nodes

    def _steps(self) -> list[Step]:
        """Return what each event does; one that no automaton has never happens."""
        moves: list[list[tuple[int, bool, list[tuple[int, int]]]]] = [[] for _ in self.problem.events]
        for k, a in enumerate(self.problem.automata):
            pairs: dict[int, list[tuple[int, int]]] = {e: [] for e in np.flatnonzero(a.own).tolist()}
            for source, event, target in zip(a.source.tolist(), a.events.tolist(), a.targets.tolist(), strict=True):
                pairs[event].append((source, target))
            for event, own in pairs.items():
                moves[event].append((self.level[k], a.plant, own))
        d, steps = self.diagrams, []
        for name, free, parts in zip(self.problem.events, self.problem.free, moves, strict=True):
            if parts:
                can = d.cube({level: [i for i, _ in own] for level, plant, own in parts if plant})
                may = d.cube({level: [i for i, _ in own] for level, plant, own in parts if not plant})
                relation = d.relation((level, tuple(own)) for level, _, own in parts)
                steps.append(Step(name, free, relation, d.inverse(relation), can, may))
        return steps

    def check(self) -> None:
        """Go through the whole proof; raise Wrong at the first thing that is not so.

        Two closures of K and one of each round, by saturation, are most of the time.
        """
        with deep(self.diagrams.n_levels):
            d = self.diagrams
            self.broken = d.any_of(d.minus(s.can, s.may) for s in self.steps if s.free)
            self.uncontrolled = Closure(d, [s.back for s in self.steps if s.free])
            for reason, seeds, states in self.rounds:
                self.check_round(reason, seeds, states)
                self.removed = d.unite(self.removed, states)
            self.check_supervisor()
            everything = d.unite(self.K, self.removed)
            transitions = d.count_steps(self.K, (s.relation for s in self.steps))
            self.sizes = d.count(self.K), transitions, d.count(everything)

    def check_round(self, reason: int, seeds: Node, states: Node) -> None:
        """Every one of ``states`` had to be removed, given that those removed so far had to be."""
        d = self.diagrams
        words = "breaking a specification" if reason == ILLEGAL else "blocking"
        without = f"was removed for {words} without that being so"
        stray = d.minus(seeds, states)
        claim(not stray, f"not largest: {self.where(stray)} is a reason for a removal, but not removed itself")
        if reason == ILLEGAL:
            legal = d.minus(seeds, self.broken)
            claim(not legal, f"not largest: {self.where(legal)} {without}")
        else:
            marked = d.intersect(seeds, self.marked)
            claim(not marked, f"not largest: {self.where(marked)} {without}: it is marked")
            escape = self.escape(seeds, d.unite(seeds, self.removed), self.steps)
            claim(not escape, f"not largest: {escape}, so the first was not blocking")
        other = d.minus(states, self.uncontrolled(seeds, states) if seeds != states else states)
        claim(
            not other, f"not largest: {self.where(other)} was removed for an uncontrollable event without that being so"
        )

    def check_supervisor(self) -> None:
        """K is legal, controllable, nonblocking, left for removed states only, and reached; or rightly empty."""
        d, K = self.diagrams, self.K
        if K == NOTHING:
            lost = d.minus(self.initial, self.removed)
            claim(not lost, "not largest: the supervisor is empty, but no removal has the initial state")
            return
        claim(not d.minus(self.initial, K), "the supervisor does not begin in the initial state")
        illegal = d.intersect(K, self.broken)
        if illegal:
            step = next(s for s in self.steps if s.free and d.intersect(illegal, d.minus(s.can, s.may)))
            where = self.where(d.intersect(illegal, d.minus(step.can, step.may)))
            raise Wrong(f"not within the specifications: {step.event} breaks one in {where}")
        escape = self.escape(K, K, [s for s in self.steps if s.free])
        claim(not escape, f"not controllable: {escape}, which is not in the supervisor")
        escape = self.escape(K, d.unite(K, self.removed), [s for s in self.steps if not s.free])
        claim(not escape, f"not largest: {escape}, which is neither in the supervisor nor removed")
        marking = Closure(d, [s.back for s in self.steps])
        stuck = d.minus(K, marking(self.marked, K))
        claim(not stuck, f"not nonblocking: there is no way to a marked state from {self.where(stuck)}")
        onward = Closure(d, [s.relation for s in self.steps])
        unreached = d.minus(K, onward(self.initial, K))
        claim(not unreached, f"the supervisor has {self.where(unreached)}, which is never entered")

    def escape(self, states: Node, into: Node, steps: Sequence[Step]) -> str:
        """Say how one of ``steps`` leads from ``states`` to a state outside ``into``; empty if none does."""
        d = self.diagrams
        relation = d.first_escape(states, into, (s.relation for s in steps))
        if relation is None:
            return ""
        step = next(s for s in steps if s.relation == relation)
        outside = d.minus(d.image(states, relation), into)
        source = d.intersect(states, d.image(self.only(outside), step.back))
        return f"{step.event} leads from {self.where(source)} to {self.where(outside)}"

    def only(self, states: Node) -> Node:
        """Return the set of the first of ``states`` alone."""
        vector = self.diagrams.pick(states)
        return self.diagrams.cube({len(vector) - k: [value] for k, value in enumerate(vector)})

    def where(self, states: Node) -> str:
        """Name the first of ``states``, if there is one: the automata that are not in their initial state there."""
        if states == NOTHING:
            return ""
        by_level = self.diagrams.pick(states)
        automata = self.problem.automata
        moved = [
            f"{a.name}:{by_level[-self.level[k]]}"
            for k, a in enumerate(automata)
            if by_level[-self.level[k]] != a.initial
        ]
        if not moved:
            return "the initial state"
        more = [f"{len(moved) - SHOWN:,} more"] if len(moved) > SHOWN else []
        others = "; the others as at first" if len(moved) < len(automata) else ""
        return f"state ({', '.join(moved[:SHOWN] + more)}{others})"
