"""The families whose supervisors' sizes are known, at rising sizes: beside TCT and libFAUDES, and with diagrams."""

import json
import sys
import time
from collections.abc import Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

import thenar
from bench.fresh import fresh, megabytes, peak, rebase
from thenar.errors import LimitReached
from thenar.model.limits import Limits

TOOLS = ("thenar", "TCT", "libFAUDES")
SIZES: dict[str, Sequence[int | str]] = {
    "small_factory": [2, 4, 6, 7, 8, 10],
    "transfer_line": [1, 2, 3, 4],
    "chain": [4, 6, 7, 8, 10, 12],
    "dining": [3, 5, 7, 8, 10, 12],
    "": ["cat_and_mouse", "agv", "glr"],
}
QUICK: dict[str, Sequence[int | str]] = {
    "small_factory": [2, 5],
    "transfer_line": [1, 2],
    "chain": [4, 8],
    "dining": [3, 8],
    "": ["glr"],
}
ENOUGH_S = 30  # a tool that took longer is not asked for the next size of the family
STOP_S = 60  # and no tool may take longer than that

LARGE = [  # with what they are asked to stay under, CPU seconds; None: nothing in particular
    ("transfer_line(10)", None),
    ("transfer_line(100)", None),
    ("transfer_line(300)", 1.0),
    ("transfer_line(1000)", 10.0),
    ("dining(10)", None),
    ("dining(100)", None),
    ("dining(1000)", 3.0),
    ("chain(100)", None),
    ("chain(1000)", None),
    ("small_factory(100)", None),
]
QUICK_LARGE = ("transfer_line(10)", "transfer_line(300)", "dining(100)", "chain(100)")

Rows = list[dict[str, Any]]


def expected(model: str) -> int | None:
    """Return how many states the supervisor is known to have; fitted to runs of several tools that agree."""
    family, _, rest = model.partition("(")
    n = int(rest[:-1]) if rest[:-1].isdecimal() else 0
    if family == "dining":
        a, b = 2, 2  # Pell-Lucas numbers
        for _ in range(n - 1):
            a, b = b, 2 * b + a
        return b - 1
    if not n:
        return {"cat_and_mouse": 6, "agv": 4406, "glr": 2809}.get(model)
    return {"transfer_line": 28**n, "chain": 2 * 3 ** (n - 1), "small_factory": 3 * 4 ** (n - 1)}.get(family)


def families(console: Console, rows: Rows, quick: bool) -> None:
    """The whole job, from the problem in memory, state by state: three tools, each in a process of its own."""
    memory = ("thenar MB", "TCT MB", "libFAUDES MB")
    table = Table("model", "states", "thenar ms", "TCT /", "libFAUDES /", *memory, box=box.SIMPLE)
    table.caption = (
        f"TCT /: seconds of TCT by those of thenar; MB: peak, beyond an idle process; no more than {STOP_S} s"
    )
    tired: set[tuple[str, str]] = set()
    try:
        for family, sizes in (QUICK if quick else SIZES).items():
            for size in sizes:
                name = f"{family}({size})" if family else str(size)
                row = _compared(name, [t for t in TOOLS if (t, family) not in tired], 0.3 if quick else 2.0)
                rows.append(row)
                tired |= {(t, family) for t, s in row["seconds"].items() if family and (s is None or s > ENOUGH_S)}
                table.add_row(*_cells(row))
    finally:
        console.print(table)


def _compared(name: str, tools: list[str], patience_s: float) -> dict[str, Any]:
    states = expected(name)
    row: dict[str, Any] = {"model": name, "states": states, "seconds": {}, "peak_bytes": {}, "trouble": {}}
    for tool in tools:
        found = fresh("bench.peers", tool, name, str(patience_s), limit_s=STOP_S)
        row["seconds"][tool] = found.said.get("cpu_s")
        row["peak_bytes"][tool] = found.said.get("peak_bytes")
        if not found:
            row["trouble"][tool] = found.trouble
        elif found.said["states"] != states:
            raise SystemExit(f"{name}: {tool} finds {found.said['states']:,} states; it has {states:,}")
    return row


