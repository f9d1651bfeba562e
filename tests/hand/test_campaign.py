"""Campaigns: nothing is run twice, nothing is lost, and the numbers are those of the rows."""

import math
import re
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from thenar import library
from thenar.errors import InputError, ModelError, UnknownName
from thenar.explicit.products import sync
from thenar.hand.campaign import Campaign, Progress, Row, read_rows, run_campaign, workers
from thenar.synthesis.api import synthesize

N = 4
COMMAND = "from thenar.cli.campaign import campaign; campaign()"
Run = Callable[..., Campaign]


@pytest.fixture(scope="module")
def run() -> Run:
    """Run a campaign of the paper's task."""
    problem = library.glr.problem()
    supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants, name="G")
    return lambda out, **options: run_campaign(supervisor, plant, out=out, **{"episodes": N, "seed": 3, **options})


@pytest.fixture(scope="module")
def whole(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """A campaign that nothing interrupted, in one process."""
    return run(tmp_path_factory.mktemp("whole"), workers=0)


def timeless(rows: tuple[Row, ...]) -> list[Row]:
    return [replace(row, wall_s=0.0) for row in rows]


def same(one: Campaign, other: Campaign) -> bool:
    logs = [{p.name: p.read_bytes() for p in (c.folder / "logs").iterdir()} for c in (one, other)]
    return timeless(one.rows) == timeless(other.rows) and logs[0] == logs[1]


def command(out: Path, *options: str) -> subprocess.Popen[str]:
    arguments = ["glr", "--episodes", str(N), "--seed", "3", "--out", str(out), *options]
    return subprocess.Popen([sys.executable, "-c", COMMAND, *arguments], stderr=subprocess.PIPE, text=True)


def wait_for_rows(out: Path, n: int) -> None:
    for _ in range(3000):
        if (out / "campaign.sqlite").exists() and len(list((out / "logs").glob("*.jsonl"))) >= n:
            return
        time.sleep(0.01)
    raise TimeoutError


def children(pid: int) -> list[int]:
    return [int(c) for c in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def test_a_killed_campaign_goes_on_where_it_stopped(run: Run, whole: Campaign, tmp_path: Path) -> None:
    process = command(tmp_path, "--workers", "2")
    wait_for_rows(tmp_path, 2)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    before = read_rows(tmp_path / "campaign.sqlite")
    assert 1 <= len(before) < N  # of two logs at least one has its row
    seen: list[Progress] = []
    resumed = run(tmp_path, workers=2, on_progress=seen.append)
    assert [p.done for p in seen] == list(range(len(before), N + 1))
    assert set(before) <= set(resumed.rows)  # wall_s and all: not run again
    assert same(resumed, whole)


def test_an_interrupted_campaign_ends_its_workers_and_says_how_to_go_on(tmp_path: Path) -> None:
    process = command(tmp_path, "--workers", "2")
    wait_for_rows(tmp_path, 2)
    workers = children(process.pid)
    begun = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert time.monotonic() - begun < 1.0
    done = len(read_rows(tmp_path / "campaign.sqlite"))
    assert process.returncode == 130
    assert f"{done} of {N} episodes are done and kept in {tmp_path}; the same command goes on" in errors
    assert len(workers) == 2
    assert not any(Path(f"/proc/{pid}").exists() for pid in workers)


def test_a_worker_that_dies_takes_one_episode_with_it(
    run: Run, whole: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    give = workers._Worker.give

    def deadly(worker: Any, episode: int) -> None:
        give(worker, episode)
        if episode == 1:
            worker.process.kill()

    with monkeypatch.context() as patch:
        patch.setattr(workers._Worker, "give", deadly)
        found = run(tmp_path, workers=1, episodes=2)
    assert [(e.episode, e.why) for e in found.lost] == [(1, "its process was killed by SIGKILL (out of memory?)")]
    assert found.missing == (1,)
    again = run(tmp_path, workers=0, episodes=2)
    assert timeless(again.rows) == timeless(whole.rows[:2])


def test_workers_that_all_die_end_the_campaign(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/false")
    found = run(tmp_path, workers=1, episodes=50)
    assert [e.why for e in found.lost] == ["its process ended with exit code 1"] * 3
    assert len(found.missing) == 50


def test_more_episodes_extend_a_campaign_and_fewer_are_its_beginning(run: Run, whole: Campaign, tmp_path: Path) -> None:
    first = run(tmp_path, workers=0, episodes=1)
    second = run(tmp_path, workers=0, episodes=2)
    assert second.rows[0] == first.rows[0]
    assert timeless(second.rows) == timeless(whole.rows[:2])
    assert run(tmp_path, workers=0, episodes=1).rows == first.rows


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sensors": "rough"}, "sensors is lab there, rough here; choose another folder"),
        ({"seed": 4, "variant": "other"}, "seed is 3 there, 4 here; variant is paper there, other here"),
    ],
)
def test_another_configuration_is_refused(run: Run, whole: Campaign, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        run(whole.folder, workers=0, **options)


def test_two_campaigns_at_once_are_refused(run: Run, whole: Campaign) -> None:
    def second(now: Progress) -> None:
        with pytest.raises(InputError, match="another process is running a campaign there"):
            run(whole.folder, workers=0)

    run(whole.folder, workers=0, on_progress=second)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"episodes": 0}, InputError, "between 1 and 1,000,000 episodes, not 0"),
        ({"seed": -1}, InputError, "not -1"),
        ({"workers": -1}, InputError, "-1 workers"),
        ({"workers": 1, "scheduler": "tcp://nowhere:1"}, InputError, "not both"),
        ({"scenario": "nominall"}, UnknownName, "did you mean 'nominal'"),
        ({"sensors": "labb"}, UnknownName, "did you mean 'lab'"),
        ({"policy": "shortets"}, UnknownName, "did you mean 'shortest'"),
        ({"policy": "operator"}, InputError, "nobody to ask"),
        ({"hand": "plannar"}, UnknownName, "did you mean 'planar'"),
    ],
)
def test_bad_input_is_refused_before_anything_is_made(
    run: Run, tmp_path: Path, options: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        run(tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_a_model_without_skills_is_refused(tmp_path: Path) -> None:
    problem = library.model("agv")
    with pytest.raises(ModelError, match="no skill for it"):
        run_campaign(synthesize(problem).supervisor, sync(*problem.plants), episodes=1, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_none_and_a_file_of_something_else_are_refused(run: Run, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be made a folder"):
        run(tmp_path / "file")
    (tmp_path / "campaign.sqlite").write_text("no database at all, but long enough to be taken for one" * 20)
    with pytest.raises(InputError, match="not a database"):
        run(tmp_path)


def test_the_summary_is_what_the_rows_say(whole: Campaign) -> None:
    found = whole.to_dict()
    db = sqlite3.connect(whole.folder / "campaign.sqlite")
    rows = db.execute("SELECT mu / mu_truth - 1, weight_n_paper / weight_n_truth - 1, sim_s FROM episodes").fetchall()
    of_lift_off = "json_each(latency_ms) AS k, json_each(k.value) AS v WHERE k.key = 'remote_breakC*'"
    late = [ms for (ms,) in db.execute(f"SELECT v.value FROM episodes, {of_lift_off}")]
    (accepted,) = db.execute("SELECT sum(accepted_by_plant AND accepted_by_supervisor) FROM episodes").fetchone()
    db.close()
    mu, weight = [r[0] for r in rows], [r[1] for r in rows if r[1] is not None]
    assert found["episodes"] == N
    assert found["errors"]["mu"]["rms"] == pytest.approx(math.sqrt(sum(x * x for x in mu) / N))
    assert found["errors"]["mu"]["max"] == pytest.approx(max(abs(x) for x in mu))
    assert found["errors"]["weight_n_paper"]["mean"] == pytest.approx(sum(weight) / len(weight))
    assert found["latency_ms"]["remote_breakC*"]["mean"] == pytest.approx(sum(late) / len(late))
    assert found["latency_ms"]["remote_breakC*"]["max"] == max(late)
    assert found["sim_s"] == pytest.approx(sum(r[2] for r in rows))
    assert found["accepted_by_plant"] == found["accepted_by_supervisor"] == accepted == N
    assert found["missing"] == []


def test_disagreements_and_failures_are_listed_by_seed(whole: Campaign) -> None:
    rows = (replace(whole.rows[0], physical_success=False, dropped=True), *whole.rows[1:])
    found = replace(whole, rows=rows).to_dict()
    assert found["disagreements"] == [3_000_001]
    assert [(f["seed"], f["physically"]) for f in found["failures"]] == [(3_000_001, "dropped")]
    assert found["physical_success"] == N - 1


def test_a_missing_dask_says_how_to_get_it(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=re.escape("pip install 'thenar[cluster]'")):
        run(tmp_path / "out", scheduler="tcp://127.0.0.1:8786")
    assert not (tmp_path / "out").exists()


def test_a_dask_cluster_finds_the_same(run: Run, whole: Campaign, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="pip install 'thenar[cluster]'")
    # two threads in one worker: they share the plan
    with distributed.LocalCluster(1, threads_per_worker=2, processes=False, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        found = run(tmp_path, episodes=2, scheduler=address)
    assert timeless(found.rows) == timeless(whole.rows[:2])
