"""One episode: a block in the grasp of a supervised hand, from start to end, with its score."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thenar.hand import scoring
from thenar.hand.driver import COMMANDS, HandDriver
from thenar.hand.estimates import Estimates
from thenar.hand.faults import Fault, FaultyDriver, FaultySensors
from thenar.hand.hand import Hand
from thenar.hand.hands import hand_named
from thenar.hand.objects import Block
from thenar.hand.scenarios import SCENARIOS, Scenario
from thenar.hand.sensing import SensorModel, profile
from thenar.hand.world import CHANNELS, World
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.runtime.clock import Clock
from thenar.runtime.executor import execute
from thenar.runtime.identity import identity
from thenar.runtime.policy import Policy, policy_named
from thenar.runtime.record import Entry, Sink, header
from thenar.runtime.run import Run

__all__ = ["PROCEDURES", "Episode", "block_of", "log_header", "make_driver", "run_episode"]

PROCEDURES = ("dec_gripF*", "stiffness_EP*", "remote_makeC*")
"""What a run is to go through, in any order that the supervisor allows: both procedures, and the way back down."""


@dataclass(frozen=True, slots=True)
class Episode:
    """What came of an episode: the run as the supervisor saw it, what the hand found out, and what really happened.

    ``recording``: (n, 32) float64, a row a millisecond: the sensor channels, then the commands; ``channels`` names
    the columns.  ``truth`` belongs to the score; no part of the hand ever saw it.

    >>> Episode.channels[:2], Episode.channels[-1]
    (('force_x_1', 'force_z_1'), 'slip_fraction')
    """

    run: Run
    block: Block
    estimates: Estimates
    score: scoring.Score
    truth: scoring.Truth
    recording: NDArray[np.float64]
    world: World
    seed: int
    wall_s: float

    channels = (*CHANNELS, *COMMANDS)

    @property
    def discrete_success(self) -> bool:
        """Whether the run ended in a marked state with the procedures done."""
        return self.run.discrete_success

    @property
    def physical_success(self) -> bool:
        """Whether the block was lifted to within 1 mm, replaced within 2 mm, and never dropped."""
        return self.score.physical_success

    def to_dict(self) -> dict[str, Any]:
        """Return the summary that ``thenar run --json`` prints."""
        e, block = self.estimates, self.block
        pairs = {"mu": e.mu, "weight_n": e.weight_n, "stiffness_n_per_m": e.stiffness_n_per_m}
        latency = self.score.latency_ms
        return {
            "discrete_success": self.discrete_success,
            "physical_success": self.physical_success,
            "outcome": self.run.outcome,
            "message": self.run.message,
            "trace": list(self.run.trace),
            "estimates": {name: None if found is None else found.value for name, found in pairs.items()},
            "uncertainties": {name: None if found is None else found.uncertainty for name, found in pairs.items()},
            "paper_estimates": {
                "mu": e.mu_paper,
                "weight_n": e.weight_paper_n,
                "stiffness_n_per_m": e.stiffness_paper_n_per_m,
            },
            "truth": {
                "mu": block.mu,
                "weight_n": block.weight_n,
                "stiffness_n_per_m": block.stiffness_n_per_m,
            },
            "block": asdict(block),
            "latency_ms": {event: sum(values) / len(values) for event, values in latency.items()},
            "early_slips": self.score.early_slips,
            "slip_before_detection_mm": 1e3 * self.score.slip_before_detection_m,
            "lift_error_mm": None if self.score.lift_error_m is None else 1e3 * self.score.lift_error_m,
            "replace_error_mm": 1e3 * self.score.replace_error_m,
            "dropped": self.score.dropped,
            "violations": list(self.run.violations),
            "sim_s": self.run.time_s,
            "wall_s": self.wall_s,
            "seed": self.seed,
        }


def block_of(scenario: Scenario, seed: int) -> Block:
    """Return the scenario's block, or, where it has none of its own, the random one of ``seed``."""
    return scenario.block or Block.random(random.Random(seed))


