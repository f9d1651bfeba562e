"""Micro-benchmarks of single steps, for those who change one: ``make bench-micro``, no part of ``make test``."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import thenar
from bench.tower import tower
from thenar.model.expressions import parse

model = thenar.library.model
GLR, LINES, TABLE = model("glr"), model("transfer_line(2)"), model("dining(30)")
SUPERVISED = thenar.synthesize(GLR)
AUTOMATON = SUPERVISED.supervisor.automaton
TOWER = tower(2, 2)
TEXT = thenar.dumps(GLR)
GUARD = "not (CAT.room1 and MOUSE.room1) or (n + 2 * m) % 5 < 3 and n != m"

STEPS: dict[str, Callable[[], object]] = {
    "product": lambda: thenar.sync(*LINES.plants, *LINES.specs),
    "synthesis": lambda: thenar.synthesize(GLR),
    "synthesis of 784 states": lambda: thenar.synthesize(LINES, "explicit"),
    "trim": lambda: thenar.trim(AUTOMATON),
    "minimisation": lambda: thenar.minimize(AUTOMATON),
    "projection": lambda: thenar.project(AUTOMATON, ["approach_1", "approach_2"]),
    "reason": lambda: thenar.explain_disabled(SUPERVISED, "approach_2"),
    "simulation": lambda: thenar.random_trace(SUPERVISED.supervisor, 100, seed=1),
    "reading": lambda: thenar.loads(TEXT),
    "expression": lambda: parse(GUARD),
    "diagrams": lambda: thenar.synthesize(TABLE, "symbolic"),
    "diagrams of a tower": lambda: thenar.synthesize(TOWER, "symbolic"),
}


@pytest.mark.parametrize("step", STEPS)
def test_step(benchmark: BenchmarkFixture, step: str) -> None:
    assert benchmark(STEPS[step]) is not None


def test_guards(benchmark: BenchmarkFixture) -> None:
    supervisor = thenar.synthesize(TOWER, "symbolic").symbolic
    assert supervisor is not None
    assert len(benchmark(lambda: thenar.guards(supervisor))) == sum(e.controllable for e in TOWER.alphabet)
