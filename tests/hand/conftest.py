"""The two variants of the task, synthesised once, and episodes run once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest

from thenar.explicit.products import sync
from thenar.hand.episode import Episode, run_episode
from thenar.hand.scenarios import SCENARIOS
from thenar.library import glr
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.synthesis.api import synthesize


@cache
def loop(variant: str) -> tuple[Supervisor, Automaton]:
    problem = glr.problem(variant)
    return synthesize(problem).supervisor, sync(*problem.plants)


@cache
def _episode(variant: str, scenario: str, seed: int) -> Episode:
    return run_episode(*loop(variant), scenario=SCENARIOS[scenario], seed=seed)


@pytest.fixture(scope="session")
def closed_loop() -> Callable[[str], tuple[Supervisor, Automaton]]:
    """S and G of a variant."""
    return loop


@pytest.fixture(scope="session")
def episode() -> Callable[..., Episode]:
    """An episode by variant, scenario and seed; each is run once in a session."""

    def run(variant: str = "paper", scenario: str = "nominal", seed: int = 1) -> Episode:
        return _episode(variant, scenario, seed)

    return run


Loop = Callable[[str], tuple[Supervisor, Automaton]]
Run = Callable[..., Any]
