"""Files of a million transitions: how many of them are read and written a second, beside libFAUDES and a plain copy."""

import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from rich.console import Console

from thenar.io import format_named, load, save
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event

FORMATS = ("toml", "json", "ads", "faudes", "tct", "desuma", "ides", "supremica", "dot")
ASKED = {"toml": 1.0, "json": 1.0, "ads": 1.0, "faudes": 1.0}  # million transitions a second
TRANSITIONS, QUICK = 1_000_000, 100_000


def formats(console: Console, rows: list[dict[str, Any]], quick: bool) -> None:
    """Write and read one automaton in each format; CPU seconds."""
    n = QUICK if quick else TRANSITIONS
    automaton = large(n)
    console.print(f"{'format':<12}{'MB':>8}{'read':>10}{'write':>10}{'both':>10}   million transitions a second")
    with TemporaryDirectory() as folder:
        for name in FORMATS:
            file = Path(folder, f"big{format_named(name).endings[0]}")
            writing = seconds(partial(save, automaton, file, name))
            reading = seconds(partial(load, file, format=name))
            row: dict[str, Any] = {
                "format": name,
                "transitions": n,
                "bytes": file.stat().st_size,
                "read_s": reading,
                "write_s": writing,
            }
            row |= peer(file) if name == "faudes" else {}
            rows.append(row)
            rates = (n / 1e6 / s for s in (reading, writing, reading + writing))
            asked = f"   asked: {ASKED[name]:.0f}" if name in ASKED else ""
            beside = f"   libFAUDES reads and writes {n / 1e6 / row['libfaudes_s']:.2f}" if "libfaudes_s" in row else ""
            figures = "".join(f"{rate:>10.2f}" for rate in rates)
            console.print(f"{name:<12}{row['bytes'] / 1e6:>8.1f}{figures}{asked}{beside}")


def large(n: int) -> Automaton:
    """Return an automaton of ``n`` transitions: four leave each state, the first to the next one."""
    rng = np.random.default_rng(7)
    states, events = n // 4, 8
    chosen = np.sort(np.argsort(rng.random((states, events)), axis=1)[:, :4], axis=1).ravel()
    targets = rng.integers(0, states, n)
    targets[::4] = (np.arange(states) + 1) % states
    return Automaton.from_arrays(
        Alphabet(Event(f"event_{k}", controllable=k % 2 == 0) for k in range(events)),
        np.arange(states + 1) * 4,
        chosen,
        targets,
        marked=rng.random(states) < 0.1,
        states=[f"s{q}" for q in range(states)],
        name="BIG",
    )


def seconds(work: Callable[[], object]) -> float:
    """Return the CPU seconds of the quicker one of two runs."""
    times = []
    for _ in range(2):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def peer(file: Path) -> dict[str, float]:
    """Return the CPU seconds in which libFAUDES reads ``file`` and writes it again, in a process of its own."""
    code = (
        "import sys, time, faudes\n"
        "start = time.process_time()\n"
        "g = faudes.System(sys.argv[1])\n"
        "g.Write(sys.argv[1] + '.again')\n"
        "print('seconds', time.process_time() - start)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(file)], capture_output=True, text=True, check=True)
    return {"libfaudes_s": float(done.stdout.rpartition("seconds")[2])}