def log_header(
    supervisor: Supervisor,
    plant: Automaton,
    task: str,
    *,
    variant: str,
    seed: int,
    scenario: str,
    sensors: str,
    policy: str,
    hand: str,
    fault: str = "",
    **own: float,
) -> Entry:
    """Return the first line of an episode's log; ``own`` is what was said of the block."""
    return header(
        task,
        variant=variant,
        seed=seed,
        events=supervisor.automaton.alphabet.names,
        scenario=scenario,
        sensors=sensors,
        policy=policy,
        hand=hand,
        fault=fault,
        **own,
        supervisor=identity(supervisor, plant),
        thenar=version("thenar"),
    )


def make_driver(
    supervisor: Supervisor,
    block: Block,
    scenario: Scenario,
    *,
    sensors: str,
    hand: str,
    seed: int = 0,
    fault: Fault | None = None,
) -> HandDriver:
    """Return a hand around ``block``, ready to be driven; raises as :func:`run_episode` does."""
    built, quality = hand_named(hand), profile(sensors)
    built.check(block, scenario.setup)
    broken = fault is not None and fault.kind == "nan"
    model = FaultySensors(quality, seed, fault.part) if fault is not None and broken else SensorModel(quality, seed)
    events = frozenset(supervisor.automaton.alphabet.names)
    brain = Hand(scenario.setup, built.compression_m, events, built.world.geometry)
    world = scenario.world(block, built.world)
    disturbance = scenario.disturbance() if scenario.disturbance else None
    if fault is None or broken:
        return HandDriver(world, model, brain, disturbance)
    return FaultyDriver(world, model, brain, disturbance, fault)


def run_episode(
    supervisor: Supervisor,
    plant: Automaton,
    *,
    block: Block | None = None,
    scenario: Scenario = SCENARIOS["nominal"],
    sensors: str = "lab",
    policy: str | Policy = "shortest",
    seed: int = 0,
    hand: str = "planar",
    fault: Fault | None = None,
    clock: Clock | None = None,
    log: Sink | None = None,
    on_entry: Callable[[Entry], object] | None = None,
    on_tick: Callable[[float, str | None, str | None], object] | None = None,
    through: Sequence[str] = PROCEDURES,
) -> Episode:
    """Run ``supervisor`` on the simulated hand; ``plant`` is the product of the problem's plants.

    The hand does what the supervisor allows and ``policy`` chooses, whatever the supervisor; ``block`` defaults to
    the scenario's, or to the random one of ``seed``.  The same arguments give the same log, byte for byte.
    About 0.8 s of one core for an episode of 14 s.

    Raises UnknownName for a profile, policy or hand that does not exist, ModelError if an event of the
    supervisor has no skill or no detector, before anything moves.

    >>> from thenar.explicit.products import sync
    >>> from thenar.library import glr
    >>> from thenar.synthesis.api import synthesize
    >>> problem = glr.problem()
    >>> episode = run_episode(synthesize(problem).supervisor, sync(*problem.plants), block=Block(mu=0.5), seed=1)
    >>> episode.discrete_success, episode.physical_success, round(episode.estimates.mu.value, 2)
    (True, True, 0.5)
    """
    block = block or block_of(scenario, seed)
    driver = make_driver(supervisor, block, scenario, sensors=sensors, hand=hand, seed=seed, fault=fault)
    events = supervisor.automaton.alphabet
    goals = [event for event in through if event in events]
    chosen = policy_named(policy, supervisor, driver, seed=seed, through=goals) if isinstance(policy, str) else policy
    driver.tick()  # the sensors have been read once before anything is decided
    begun = time.perf_counter()
    run = execute(
        supervisor, plant, driver, chosen, through=goals, clock=clock, log=log, on_entry=on_entry, on_tick=on_tick
    )
    wall_s = time.perf_counter() - begun
    truth = scoring.truth(driver.world)
    found = scoring.score(run, truth)
    return Episode(run, block, driver.hand.estimates, found, truth, driver.recording, driver.world, seed, wall_s)
