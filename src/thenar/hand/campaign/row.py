"""One episode of a campaign: what it is given, what is kept of it, and how the one becomes the other."""

from __future__ import annotations

import copy
import hashlib
import json
import math
import os
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from thenar import hand, runtime
from thenar.errors import InputError
from thenar.hand.episode import PROCEDURES, Episode, block_of, log_header, make_driver, run_episode
from thenar.hand.estimates import Estimate
from thenar.hand.hands import hand_named
from thenar.hand.objects import Block
from thenar.hand.scenarios import scenario
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.runtime.binding import check_binding
from thenar.runtime.policy import Policy, policy_named
from thenar.runtime.record import LogWriter, read_log
from thenar.runtime.replay import Replay, replay

__all__ = ["MAX_EPISODES", "MAX_SEED", "Finished", "Lost", "Row", "Task", "episode_seed", "run_task", "versions"]

MAX_EPISODES = 1_000_000
MAX_SEED = 10**9
WITHOUT_MEMORY = ("shortest", "priority")  # policies that are made once: nothing of them depends on the episode's seed


def episode_seed(seed: int, episode: int) -> int:
    """Return the seed of episode 1, 2, 3, ... of the campaign ``seed``: no two campaigns share one.

    The block and the noise come from it alone: ``thenar run glr --seed 1000017`` is episode 17 of campaign 1.

    >>> episode_seed(1, 17)
    1000017
    """
    return seed * MAX_EPISODES + episode


@dataclass(frozen=True, slots=True)
class Row:
    """What is kept of an episode: a row of the table ``episodes``, a field a column.

    * ``..._truth`` is the block's, ``..._error`` is estimate / truth - 1, ``..._paper`` are the paper's own formulas;
      None where nothing was estimated
    * ``latency_ms`` (event -> each delay) and ``violations`` (a list) are JSON, ``trace`` has commas between its events
    * ``differences`` counts what the log records other than the replay finds it, ``executed_while_disabled`` the
      controllable events by which the log leaves S/G
    """

    episode: int
    seed: int
    outcome: str
    message: str
    discrete_success: bool
    physical_success: bool
    lifted: bool
    replaced: bool
    dropped: bool
    accepted_by_plant: bool
    accepted_by_supervisor: bool
    differences: int
    executed_while_disabled: int
    violations: str
    mass_kg: float
    stiffness_1_n_per_m: float
    stiffness_2_n_per_m: float
    x_m: float
    face_tilt_rad: float
    table_height_m: float
    mu_truth: float
    mu: float | None
    mu_uncertainty: float | None
    mu_error: float | None
    mu_paper: float | None
    mu_paper_error: float | None
    weight_n_truth: float
    weight_n: float | None
    weight_n_uncertainty: float | None
    weight_n_error: float | None
    weight_n_paper: float | None
    weight_n_paper_error: float | None
    stiffness_n_per_m_truth: float
    stiffness_n_per_m: float | None
    stiffness_n_per_m_uncertainty: float | None
    stiffness_n_per_m_error: float | None
    stiffness_n_per_m_paper: float | None
    stiffness_n_per_m_paper_error: float | None
    latency_ms: str
    slip_before_detection_mm: float
    lift_error_mm: float | None
    replace_error_mm: float
    sim_s: float
    wall_s: float
    trace: str

    @property
    def latencies_ms(self) -> dict[str, list[float]]:
        """Event -> how long after it happened it was reported, each time."""
        found: dict[str, list[float]] = json.loads(self.latency_ms)
        return found

    @property
    def disagrees(self) -> bool:
        """Whether the events say another thing than the physics."""
        return self.discrete_success != self.physical_success


@dataclass(frozen=True, slots=True)
class Finished:
    """An episode that ran to its end, whatever that was; ``log`` is its log as it was written."""

    row: Row
    log: bytes


@dataclass(frozen=True, slots=True)
class Lost:
    """An episode that is not done, through no fault of the hand: its process died, or the program is wrong."""

    episode: int
    why: str


@dataclass(frozen=True, slots=True)
class Task:
    """What all episodes of a campaign have in common; checked, planned and pickled once.

    ``plan`` is the policy where one serves all episodes, None where each needs its own.
    """

    supervisor: Supervisor
    plant: Automaton
    task: str
    variant: str
    seed: int
    scenario: str
    sensors: str
    policy: str
    hand: str
    plan: Policy | None
    versions: Mapping[str, str]

    @classmethod
    def of(cls, supervisor: Supervisor, plant: Automaton, **names: Any) -> Task:
        """Check everything that every episode would fail for; plan."""
        if supervisor.is_empty:
            raise InputError("there is nothing to run: no supervisor exists for this problem")
        if names["policy"].strip().startswith("operator"):
            raise InputError("a campaign has nobody to ask; choose another policy than 'operator'")
        what = scenario(names["scenario"])
        driver = make_driver(supervisor, what.block or Block(), what, sensors=names["sensors"], hand=names["hand"])
        alphabet = supervisor.automaton.alphabet
        check_binding(alphabet, driver)
        goals = [event for event in PROCEDURES if event in alphabet]
        policy = policy_named(names["policy"], supervisor, driver, through=goals)
        plan = policy if policy.name in WITHOUT_MEMORY else None
        return cls(supervisor, plant, plan=plan, versions=versions(), **names)

    def check(self, episodes: Iterable[int]) -> None:
        """Raise InputError if the hand cannot take the block of one of ``episodes``."""
        what, built = scenario(self.scenario), hand_named(self.hand)
        for block in {block_of(what, episode_seed(self.seed, k)): None for k in episodes}:
            built.check(block, what.setup)


