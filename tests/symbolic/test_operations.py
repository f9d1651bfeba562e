"""Every operation on diagrams against plain Python sets of tuples, with garbage collected all the time."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from random import Random

import numpy as np
import pytest

from thenar._native import kernel

State = tuple[int, ...]
Steps = set[tuple[State, State]]
TICK = kernel.Ticker()
ALL = (1 << 63) - 1


class World:
    """A forest, and for sets and relations drawn at random their plain twins; states are written top level first."""

    def __init__(self, rng: Random, collect_at: int, cache_bytes: int) -> None:
        self.rng, self.n = rng, rng.choice((1, 2, 3, 5))
        self.sizes = [rng.randint(2, 4) for _ in range(self.n)]  # of level k + 1
        self.forest = kernel.Forest(np.array(self.sizes, np.uint32), ALL, cache_bytes, collect_at)
        self.levels = list(range(self.n, 0, -1))
        self.states: set[State] = set(itertools.product(*(range(self.sizes[k - 1]) for k in self.levels)))
        self.sets = [self.draw() for _ in range(4)]
        self.relations = [self.relation(self.some(3)) for _ in range(3)]

    def at(self, level: int) -> int:
        return self.n - level

    def some(self, most: int) -> list[int]:
        return sorted(self.rng.sample(self.levels, self.rng.randint(0, min(most, self.n))), reverse=True)

    def to(self, states: set[State]) -> kernel.Set:
        truth = np.zeros([self.sizes[k - 1] for k in self.levels], np.uint8)
        for state in states:
            truth[state] = 1
        return self.forest.table(self.levels, truth.ravel())

    def back(self, diagram: kernel.Set) -> set[State]:
        rows = diagram.vectors(ALL).reshape(-1, self.n).tolist()
        assert rows == sorted(rows)
        return {tuple(row) for row in rows}

    def draw(self) -> tuple[kernel.Set, set[State]]:
        kind = self.rng.randrange(4)
        if kind == 0:
            return self.rng.choice([(self.forest.nothing, set()), (self.forest.everything, set(self.states))])
        if kind == 1:
            level = self.rng.choice(self.levels)
            mask = np.array([self.rng.random() < 0.5 for _ in range(self.sizes[level - 1])], np.uint8)
            return self.forest.literal(level, mask), {x for x in self.states if mask[x[self.at(level)]]}
        share = self.rng.choice((0.02, 0.1, 0.5, 0.9))
        states = {x for x in sorted(self.states) if self.rng.random() < share}
        return self.to(states), states

    def relation(self, levels: list[int]) -> tuple[int, Steps]:
        """Return rows (before, after) over ``levels``, drawn at random, and the steps that they mean."""
        if not levels:
            return 1, {(x, x) for x in self.states}
        rows = [
            [self.rng.randrange(self.sizes[k - 1]) for k in levels for _ in (0, 1)]
            for _ in range(self.rng.randint(0, 8))
        ]
        steps = set()
        for x, row in itertools.product(self.states, rows):
            if all(x[self.at(k)] == row[2 * i] for i, k in enumerate(levels)):
                y = list(x)
                for i, k in enumerate(levels):
                    y[self.at(k)] = row[2 * i + 1]
                steps.add((x, tuple(y)))
        return self.forest.rows(levels, np.array(rows, np.uint32).ravel()), steps

    def keep(self, diagram: kernel.Set, states: set[State]) -> None:
        assert self.back(diagram) == states
        assert diagram.count() == len(states)
        assert diagram == self.to(states)  # canonical
        assert (bool(diagram), diagram.is_everything) == (bool(states), states == self.states)
        self.sets.append((diagram, states))

    def keep_relation(self, relation: int, steps: Steps) -> None:
        start, states = self.rng.choice(self.sets)
        assert self.back(self.forest.image(start, relation)) == {y for x, y in steps if x in states}
        self.relations.append((relation, steps))


def closure(relations: list[Steps], start: set[State], within: set[State]) -> set[State]:
    found = start & within
    while more := {y for steps in relations for x, y in steps if x in found and y in within} - found:
        found |= more
    return found


def boolean(w: World) -> None:
    (a, x), (b, y) = w.rng.choices(w.sets, k=2)
    w.keep(a & b, x & y)
    w.keep(a | b, x | y)
    w.keep(a - b, x - y)
    w.keep(~a, w.states - x)
    w.keep(w.forest.any_of([a, b], TICK), x | y)
    w.keep(w.forest.all_of([a, b], TICK), x & y)
    w.keep(*w.draw())


def simplify(w: World) -> None:
    (a, _), (care, _) = w.rng.choices(w.sets, k=2)
    assert a.simplify(care) & care == a & care


def products(w: World) -> None:
    (a, x), (b, y) = w.rng.choices(w.sets, k=2)
    low, least = w.rng.choice([(a & b, x & y), (a, x)])
    found = low.products(a, ALL)
    assert found is not None
    covered = {s for s in w.states for p in found if all(s[w.at(k)] in values for k, values in p)}
    assert least <= covered <= x
    assert low.products(a, len(found)) == found
    assert not found or low.products(a, len(found) - 1) is None


def factors(w: World) -> None:
    a, _ = w.rng.choice(w.sets)
    found = a.factors()
    supports = [set(f.support()) for f in found]
    assert w.forest.all_of(found, TICK) == a
    assert sum(map(len, supports)) == len(set().union(*supports))


def forget(w: World) -> None:
    (a, x), free = w.rng.choice(w.sets), w.some(w.n)
    mask = np.zeros(w.n + 1, np.uint8)
    mask[free] = 1
    kept = [w.at(k) for k in w.levels if k not in free]
    seen = {tuple(s[i] for i in kept) for s in x}
    w.keep(a.forget(mask), {s for s in w.states if tuple(s[i] for i in kept) in seen})


def images(w: World) -> None:
    (a, x), (r, steps) = w.rng.choice(w.sets), w.rng.choice(w.relations)
    w.keep(w.forest.image(a, r), {t for s, t in steps if s in x})
    w.keep(w.forest.domain(r), {s for s, _ in steps})
    w.keep_relation(w.forest.inverse(r), {(t, s) for s, t in steps})
    w.keep_relation(w.forest.restrict(r, a), {(s, t) for s, t in steps if s in x})


def states(w: World) -> None:
    state, chosen = w.rng.choice(sorted(w.states)), w.rng.choices(w.relations, k=3)
    row, within = np.array(state, np.uint32), [state in x for _, x in w.sets]
    assert w.forest.contains(row, [a for a, _ in w.sets]).tolist() == within
    for a, x in w.sets:
        led = [any(s == state and t in x for s, t in steps) for _, steps in chosen]
        assert w.forest.lead_into(a, row, [r for r, _ in chosen]).tolist() == led


def relations(w: World) -> None:
    (r, one), (q, other) = w.rng.choices(w.relations, k=2)
    w.keep_relation(w.forest.either(r, q), one | other)
    levels = w.some(w.n)
    cut = w.rng.randint(0, len(levels))
    (r, one), (q, other) = w.relation(levels[:cut]), w.relation(levels[cut:])
    w.keep_relation(w.forest.join(r, q), {(s, u) for s, t in one for t2, u in other if t == t2})
    w.keep_relation(*w.relation(w.some(3)))


def saturation(w: World) -> None:
    chosen = w.rng.choices(w.relations, k=w.rng.randint(0, 4))
    run = w.forest.saturation([r for r, _ in chosen])
    for _ in range(3):
        (a, x), (b, y) = w.rng.choices(w.sets, k=2)
        w.keep(run(a, b, TICK), closure([steps for _, steps in chosen], x, y))
        w.keep(run(a, w.forest.everything, TICK), closure([steps for _, steps in chosen], x, w.states))


def counting(w: World) -> None:
    (a, x), (b, y) = w.rng.choices(w.sets, k=2)
    chosen = w.rng.choices(w.relations, k=3)
    inside = [{(s, t) for s, t in steps if s in x and t in x} for _, steps in chosen]
    assert w.forest.count_steps(a, [r for r, _ in chosen], TICK) == sum(map(len, inside))
    number = {s: k for k, s in enumerate(sorted(x))}
    sources, targets = w.forest.steps(a, a & b, chosen[0][0])
    expected = sorted((number[s], number[t]) for s, t in inside[0] if s in y)
    assert sorted(zip(sources.tolist(), targets.tolist(), strict=True)) == expected


OPERATIONS: list[Callable[[World], None]] = [
    boolean,
    simplify,
    products,
    factors,
    forget,
    images,
    states,
    relations,
    saturation,
    counting,
]


@pytest.mark.parametrize("collect_at", [0, 20, 1 << 16])
def test_diagrams_do_what_sets_of_tuples_do(collect_at: int) -> None:
    for seed in range(60):
        rng = Random(seed)
        world = World(rng, collect_at, cache_bytes=rng.choice((0, 1 << 16)))
        for _ in range(20):
            rng.choice(OPERATIONS)(world)
            world.sets, world.relations = world.sets[-12:], world.relations[-8:]
        for diagram, states in world.sets:
            assert world.back(diagram) == states