def _cells(row: dict[str, Any]) -> list[str]:
    ours = row["seconds"].get("thenar")
    cells = [row["model"], f"{row['states']:,}"]
    cells.append(f"{1000 * ours:.2f}" if ours else row["trouble"].get("thenar", "-"))
    for tool in TOOLS[1:]:
        theirs = row["seconds"].get(tool)
        if theirs and ours:
            cells.append(f"{theirs / ours:,.{1 if theirs < 10 * ours else 0}f}x")
        elif ours and row["trouble"].get(tool, "").startswith(">"):
            cells.append(f"> {STOP_S / ours:,.0f}x")
        else:
            cells.append(row["trouble"].get(tool, "-"))
    return [*cells, *(megabytes(row["peak_bytes"].get(tool)) for tool in TOOLS)]


def symbolic(console: Console, rows: Rows, quick: bool) -> None:
    """Families far beyond what can be listed, by decision diagrams, the search for an order included."""
    heads = ("model", "states", "nodes", "seconds", "asked", "encode", "saturate", "guards", "MB")
    table = Table(*heads, box=box.SIMPLE, caption="CPU seconds from the problem in memory; guards, as text, are beside")
    try:
        for name, asked in LARGE:
            if quick and name not in QUICK_LARGE:
                continue
            row = diagrams(name, asked)
            rows.append(row)
            if row.get("states") not in (None, expected(name)):
                raise SystemExit(f"{name}: {row['states']:,} states; it has {expected(name):,}")
            table.add_row(*diagram_cells(row))
    finally:
        console.print(table)


def diagrams(name: str, asked: float | None, limit_s: int = STOP_S) -> dict[str, Any]:
    """Synthesise ``name`` with diagrams in a process of its own."""
    found = fresh("bench.families", name, limit_s=limit_s)
    row = {"model": name, "asked": asked, **found.said}
    return row if found else {"trouble": found.trouble, **row}


def diagram_cells(row: dict[str, Any]) -> list[str]:
    asked = "" if row["asked"] is None else f"< {row['asked']:g}"
    if "states" not in row:
        return [row["model"], "", "", row["trouble"], asked]
    states = f"{row['states']:,}" if row["states"] < 10**12 else f"{len(str(row['states']))} digits"
    parts = (f"{row[what]:.3f}" for what in ("encode_s", "saturate_s"))
    guards = f"{row['guards_s']:.3f}" if "guards_s" in row else row["trouble"]
    seconds = f"{row['cpu_s']:.4f}"
    return [row["model"], states, f"{row['nodes']:,}", seconds, asked, *parts, guards, megabytes(row["peak_bytes"])]


def measure(name: str) -> dict[str, Any]:
    """Synthesise a few times, then write the guards once; the split of the seconds is that of the wall's."""
    problem = thenar.library.model(name)
    thenar.guards(_symbolic(thenar.library.model("small_factory(2)")))  # what is imported once is not the job
    base = rebase()
    runs: list[float] = []
    while not runs or (len(runs) < 5 and sum(runs) < 1.0):
        start = time.process_time()
        try:
            result = thenar.synthesize(problem, "symbolic", limits=Limits(bytes=8 << 30))
        except LimitReached as reached:
            return {"trouble": str(reached), "cpu_s": time.process_time() - start}
        runs.append(time.process_time() - start)
    assert result.symbolic is not None
    found = result.symbolic
    cpu_s = min(runs)
    share = {f"{phase}_s": cpu_s * s / result.seconds for phase, s in result.timings.items()}
    row = {
        "states": found.n_states,
        "nodes": found.controlled.n_nodes,
        "peak_nodes": found.encoding.forest.peak,
        "cpu_s": cpu_s,
        **share,
        "peak_bytes": peak() - base,
    }
    print(json.dumps(row), flush=True)  # the guards may take too long
    start = time.process_time()
    text = str(thenar.guards(found))
    return row | {"guards_s": time.process_time() - start, "guards_chars": len(text)}


def _symbolic(problem: thenar.Problem) -> thenar.SymbolicSupervisor:
    result = thenar.synthesize(problem, "symbolic")
    assert result.symbolic is not None
    return result.symbolic


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1])))