@cache
def versions() -> dict[str, str]:
    """Return the versions of everything that the numbers of an episode depend on.

    The sources of hand and runtime count too: what is being worked on changes without a new version number.
    """
    digest = hashlib.sha256()
    for package in (hand, runtime):
        for file in sorted(Path(package.__path__[0]).glob("*.py")):
            digest.update(file.read_bytes())
    numbers = {name: version(name) for name in ("thenar", "mujoco", "numpy")}
    return {**numbers, "thenar_source": digest.hexdigest()[:12]}


def run_task(task: Task, episode: int) -> Finished:
    """Run an episode, and check its log by replay against G and S/G; about a second.

    Raises InputError where another version is installed than where the campaign was started.
    """
    here = versions()
    if other := [f"{n} {here[n]}, not {wanted}" for n, wanted in task.versions.items() if here[n] != wanted]:
        raise InputError(f"a worker has {'; '.join(other)}: thenar changed after the campaign began; begin it anew")
    seed = episode_seed(task.seed, episode)
    first = log_header(
        task.supervisor,
        task.plant,
        task.task,
        variant=task.variant,
        seed=seed,
        scenario=task.scenario,
        sensors=task.sensors,
        policy=task.policy,
        hand=task.hand,
    )
    with tempfile.TemporaryDirectory(prefix="thenar-") as folder:
        path = Path(folder, "log.jsonl")
        with LogWriter(path, first) as log:
            found = run_episode(
                task.supervisor,
                task.plant,
                scenario=scenario(task.scenario),
                sensors=task.sensors,
                policy=task.policy if task.plan is None else copy.copy(task.plan),  # threads may share the plan
                seed=seed,
                hand=task.hand,
                log=log,
            )
        replayed = replay(read_log(path), task.supervisor, task.plant)
        return Finished(_row(episode, found, replayed, task), path.read_bytes())


def _row(episode: int, found: Episode, replayed: Replay, task: Task) -> Row:
    block, score, e, run = found.block, found.score, found.estimates, found.run
    return Row(
        episode=episode,
        seed=found.seed,
        outcome=run.outcome,
        message=run.message,
        discrete_success=found.discrete_success,
        physical_success=score.physical_success,
        lifted=score.lifted,
        replaced=score.replaced,
        dropped=score.dropped,
        accepted_by_plant=bool(replayed.accepted_by_plant),
        accepted_by_supervisor=bool(replayed.accepted_by_supervisor),
        differences=len(replayed.differences),
        executed_while_disabled=_disabled(replayed, task.supervisor),
        violations=json.dumps(list(run.violations), ensure_ascii=False),
        mass_kg=block.mass_kg,
        stiffness_1_n_per_m=block.stiffness_1_n_per_m,
        stiffness_2_n_per_m=block.stiffness_2_n_per_m,
        x_m=block.x_m,
        face_tilt_rad=block.face_tilt_rad,
        table_height_m=block.table_height_m,
        **_estimate("mu", e.mu, e.mu_paper, block.mu),
        **_estimate("weight_n", e.weight_n, e.weight_paper_n, block.weight_n),
        **_estimate("stiffness_n_per_m", e.stiffness_n_per_m, e.stiffness_paper_n_per_m, block.stiffness_n_per_m),
        latency_ms=json.dumps(score.latency_ms),
        slip_before_detection_mm=1e3 * score.slip_before_detection_m,
        lift_error_mm=None if score.lift_error_m is None else 1e3 * score.lift_error_m,
        replace_error_mm=1e3 * score.replace_error_m,
        sim_s=run.time_s,
        wall_s=found.wall_s,
        trace=str(run.trace),
    )


def _estimate(name: str, found: Estimate | None, paper: float | None, truth: float) -> dict[str, Any]:
    """Return the columns of one quantity."""
    value = None if found is None else found.value
    return {
        f"{name}_truth": truth,
        name: value,
        f"{name}_uncertainty": found.uncertainty if found is not None and math.isfinite(found.uncertainty) else None,
        f"{name}_error": None if value is None else value / truth - 1,
        f"{name}_paper": paper,
        f"{name}_paper_error": None if paper is None else paper / truth - 1,
    }


def _disabled(replayed: Replay, supervisor: Supervisor) -> int:
    """Return 1 if the log leaves S/G by a controllable event; what comes after has no meaning any more."""
    witness, alphabet = replayed.accepted_by_supervisor.witness, supervisor.automaton.alphabet
    if not witness:
        return 0
    last = witness[-1]
    return int(last in alphabet and alphabet[last].controllable)


def write_log(folder: Path, found: Finished) -> None:
    """Write the log of an episode; a kill leaves no row without its whole log."""
    path = folder / f"{found.row.seed}.jsonl"
    half = folder / f".{found.row.seed}.tmp"
    try:
        half.write_bytes(found.log)
        os.replace(half, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
