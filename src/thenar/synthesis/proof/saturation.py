"""Closures of sets under relations, for the certificate checker."""

from __future__ import annotations

from collections.abc import Iterable

from thenar.synthesis.proof.mdd import IDENTITY, NOTHING, Diagrams, Node, Relation

__all__ = ["Closure"]


class Closure:
    """What relations reach from a set, by saturation.

    The children of a node are closed under what happens below before what happens at the node's own level is
    applied, until nothing is new: so most of the work is done on small diagrams, once for all that share them.
    Results are kept from call to call.   [Ciardo, Marmorstein and Siminiscalco 2003]

    >>> d = Diagrams([3, 2])  # level 1 counts, where level 2 is 0
    >>> up = d.relation([(1, ((0, 1), (1, 2))), (2, ((0, 0),))])
    >>> d.count(Closure(d, [up])(d.cube({1: [0]}), d.cube({})))
    4
    """

    def __init__(self, diagrams: Diagrams, relations: Iterable[Relation]) -> None:
        self.d = diagrams
        by_level: list[set[tuple[int, int, Relation]]] = [set() for _ in diagrams.sizes]
        for relation in relations:
            if relation > IDENTITY:
                level, pairs, rest = diagrams.links[relation]
                by_level[level].update((i, j, rest) for i, j in pairs)
        self.moves = [
            [sorted(s for s in m if s[0] == i) for i in range(diagrams.sizes[k])] if m else None
            for k, m in enumerate(by_level)
        ]
        self.next = [0] * len(by_level)  # the highest level at or below this one with a move
        for level in range(1, len(by_level)):
            self.next[level] = level if by_level[level] else self.next[level - 1]
        self.closed: dict[tuple[int, Node, Node], Node] = {}
        self.fired: dict[tuple[int, Node, Relation, Node], Node] = {}

    def __call__(self, start: Node, within: Node) -> Node:
        """Return what is reached from ``start`` & ``within`` without leaving ``within``."""
        return self._close(self.d.n_levels, self.d.intersect(start, within), within)

    def _close(self, top: int, node: Node, within: Node) -> Node:
        """Return what the moves at levels ``top`` .. 1 reach from ``node``, a part of ``within``, inside ``within``."""
        d = self.d
        if node in (NOTHING, within):
            return node
        # levels without moves, and that neither set looks at, are passed over
        level = max(self.next[top], d.level[node], d.level[within])
        if not self.next[top]:
            return node
        key = level, node, within
        found = self.closed.get(key)
        if found is None:
            close, below = self._close, level - 1
            kids = [close(below, x, y) for x, y in zip(d.below(node, level), d.below(within, level), strict=True)]
            self._settle(level, kids, within)
            found = self.closed[key] = d.make(level, tuple(kids))
        return found

    def _settle(self, level: int, kids: list[Node], within: Node) -> None:
        """Apply the moves of ``level`` to the ``kids``, each of them closed, until nothing is new."""
        moves = self.moves[level]
        if moves is None:
            return
        d, allowed = self.d, self.d.below(within, level)
        fresh = [v for v, x in enumerate(kids) if x != NOTHING]
        while fresh:
            i = fresh.pop()
            for _, j, rest in moves[i]:
                if kids[j] == allowed[j]:
                    continue
                more = d.unite(kids[j], self._fire(level - 1, kids[i], rest, allowed[j]))
                if more != kids[j]:
                    kids[j] = more
                    if j not in fresh:
                        fresh.append(j)

    def _fire(self, top: int, node: Node, relation: Relation, within: Node) -> Node:
        """Return where ``relation`` leads from ``node`` inside ``within``, closed under the moves up to ``top``."""
        d = self.d
        if NOTHING in (node, within):
            return NOTHING
        if relation == IDENTITY:
            return self._close(top, d.intersect(node, within), within)
        at, pairs, rest = d.links[relation]
        level = max(self.next[top], at, d.level[node], d.level[within])
        key = level, node, relation, within
        found = self.fired.get(key)
        if found is None:
            fire, below = self._fire, level - 1
            sources, allowed = d.below(node, level), d.below(within, level)
            if level == at:
                kids = [NOTHING] * d.sizes[level]
                for i, j in pairs:
                    kids[j] = d.unite(kids[j], fire(below, sources[i], rest, allowed[j]))
            else:
                kids = [fire(below, x, relation, y) for x, y in zip(sources, allowed, strict=True)]
            # the union of closed sets is closed, for a move is of each of their vectors by itself
            raw = d.make(level, tuple(kids))
            closed = self.closed.get((level, raw, within))
            if closed is None:
                self._settle(level, kids, within)
                closed = self.closed[level, raw, within] = d.make(level, tuple(kids))
            found = self.fired[key] = closed
        return found
