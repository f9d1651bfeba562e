"""Measure, print, and keep one JSON file a run."""

import json
import platform
import resource
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

import thenar
from bench.hand import hand
from bench.peers import TOOLS, best
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem

SIZES = [
    "small_factory(2)",
    "small_factory(4)",
    "small_factory(6)",
    "transfer_line(1)",
    "transfer_line(2)",
    "transfer_line(3)",
    "chain(4)",
    "chain(6)",
    "chain(8)",
    "dining(3)",
    "dining(5)",
    "dining(7)",
    "cat_and_mouse",
    "agv",
    "glr",
]
ENOUGH_S = 30.0  # a tool that took longer is not asked for the next size of the family
RESULTS = Path(__file__).parent / "results"


def peers(console: Console) -> list[dict[str, object]]:
    """The whole job, from the problem in memory, as CPU seconds of each tool."""
    table = Table("model", "states", *(f"{t} s" for t in TOOLS), "TCT / thenar", "libFAUDES / thenar", box=box.SIMPLE)
    rows: list[dict[str, object]] = []
    tired: set[tuple[str, str]] = set()
    for name in SIZES:
        family, problem = name.split("(")[0], thenar.library.model(name)
        seconds: dict[str, float] = {}
        states = 0
        for tool, run in TOOLS.items():
            if (tool, family) in tired:
                continue
            took, found = best(run, problem)
            states = states or found
            if found != states:
                raise SystemExit(f"{name}: {tool} finds {found} states, thenar {states}")
            seconds[tool] = took
            if took > ENOUGH_S:
                tired.add((tool, family))
        ratios = [f"{seconds[t] / seconds['thenar']:,.0f}x" if t in seconds else "-" for t in ("TCT", "libFAUDES")]
        table.add_row(name, f"{states:,}", *(f"{seconds[t]:.4f}" if t in seconds else "-" for t in TOOLS), *ratios)
        rows.append({"model": name, "states": states, "seconds": seconds})
    console.print(table)
    return rows


def toggles(n: int) -> list[Automaton]:
    return [
        Automaton.from_transitions([f"0 -up{k}-> 1 -down{k}-> 0"], initial="0", marked=["0"], name=f"T{k}")
        for k in range(n)
    ]


def kernel(console: Console) -> dict[str, float]:
    """Transitions a second, beside what the memory of this machine can do."""
    rng = np.random.default_rng(1)
    memory = np.ones(1 << 26, np.uint64)  # 512 MiB, far beyond any cache; written, so that the pages are there
    where = rng.integers(0, len(memory), 1 << 23)
    sums = []
    for _ in range(3):
        start = time.process_time()
        memory[where].sum()
        sums.append(time.process_time() - start)
    reads = len(where) / min(sums)
    del memory
    start = time.process_time()
    product = thenar.sync(*toggles(21))
    explored = product.n_transitions / (time.process_time() - start)
    problem = thenar.library.model("chain(14)")
    result = thenar.synthesize(problem)
    assert result.evidence is not None
    n = result.evidence.native.n_transitions
    figures = {
        "random reads / s": reads,
        "product of 21 toggles: transitions / s": explored,
        "chain(14): transitions explored / s": n / result.timings["explore"],
        "chain(14): transitions / s, whole synthesis": n / result.seconds,
    }
    for what, rate in figures.items():
        console.print(f"{what:<48}{rate / 1e6:8.1f} M")
    return figures


def small_things(console: Console) -> dict[str, float]:
    """The times of the main job's parts, in milliseconds of CPU."""

    def milliseconds(work: object, repeat: int = 30) -> float:
        assert callable(work)
        times = []
        for _ in range(repeat):
            start = time.process_time()
            work()
            times.append(time.process_time() - start)
        return 1000 * min(times)

    problem = thenar.library.glr.problem()
    result = thenar.synthesize(problem)
    simulation = "approach_1, approach_2, align_finger2*, prox_make_C1, unstable_contact_1, prox_breakC_1"
    blocked = Problem(
        problem.plants, [*problem.specs, _never("incip_slip*"), _never("apply_loadF*")], alphabet=problem.alphabet
    )

    def imported() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", "import thenar"], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return 1000 * (after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime)

    figures = {
        "import thenar": min(imported() for _ in range(5)),
        "GLR: synthesis": milliseconds(lambda: thenar.synthesize(problem)),
        "GLR: one explanation": milliseconds(lambda: thenar.explain_disabled(result, "approach_1", after=simulation)),
        "GLR: certificate": milliseconds(lambda: thenar.certificate(result), 3),
        "GLR made impossible: synthesis": milliseconds(lambda: thenar.synthesize(blocked)),
        "GLR made impossible: reason": milliseconds(lambda: thenar.explain_empty(thenar.synthesize(blocked))),
    }
    for what, ms in figures.items():
        console.print(f"{what:<48}{ms:8.2f} ms")
    return figures


def _never(event: str) -> Automaton:
    alphabet = thenar.library.glr.EVENTS
    return Automaton.from_transitions(
        [], initial="q", marked=[], events=alphabet, alphabet=[event], name=f"NEVER_{event}"
    )


def main() -> None:
    console = Console(width=130 if not sys.stdout.isatty() else None)
    where = f"Python {platform.python_version()}, {platform.machine()}"
    console.print(f"thenar {thenar.__version__}, {where}; CPU seconds, best of several runs")
    run = {
        "kernel": kernel(console),
        "milliseconds": small_things(console),
        "hand": hand(console),
        "peers": peers(console),
    }
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"{datetime.now(UTC):%Y-%m-%dT%H%M%S}.json"
    path.write_text(json.dumps(run, indent=2))
    console.print(f"\nwritten to {path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path}")


if __name__ == "__main__":
    main()
