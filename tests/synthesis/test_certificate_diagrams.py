"""The checker's own diagrams against plain sets of vectors."""

import itertools
import random
import sys

import pytest

from thenar.synthesis.proof.mdd import EVERYTHING, IDENTITY, NEVER, NOTHING, Diagrams, Node, Pairs, deep
from thenar.synthesis.proof.saturation import Closure

Vector = tuple[int, ...]
Moves = list[tuple[int, Pairs]]


class World:
    """A few small levels, with every vector over them; vectors have the top level first."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.sizes = [self.rng.randint(1, 3) for _ in range(self.rng.randint(1, 5))]
        self.n = len(self.sizes)
        self.d = Diagrams(self.sizes)
        self.all = set(itertools.product(*(range(size) for size in self.sizes[::-1])))

    def node(self, vectors: set[Vector]) -> Node:
        return self.d.any_of(self.d.cube({self.n - k: [v] for k, v in enumerate(x)}) for x in sorted(vectors))

    def some(self) -> set[Vector]:
        return {x for x in sorted(self.all) if self.rng.random() < self.rng.choice((0.2, 0.5, 0.9))}

    def moves(self) -> Moves:
        """A relation of random pairs at random levels; now and then one that never happens, or changes nothing."""
        chosen = sorted(self.rng.sample(range(1, self.n + 1), self.rng.randint(0, self.n)))
        found: Moves = []
        for level in chosen:
            values = range(self.sizes[level - 1])
            every = [(i, j) for i in values for j in values]
            found.append((level, tuple(self.rng.sample(every, self.rng.randint(self.rng.random() > 0.1, len(every))))))
        return found

    def image(self, vectors: set[Vector], moves: Moves) -> set[Vector]:
        found = vectors
        for level, pairs in moves:
            k = self.n - level
            found = {(*x[:k], j, *x[k + 1 :]) for x in found for i, j in pairs if x[k] == i}
        return found


@pytest.mark.parametrize("seeds", [range(k, k + 100) for k in range(0, 500, 100)], ids=str)
def test_sets_and_relations_are_what_they_stand_for(seeds: range) -> None:
    for seed in seeds:
        w = World(seed)
        d, (a, b) = w.d, (w.some(), w.some())
        x, y = w.node(a), w.node(b)
        assert (w.node(w.all), w.node(set())) == (EVERYTHING, NOTHING)
        assert (d.unite(x, y), d.intersect(x, y), d.minus(x, y)) == (w.node(a | b), w.node(a & b), w.node(a - b))
        assert (d.count(x), d.count(y)) == (len(a), len(b))
        assert not a or d.pick(x) == list(min(a))
        relations = [w.moves() for _ in range(3)]
        for moves in relations:
            r = d.relation(moves)
            assert d.image(x, r) == w.node(w.image(a, moves))
            back = [(level, tuple((j, i) for i, j in pairs)) for level, pairs in moves]
            assert d.image(x, d.inverse(r)) == w.node(w.image(a, back))
            assert (d.first_escape(x, y, [r]) is None) == (w.image(a, moves) <= b)
            assert d.count_steps(x, [r]) == sum(len(w.image({v}, moves) & a) for v in a)
        numbers = [d.relation(moves) for moves in relations]
        assert d.count_steps(x, numbers) == sum(d.count_steps(x, [r]) for r in numbers)
        escape = d.first_escape(x, y, numbers)
        assert (escape is None) == all(w.image(a, moves) <= b for moves in relations)
        assert escape is None or d.minus(d.image(x, escape), y)


@pytest.mark.parametrize("seeds", [range(k, k + 200) for k in range(0, 1000, 200)], ids=str)
def test_a_closure_is_all_that_can_be_reached_and_no_more(seeds: range) -> None:
    for seed in seeds:
        w = World(seed)
        relations = [w.moves() for _ in range(w.rng.randint(0, 4))]
        closure = Closure(w.d, [w.d.relation(moves) for moves in relations])
        for start, within in ((w.some(), w.some()), (w.some(), w.all), (w.some(), w.some())):
            found = start & within
            while more := set[Vector]().union(*(w.image(found, moves) for moves in relations)) & within - found:
                found |= more
            assert closure(w.node(start), w.node(within)) == w.node(found)


def test_relations_without_a_level() -> None:
    d = Diagrams([2])
    assert (d.relation([]), d.relation([(1, ())])) == (IDENTITY, NEVER)
    assert d.inverse(IDENTITY) == IDENTITY
    assert d.inverse(NEVER) == NEVER
    one = d.cube({1: [0]})
    assert d.first_escape(one, NOTHING, [NEVER, IDENTITY]) == IDENTITY
    assert d.count_steps(one, [NEVER, IDENTITY, IDENTITY]) == 2


def test_many_levels_are_no_problem() -> None:
    """A token that is passed on along 20 000 places: states are as many."""
    n, before = 20_000, sys.getrecursionlimit()
    d = Diagrams([2] * n)
    with deep(n):
        first = d.cube({level: [level == n] for level in range(1, n + 1)})
        passes = [d.relation([(k, ((1, 0),)), (k - 1, ((0, 1),))]) for k in range(n, 1, -1)]
        everywhere = Closure(d, passes)(first, EVERYTHING)
        assert d.count(everywhere) == n
        assert d.count_steps(everywhere, passes) == n - 1
        assert d.first_escape(everywhere, everywhere, passes) is None
    assert sys.getrecursionlimit() == before
