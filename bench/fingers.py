"""The grasp-lift-replace task with more fingers: how states, diagrams and seconds grow."""

from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from bench.families import diagram_cells, diagrams

FINGERS = [2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 30, 50, 70, 100]
QUICK = [2, 5, 10]
ASKED = {2: 0.005, 10: 1.0, 100: 60.0}  # CPU seconds
STOP_S = 120


def fingers(console: Console, rows: list[dict[str, Any]], quick: bool) -> None:
    """Rising numbers of fingers until one takes too long; then only the largest, which is asked for."""
    heads = ("model", "states", "nodes", "seconds", "asked", "encode", "saturate", "guards", "MB")
    table = Table(*heads, box=box.SIMPLE, caption=f"CPU seconds from the problem in memory; stopped at {STOP_S}")
    stopped = False
    counts = QUICK if quick else FINGERS
    try:
        for n in counts:
            if stopped and n != counts[-1]:
                continue
            row = diagrams(f"glr(fingers={n})", ASKED.get(n), STOP_S) | {"fingers": n}
            rows.append(row)
            stopped = stopped or "states" not in row
            table.add_row(*diagram_cells(row))
    finally:
        console.print(table)
