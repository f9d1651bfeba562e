"""Decision diagrams for the certificate checker: small, slow, and in plain Python.

A diagram over levels n, ..., 1 with ``sizes[k - 1]`` values at level k stands for a set of vectors, one value for each
level.  A node is a number: 0 the empty set, 1 the set of all vectors, any other one a level and a child for each value
there.  Nodes are interned and none has all children alike, so a set has one number; a level that a set does not
look at is skipped.  [Bryant 1986; Srinivasan, Kam, Malik and Brayton 1990]

A relation is a chain of links (level, pairs (from, to), rest), from the top level down, and numbered too: 0 never
happens, 1 changes nothing; levels that it does not mention keep their value.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import accumulate
from operator import mul
from typing import TypeAlias

__all__ = ["EVERYTHING", "IDENTITY", "NEVER", "NOTHING", "Diagrams", "deep"]

NOTHING, EVERYTHING = 0, 1
NEVER, IDENTITY = 0, 1
FRAMES = 4  # at most this many calls stand in each other for each level, some hundred for what calls them

Node: TypeAlias = int
Relation: TypeAlias = int
Pairs: TypeAlias = tuple[tuple[int, int], ...]


@contextmanager
def deep(levels: int) -> Iterator[None]:
    """Allow for recursion over so many levels; calls from Python to Python take no room on the machine's stack."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(before + FRAMES * levels + 500)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


