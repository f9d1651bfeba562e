"""How a campaign scales with its workers: ``python -m bench.campaign``."""

import os
import resource
import tempfile
import time
from statistics import median

from rich import box
from rich.console import Console
from rich.table import Table

from thenar.explicit.products import sync
from thenar.hand.campaign import run_campaign
from thenar.library import glr
from thenar.synthesis.api import synthesize

EPISODES = 12
REPEATS = 3


def once(workers: int) -> tuple[float, float]:
    """Wall and CPU seconds of a campaign, the start of its workers included."""
    problem = glr.problem()
    supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants)
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    with tempfile.TemporaryDirectory() as out:
        found = run_campaign(supervisor, plant, episodes=EPISODES, seed=1, out=out, workers=workers)
    if found.missing:
        raise SystemExit(f"not done: {found.lost}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.perf_counter() - begun, cpu_s


def scaling(console: Console) -> list[dict[str, float]]:
    """1, 2, 4, ... workers in turn, so that what else the machine does hits all alike; medians."""
    cores = len(os.sched_getaffinity(0))
    counts = [1 << k for k in range(cores.bit_length()) if 1 << k <= cores]
    runs: dict[int, list[tuple[float, float]]] = {workers: [] for workers in counts}
    for _ in range(REPEATS):
        for workers in counts:
            runs[workers].append(once(workers))
    table = Table("workers", "wall s", "CPU s", "episodes/s", "speed-up", "cores got", box=box.SIMPLE)
    rows: list[dict[str, float]] = []
    alone = median(wall for wall, _ in runs[1])
    for workers, found in runs.items():
        wall, cpu = median(w for w, _ in found), median(c for _, c in found)
        numbers = {"wall_s": wall, "cpu_s": cpu, "episodes_per_s": EPISODES / wall, "speed_up": alone / wall}
        table.add_row(str(workers), *(f"{n:.2f}" for n in numbers.values()), f"{cpu / wall:.2f}")
        rows.append({"workers": workers, **numbers})
    console.print(table)
    return rows


if __name__ == "__main__":
    scaling(Console())
