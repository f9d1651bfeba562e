"""The hand: how much faster than real time an episode runs, and what of it is the physics alone."""

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from thenar.explicit.products import sync
from thenar.hand.episode import run_episode
from thenar.hand.objects import Block
from thenar.hand.scenarios import SCENARIOS, Disturbance
from thenar.hand.world import World
from thenar.library import glr
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.synthesis.api import synthesize

ROUNDS = 5


def hand(console: Console) -> dict[str, float]:
    """CPU seconds of a nominal episode with the full sensor model, and of its physics alone, best of five."""
    problem = glr.problem()
    supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants)
    whole, physics, simulated = [], [], 0.0
    forces = _forces(supervisor, plant)
    for _ in range(ROUNDS):
        start = time.process_time()
        simulated = run_episode(supervisor, plant, block=Block(), seed=1).run.time_s
        whole.append(time.process_time() - start)
        physics.append(_physics(forces))
    figures = {
        "hand: one episode, simulated s": simulated,
        "hand: episode, times real time": simulated / min(whole),
        "hand: its physics alone, times real time": simulated / min(physics),
    }
    for what, value in figures.items():
        console.print(f"{what:<48}{value:8.2f}")
    return figures


def _forces(supervisor: Supervisor, plant: Automaton) -> list[NDArray[np.float64]]:
    """Return the motor forces of each period of the episode."""
    found: list[NDArray[np.float64]] = []

    def record() -> Disturbance:
        return lambda world, doing: found.append(world.ctrl.copy())

    watched = replace(SCENARIOS["nominal"], disturbance=record)
    run_episode(supervisor, plant, block=Block(), seed=1, scenario=watched)
    return found


def _physics(forces: list[NDArray[np.float64]]) -> float:
    """Return the CPU seconds of the same motion without sensors, hand and supervisor."""
    world = World(Block())
    start = time.process_time()
    for row in forces:
        world.ctrl[:] = row
        world.step()
    return time.process_time() - start