class Diagrams:
    """All sets and relations over levels 1 .. len(sizes); nothing is ever forgotten.

    Operations on two sets take time in the product of their nodes at worst, mostly in the sum.

    >>> d = Diagrams([2, 3])
    >>> top, low = d.cube({2: [0, 2]}), d.cube({1: [1]})
    >>> d.count(d.unite(top, low)), d.pick(d.minus(top, low))
    (5, [0, 0])
    >>> swap = d.relation([(1, ((0, 1), (1, 0))), (2, ((0, 2),))])
    >>> [d.pick(s) for s in (d.image(top, swap), d.image(top, d.inverse(swap)))]
    [[2, 0], [0, 0]]
    """

    def __init__(self, sizes: Sequence[int]) -> None:
        self.sizes = (0, *sizes)
        self.spans = list(accumulate(sizes, mul, initial=1))  # vectors over levels k .. 1
        self.level = [0, 0]  # of each node
        self.kids: list[tuple[Node, ...]] = [(), ()]
        self.links: list[tuple[int, Pairs, Relation]] = [(0, (), NEVER), (0, (), IDENTITY)]  # of each relation
        self._nodes: dict[tuple[int, tuple[Node, ...]], Node] = {}
        self._relations: dict[tuple[int, Pairs, Relation], Relation] = {}
        self._united: dict[tuple[Node, Node], Node] = {}
        self._shared: dict[tuple[Node, Node], Node] = {}
        self._lacking: dict[tuple[Node, Node], Node] = {}
        self._counts: dict[Node, int] = {NOTHING: 0, EVERYTHING: 1}
        self._images: dict[tuple[Node, Relation], Node] = {}
        self._steps: dict[tuple[Node, Node, Relation], int] = {}
        self._kept: dict[tuple[Node, Node, Relation], bool] = {}

    @property
    def n_levels(self) -> int:
        """How many levels there are."""
        return len(self.sizes) - 1

    # -- sets ----------------------------------------------------------------------------------------------

    def make(self, level: int, kids: tuple[Node, ...]) -> Node:
        """Return the node with these children."""
        first = kids[0]
        if kids.count(first) == len(kids):
            return first
        key = level, kids
        node = self._nodes.get(key)
        if node is None:
            node = self._nodes[key] = len(self.level)
            self.level.append(level)
            self.kids.append(kids)
        return node

    def below(self, node: Node, level: int) -> Sequence[Node]:
        """Return the children of ``node`` at ``level``, which is its own or one above it that it skips."""
        return self.kids[node] if self.level[node] == level else (node,) * self.sizes[level]

    def child(self, node: Node, level: int, value: int) -> Node:
        """Return the child of ``node`` for ``value`` at ``level``."""
        return self.kids[node][value] if self.level[node] == level else node

    def cube(self, allowed: dict[int, Iterable[int]]) -> Node:
        """Return the vectors that have one of the ``allowed`` values at each of these levels."""
        node = EVERYTHING
        for level in sorted(allowed):
            mine = set(allowed[level])
            node = self.make(level, tuple(node if v in mine else NOTHING for v in range(self.sizes[level])))
        return node

    def unite(self, a: Node, b: Node) -> Node:
        """Return a | b."""
        if a > b:
            a, b = b, a
        if a <= EVERYTHING or a == b:
            return b if a == NOTHING else a
        key = a, b
        found = self._united.get(key)
        if found is None:
            level, rows = self._side_by_side(a, b)
            unite = self.unite
            found = self._united[key] = self.make(level, tuple([unite(x, y) for x, y in rows]))
        return found

    def intersect(self, a: Node, b: Node) -> Node:
        """Return a & b."""
        if a > b:
            a, b = b, a
        if a <= EVERYTHING or a == b:
            return b if a == EVERYTHING else a
        key = a, b
        found = self._shared.get(key)
        if found is None:
            level, rows = self._side_by_side(a, b)
            intersect = self.intersect
            found = self._shared[key] = self.make(level, tuple([intersect(x, y) for x, y in rows]))
        return found

    def minus(self, a: Node, b: Node) -> Node:
        """Return a - b."""
        if a in (b, NOTHING) or b == EVERYTHING:
            return NOTHING
        if b == NOTHING:
            return a
        found = self._lacking.get((a, b))
        if found is None:
            level, rows = self._side_by_side(a, b)
            minus = self.minus
            found = self._lacking[a, b] = self.make(level, tuple([minus(x, y) for x, y in rows]))
        return found

    def _side_by_side(self, a: Node, b: Node) -> tuple[int, Iterable[tuple[Node, Node]]]:
        """Return the higher of the levels of ``a`` and ``b``, and their children there side by side."""
        la, lb = self.level[a], self.level[b]
        if la == lb:
            return la, zip(self.kids[a], self.kids[b], strict=True)
        if la > lb:
            return la, [(x, b) for x in self.kids[a]]
        return lb, [(a, y) for y in self.kids[b]]

    def any_of(self, sets: Iterable[Node]) -> Node:
        """Return the union; those that look at the same levels are joined first."""
        left = sorted(sets, key=self.level.__getitem__)
        while len(left) > 1:
            left = [self.unite(*left[k : k + 2]) if k + 1 < len(left) else left[k] for k in range(0, len(left), 2)]
        return left[0] if left else NOTHING

    def count(self, node: Node) -> int:
        """Return the number of vectors in the set, exactly."""
        return self._count(node) * self._between(self.n_levels, self.level[node])

    def _count(self, node: Node) -> int:
        """Return how many vectors over the levels from that of ``node`` down are in it."""
        found = self._counts.get(node)
        if found is None:
            found, below = 0, self.level[node] - 1
            for x in self.kids[node]:
                if x != NOTHING:
                    found += self._count(x) * self._between(below, self.level[x])
            self._counts[node] = found
        return found

    def _between(self, high: int, low: int) -> int:
        """Return the number of vectors over the levels ``high`` .. ``low`` + 1."""
        return 1 if high == low else self.spans[high] // self.spans[low]

    def pick(self, node: Node) -> list[int]:
        """Return the first vector of a set that is not empty, top level first."""
        vector = []
        for level in range(self.n_levels, 0, -1):
            kids = self.below(node, level)
            value = next(v for v, x in enumerate(kids) if x != NOTHING)
            vector.append(value)
            node = kids[value]
        return vector

    def n_nodes(self, roots: Iterable[Node]) -> int:
        """Return how many nodes the sets have together."""
        seen: set[Node] = set()
        ahead = list(roots)
        while ahead:
            node = ahead.pop()
            if node > EVERYTHING and node not in seen:
                seen.add(node)
                ahead.extend(self.kids[node])
        return len(seen)

    # -- relations -----------------------------------------------------------------------------------------

    def relation(self, moves: Iterable[tuple[int, Pairs]]) -> Relation:
        """Return the relation that does ``pairs`` at each level of (level, pairs), which differ."""
        relation = IDENTITY
        for level, pairs in sorted(moves):
            relation = self._link(level, pairs, relation)
        return relation

    def _link(self, level: int, pairs: Pairs, rest: Relation) -> Relation:
        if not pairs or rest == NEVER:
            return NEVER
        key = level, tuple(sorted(pairs)), rest
        found = self._relations.get(key)
        if found is None:
            found = self._relations[key] = len(self.links)
            self.links.append(key)
        return found

    def inverse(self, relation: Relation) -> Relation:
        """Return the relation that leads back."""
        moves = []
        while relation > IDENTITY:
            level, pairs, relation = self.links[relation]
            moves.append((level, tuple((j, i) for i, j in pairs)))
        return NEVER if relation == NEVER else self.relation(moves)

    def image(self, node: Node, relation: Relation) -> Node:
        """Return where ``relation`` leads from the set."""
        if node == NOTHING or relation <= IDENTITY:
            return node if relation == IDENTITY else NOTHING
        found = self._images.get((node, relation))
        if found is None:
            at, pairs, rest = self.links[relation]
            level = max(at, self.level[node])
            image = self.image
            if level == at:
                kids = [NOTHING] * self.sizes[level]
                for i, j in pairs:
                    kids[j] = self.unite(kids[j], image(self.child(node, level, i), rest))
            else:
                kids = [image(x, relation) for x in self.kids[node]]
            found = self._images[node, relation] = self.make(level, tuple(kids))
        return found

    def first_escape(self, node: Node, into: Node, relations: Iterable[Relation]) -> Relation | None:
        """Return one of ``relations`` that leads from the set ``node`` to a vector outside ``into``; None if none does.

        Both diagrams are gone through together, from the top down, all relations at once: above its top level a
        relation changes nothing, so there it needs no look.
        """
        by_level: dict[int, list[Relation]] = defaultdict(list)
        for relation in relations:
            if relation > IDENTITY:
                by_level[self.links[relation][0]].append(relation)
            elif relation == IDENTITY and self.minus(node, into):
                return relation
        ahead = {(node, into)}
        for level in range(self.n_levels, 0, -1):
            ahead = {(x, y) for x, y in ahead if x != NOTHING and y != EVERYTHING}
            for relation in by_level[level]:
                for x, y in ahead:
                    if not self._leads_into(x, y, relation):
                        return relation
            lower: set[tuple[Node, Node]] = set()
            for x, y in ahead:
                if level in (self.level[x], self.level[y]):
                    lower.update(zip(self.below(x, level), self.below(y, level), strict=True))
                else:
                    lower.add((x, y))
            ahead = lower
        return None

    def _leads_into(self, x: Node, y: Node, relation: Relation) -> bool:
        """Return whether ``relation`` leads from ``x`` to ``y`` only."""
        if x == NOTHING or y == EVERYTHING:
            return True
        if relation == IDENTITY:
            return not self.minus(x, y)
        found = self._kept.get((x, y, relation))
        if found is None:
            at, pairs, rest = self.links[relation]
            level = max(at, self.level[x], self.level[y])
            found = True
            if level == at:
                for i, j in pairs:
                    if not self._leads_into(self.child(x, level, i), self.child(y, level, j), rest):
                        found = False
                        break
            else:
                for a, b in zip(self.below(x, level), self.below(y, level), strict=True):
                    if not self._leads_into(a, b, relation):
                        found = False
                        break
            self._kept[x, y, relation] = found
        return found

    def count_steps(self, node: Node, relations: Iterable[Relation]) -> int:
        """Return how many pairs of vectors of the set the ``relations`` lead along, summed over them."""
        by_level: dict[int, list[Relation]] = defaultdict(list)
        total = 0
        for relation in relations:
            if relation > IDENTITY:
                by_level[self.links[relation][0]].append(relation)
            else:
                total += self.count(node) * (relation == IDENTITY)
        ways = {node: 1}  # from the top to each node, values of skipped levels counted
        for level in range(self.n_levels, 0, -1):
            for relation in by_level[level]:
                for x, many in ways.items():
                    total += many * self._count_steps(x, x, relation, level)
            lower: dict[Node, int] = defaultdict(int)
            for x, many in ways.items():
                if self.level[x] == level:
                    for kid in self.kids[x]:
                        lower[kid] += many
                else:
                    lower[x] += many * self.sizes[level]
            lower.pop(NOTHING, None)
            ways = lower
        return total

    def _count_steps(self, x: Node, y: Node, relation: Relation, top: int) -> int:
        """Return how many pairs of ``x`` and ``y`` over levels ``top`` .. 1 the relation leads along."""
        if NOTHING in (x, y):
            return 0
        if relation == IDENTITY:
            both = self.intersect(x, y)
            return self._count(both) * self._between(top, self.level[both])
        at, pairs, rest = self.links[relation]
        level = max(at, self.level[x], self.level[y])
        found = self._steps.get((x, y, relation))
        if found is None:
            found = 0
            if level == at:
                for i, j in pairs:
                    found += self._count_steps(self.child(x, level, i), self.child(y, level, j), rest, level - 1)
            else:
                for a, b in zip(self.below(x, level), self.below(y, level), strict=True):
                    found += self._count_steps(a, b, relation, level - 1)
            self._steps[x, y, relation] = found
        return found * self._between(top, level)
