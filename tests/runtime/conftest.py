"""The paper's task with a driver that has no physics, as the tests of the runtime run it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from random import Random
from typing import Any

import pytest
from tests.runtime.fake import FakeDriver, Tamper, skills_for

from thenar.explicit.products import sync
from thenar.library import glr
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.runtime.driver import Detector
from thenar.runtime.executor import execute
from thenar.runtime.plan import Shortest
from thenar.runtime.run import Run
from thenar.synthesis.api import synthesize

GOALS = ("dec_gripF*", "stiffness_EP*")


@dataclass(frozen=True)
class Task:
    supervisor: Supervisor
    plant: Automaton

    def driver(
        self, seed: int = 0, *, slip: float = 0.01, other: float = 0.0, tamper: Tamper | None = None
    ) -> FakeDriver:
        """A hand on which the object slips when the grip is decreased, and other things happen as ``other`` says."""
        alphabet = self.supervisor.automaton.alphabet

        def chance(event: str, state: str) -> float:
            return slip if event == "incip_slip*" and "grip_decreased" in state else other

        detectors = {
            e.name: Detector(e.name, 0.3 if e.name == "incip_slip*" else 0.05, 0.6, 5.0)
            for e in alphabet
            if not e.controllable
        }
        skills = skills_for(alphabet, expected_s=0.05, limit_s=0.3)
        rng = Random(seed)
        return FakeDriver(self.plant, alphabet, rng, skills=skills, detectors=detectors, chance=chance, tamper=tamper)

    def run(self, driver: FakeDriver, **options: Any) -> Run:
        policy = options.pop("policy", None) or Shortest(self.supervisor, driver, through=GOALS)
        return execute(self.supervisor, self.plant, driver, policy, through=options.pop("through", GOALS), **options)


@pytest.fixture(scope="session")
def task() -> Task:
    problem = glr.problem()
    return Task(synthesize(problem).supervisor, sync(*problem.plants, name="G"))


@pytest.fixture
def replaced(task: Task) -> Callable[[Automaton], Task]:
    def with_spec(spec: Automaton) -> Task:
        problem = glr.problem()
        more = type(problem)(problem.plants, [*problem.specs, spec], alphabet=problem.alphabet)
        return Task(synthesize(more).supervisor, task.plant)

    return with_spec
