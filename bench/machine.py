"""Exploration beside what the memory of this machine can do: ``python -m bench.machine [product ...]``.

Each product is explored in a process of its own, in turn with independent random reads over 256 MiB, so that what else
the machine does hits both alike; the best run of each counts.
"""

import json
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

import thenar
from thenar._native import kernel
from thenar.explicit.exploration import Exploration, ticker
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem

PRODUCTS = [
    "toggles(22)",
    "transfer_line(4)",
    "chain(14)",
    "toggles(24)",
    "small_factory(12)",
    "chain(15)",
    "dining(18)",
    "chain(16)",
    "toggles(26)",
]
TABLE_WORDS = 1 << 25  # 256 MiB, beyond any cache
READS = 1 << 26
REPEATS = 3


def toggles(n: int) -> list[Automaton]:
    """n independent two-state automata: 2ⁿ states, n transitions from each."""
    return [
        Automaton.from_transitions([f"0 -up{k}-> 1 -down{k}-> 0"], initial="0", marked=["0"], name=f"T{k}")
        for k in range(n)
    ]


def product(name: str) -> Problem:
    """Return the problem of a name such as ``toggles(22)`` or ``chain(14)``."""
    return Problem(toggles(int(name[8:-1])), []) if name.startswith("toggles(") else thenar.library.model(name)


def random_reads() -> float:
    """Independent random 8-byte reads a second: by a compiled loop or NumPy's gather, whichever is quicker."""
    compiled = kernel.random_reads(TABLE_WORDS, READS, ticker())
    table = np.ones(TABLE_WORDS, np.uint64)
    where = np.random.default_rng(1).integers(0, TABLE_WORDS, READS >> 3)
    start = time.perf_counter()
    table[where].sum()
    return max(compiled, len(where) / (time.perf_counter() - start))


def measure(name: str) -> dict[str, float]:
    """Explore one product a few times; rates in the wall's seconds, memory of the first run."""
    problem = product(name)

    def explore() -> tuple[Exploration, float]:
        start = time.perf_counter()
        found = Exploration(problem.plants, problem.specs, problem.alphabet, ticker())
        return found, time.perf_counter() - start

    before = _peak_bytes()
    found, seconds = explore()
    peak = _peak_bytes() - before
    states, transitions, held = found.n_states, found.native.n_transitions, found.native.bytes
    del found
    times, reads = [seconds], []
    for _ in range(REPEATS):
        reads.append(random_reads())
        # A virtual machine may have to ask its host for memory, which costs more than to use it: be given it first.
        kernel.stream(max(peak, 1 << 20) >> 3, ticker())
        times.append(explore()[1])
    rate, bound = transitions / min(times), max(reads)
    return {
        "states": states,
        "transitions": transitions,
        "transitions_per_s": rate,
        "random_reads_per_s": bound,
        "ratio": rate / bound,
        "held_bytes_per_transition": held / transitions,
        "peak_bytes_per_transition": peak / transitions,
    }


def _peak_bytes() -> int:
    """Return the most memory that this process has had; on Linux the system's own figure still counts its parent's."""
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def machine(console: Console, names: list[str]) -> dict[str, dict[str, float]]:
    """Print a table of all products, with the rates in millions a second."""
    touch, read = max(kernel.stream(TABLE_WORDS, ticker()) for _ in range(3))
    console.print(f"stream: {read / 1e9:.1f} GB/s read, {touch / 1e9:.1f} GB/s written to fresh memory")
    heads = ("product", "states", "transitions", "M transitions/s", "M random reads/s", "ratio", "B held", "B peak")
    table = Table(*heads, box=box.SIMPLE, caption="B: bytes a stored transition, all else that is kept included")
    found = {}
    for name in names:
        command = [sys.executable, "-m", "bench.machine", "--json", name]
        root = Path(__file__).parents[1]
        row = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, cwd=root).stdout)
        found[name] = row
        table.add_row(
            name,
            f"{row['states']:,}",
            f"{row['transitions']:,}",
            f"{row['transitions_per_s'] / 1e6:.1f}",
            f"{row['random_reads_per_s'] / 1e6:.1f}",
            f"{row['ratio']:.2f}",
            f"{row['held_bytes_per_transition']:.2f}",
            f"{row['peak_bytes_per_transition']:.2f}",
        )
    console.print(table)
    return found


if __name__ == "__main__":
    if sys.argv[1:2] == ["--json"]:
        print(json.dumps(measure(sys.argv[2])))
    else:
        machine(Console(width=130 if not sys.stdout.isatty() else None), sys.argv[1:] or PRODUCTS)
