"""Campaigns: many episodes with random blocks, over processes or a cluster, kept as they finish, and summed up."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from thenar.errors import InputError
from thenar.hand.campaign.cluster import cluster, connect
from thenar.hand.campaign.row import MAX_EPISODES, MAX_SEED, Lost, Row, Task, episode_seed, write_log
from thenar.hand.campaign.store import Store, read_rows
from thenar.hand.campaign.summary import summary
from thenar.hand.campaign.workers import here, processes
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.runtime.identity import identity

__all__ = ["Campaign", "Progress", "Row", "episode_seed", "read_rows", "run_campaign"]

LOGS = "logs"


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a campaign is: ``done`` of ``episodes``, ``before`` of them by an earlier call; and how it goes.

    ``lost`` is what became of the latest episode if that was not done after all.
    """

    episodes: int
    before: int
    done: int
    physical_success: int
    discrete_success: int
    lost: Lost | None = None


@dataclass(frozen=True, slots=True)
class Campaign:
    """The episodes of a campaign: its rows, and the episodes that are not done.

    ``lost`` are those that were tried in this call and whose process died, each with the reason.

    >>> Campaign(Path("here"), {"seed": "1"}, episodes=3, rows=()).missing
    (1, 2, 3)
    """

    folder: Path
    configuration: Mapping[str, str]
    episodes: int
    rows: tuple[Row, ...] = field(repr=False)
    lost: tuple[Lost, ...] = ()

    @property
    def missing(self) -> tuple[int, ...]:
        """Return the episodes that are not done."""
        done = {row.episode for row in self.rows}
        return tuple(k for k in range(1, self.episodes + 1) if k not in done)

    def to_dict(self) -> dict[str, Any]:
        """Return the summary that ``thenar campaign --json`` prints."""
        lost = [{"episode": e.episode, "why": e.why} for e in self.lost]
        configuration = {**self.configuration, "seed": int(self.configuration["seed"])}
        numbers = {**summary(self.rows), "missing": list(self.missing), "lost": lost}
        return {"configuration": configuration, "folder": str(self.folder), **numbers}


def run_campaign(
    supervisor: Supervisor,
    plant: Automaton,
    *,
    episodes: int,
    seed: int = 0,
    out: str | os.PathLike[str],
    task: str = "glr",
    variant: str = "paper",
    scenario: str = "nominal",
    sensors: str = "lab",
    policy: str = "shortest",
    hand: str = "planar",
    workers: int | None = None,
    scheduler: str | None = None,
    on_progress: Callable[[Progress], object] | None = None,
) -> Campaign:
    """Run episodes 1 .. ``episodes`` of campaign ``seed`` in folder ``out``, but for those that it already holds.

    Episode k has the seed ``seed`` · 10⁶ + k, from which come its block (unless the scenario has its own) and its
    noise; it depends on nothing else, so that the rows are the same in whatever order, place and number of calls
    they come to be (``wall_s`` apart).  ``out`` gets ``campaign.sqlite`` with a row an episode, committed as it
    finishes, and ``logs/SEED.jsonl``; each log is replayed against ``plant`` and ``supervisor`` when it is whole.
    A call that was interrupted or killed is simply made again; one with more episodes goes on.

    ``workers`` processes run the episodes, by default one a core, 0 for none but this one; with ``scheduler`` an
    existing Dask cluster does, and its logs come here.  ``task`` and ``variant`` are names for the logs.
    ``on_progress`` is called with each episode.  About a second of one core for each.

    Raises, before anything runs, InputError for a number out of range, a folder that cannot be written or that
    holds a campaign of another configuration, UnknownName for a scenario, profile, policy or hand that does not
    exist, ModelError for an event without skill or detector.  A worker process that dies raises nothing: the
    episode is ``lost`` and still missing.  KeyboardInterrupt ends the workers at once; what is finished is kept.

    >>> import tempfile
    >>> from thenar.explicit.products import sync
    >>> from thenar.library import glr
    >>> from thenar.synthesis.api import synthesize
    >>> problem = glr.problem()
    >>> supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants)
    >>> campaign = run_campaign(supervisor, plant, episodes=2, seed=1, out=tempfile.mkdtemp(), workers=0)
    >>> [(row.seed, row.outcome, row.accepted_by_supervisor) for row in campaign.rows]
    [(1000001, 'complete', True), (1000002, 'complete', True)]
    >>> campaign.to_dict()["errors"]["mu"]["rms"] < 0.01
    True
    """
    _check_numbers(episodes, seed, workers, scheduler)
    names = {"task": task, "variant": variant, "scenario": scenario, "sensors": sensors, "policy": policy}
    given = Task.of(supervisor, plant, seed=seed, hand=hand, **names)
    given.check(range(1, episodes + 1))
    configuration = {"seed": str(seed), **names, "hand": hand, **given.versions}
    configuration["supervisor"] = identity(supervisor, plant)
    n = len(os.sched_getaffinity(0)) if workers is None else workers
    with ExitStack() as opened:
        client = None if scheduler is None else opened.enter_context(closing(connect(scheduler)))
        folder = _make(Path(out))
        store = opened.enter_context(Store(folder, configuration))
        done = store.done()
        todo = [k for k in range(1, episodes + 1) if k not in done]
        rows = list(store.rows(episodes))
        before, lost = len(rows), []
        physical, discrete = sum(r.physical_success for r in rows), sum(r.discrete_success for r in rows)

        def tell(latest: Lost | None = None) -> None:
            if on_progress is not None:
                on_progress(Progress(episodes, before, len(rows), physical, discrete, latest))

        tell()
        if client is not None:
            stream = cluster(given, todo, client)
        else:
            stream = processes(given, todo, n) if n else here(given, todo)
        opened.enter_context(closing(stream))
        for found in stream:
            if isinstance(found, Lost):
                lost.append(found)
                tell(found)
                continue
            write_log(folder / LOGS, found)
            store.add(found.row)
            rows.append(found.row)
            physical += found.row.physical_success
            discrete += found.row.discrete_success
            tell()
    rows.sort(key=lambda row: row.episode)
    return Campaign(folder, configuration, episodes, tuple(rows), tuple(lost))


def _check_numbers(episodes: int, seed: int, workers: int | None, scheduler: str | None) -> None:
    if not 1 <= episodes <= MAX_EPISODES:
        raise InputError(f"a campaign has between 1 and {MAX_EPISODES:,} episodes, not {episodes:,}")
    if not 0 <= seed <= MAX_SEED:
        raise InputError(f"the seed of a campaign lies between 0 and {MAX_SEED:,}, not {seed:,}")
    if workers is not None and scheduler is not None:
        raise InputError("either workers here or a scheduler elsewhere, not both")
    if workers is not None and workers < 0:
        raise InputError(f"there cannot be {workers} workers")


def _make(folder: Path) -> Path:
    """Make the folder of a campaign, if it is not there, and the one of its logs."""
    try:
        (folder / LOGS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {error.strerror}") from None
    if not (os.access(folder, os.W_OK) and os.access(folder / LOGS, os.W_OK)):
        raise InputError(f"{folder}: cannot be written: no permission")
    return folder
