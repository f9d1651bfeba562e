"""Supervisor reduction beside TCT: how few states, and how long it takes from the supervisor in memory."""

import json
import sys
import time
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from tests.oracles import tct

import thenar
from bench.fresh import fresh
from bench.peers import quiet
from thenar.explicit.reduction import supreduce
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem

MODELS = [
    "transfer_line(1)",
    "transfer_line(2)",
    "small_factory(4)",
    "small_factory(6)",
    "chain(6)",
    "chain(8)",
    "dining(5)",
    "dining(7)",
    "agv",
    "glr",
]
QUICK = ["transfer_line(2)", "small_factory(4)", "glr"]
RUNS = 3
STOP_S = 60


def reduction(console: Console, rows: list[dict[str, Any]], quick: bool) -> None:
    """States and CPU seconds of both tools, the best of three runs, each in a process of its own."""
    table = Table("model", "states", "thenar", "at least", "TCT", "thenar ms", "TCT ms", box=box.SIMPLE)
    try:
        for model in QUICK if quick else MODELS:
            ours, theirs = (fresh("bench.reduction", tool, model, limit_s=STOP_S) for tool in TOOLS)
            row = {"model": model, "thenar": ours.said, "TCT": theirs.said}
            rows.append(row)
            sizes = (
                ours.said.get("of"),
                ours.said.get("states"),
                ours.said.get("lower_bound"),
                theirs.said.get("states"),
            )
            times = (f"{1000 * found.said['cpu_s']:.1f}" if found else found.trouble for found in (ours, theirs))
            table.add_row(model, *(f"{n:,}" if n else "" for n in sizes), *times)
    finally:
        console.print(table)


def by_thenar(problem: Problem, supervisor: Automaton) -> dict[str, float]:
    start = time.process_time()
    small = supreduce(problem.plants, supervisor)
    seconds = time.process_time() - start
    return {"cpu_s": seconds, "of": supervisor.n_states, "states": small.n_states, "lower_bound": small.lower_bound}


def by_tct(problem: Problem, supervisor: Automaton) -> dict[str, float]:
    """Time TCT's supreduce alone, with the control data as given."""
    with quiet(), tct.session(*problem.plants, supervisor) as session:
        plant, whole = session.plant(list(problem.plants)), session.legal([supervisor])
        session.do("condat", plant, whole, out="DAT")
        start = time.process_time()
        small = session.do("supreduce", plant, whole, "DAT")
        seconds = time.process_time() - start
        return {"cpu_s": seconds, "states": int(session.tct.statenum(small))}


TOOLS = {"thenar": by_thenar, "TCT": by_tct}


def measure(tool: str, model: str) -> dict[str, float]:
    problem = thenar.library.model(model)
    supervisor = thenar.synthesize(problem).supervisor.automaton
    runs = [TOOLS[tool](problem, supervisor) for _ in range(RUNS)]
    return min(runs, key=lambda run: run["cpu_s"])


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1], sys.argv[2])))
