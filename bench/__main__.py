"""Measure, print, and keep one JSON file a run: ``python -m bench [section ...]``."""

import argparse
import contextlib
import json
import os
import platform
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console

import thenar
from bench import plots
from bench.cif import MODELS, cif
from bench.families import families, symbolic
from bench.fingers import fingers
from bench.formats import formats
from bench.hand import hand
from bench.machine import machine
from bench.small import small

SECTIONS = {
    "kernel": "exploration beside the machine's own limits",
    "families": "beside TCT and libFAUDES",
    "diagrams": "families far beyond what can be listed",
    "cif": "CIF's benchmark models, each from the file to the guards",
    "fingers": "the grasp-lift-replace task with many fingers",
    "formats": "files of a million transitions",
    "small": "small things",
    "hand": "the hand",
}
PRODUCTS = [  # of 4 to 60 million states; bench.machine alone has larger ones too
    "toggles(22)",
    "transfer_line(4)",
    "chain(14)",
    "toggles(24)",
    "small_factory(12)",
    "chain(15)",
    "dining(18)",
]
QUICK_PRODUCTS = ["toggles(22)", "chain(14)"]
RESULTS = Path(__file__).parent / "results"


def measure(section: str, console: Console, run: dict[str, Any], quick: bool, models: Path) -> None:
    """Measure one section into ``run``; a list fills row by row, so that an interrupted one is not lost."""
    rows: list[dict[str, Any]] = []
    if section == "kernel":
        run[section] = machine(console, QUICK_PRODUCTS if quick else PRODUCTS)
    elif section in ("small", "hand"):
        run[section] = (small if section == "small" else hand)(console)
    elif section == "cif":
        run[section] = rows
        cif(console, rows, quick, models)
    else:
        run[section] = rows
        {"families": families, "diagrams": symbolic, "fingers": fingers, "formats": formats}[section](
            console, rows, quick
        )


def where() -> dict[str, Any]:
    """Say what kind of machine this is."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    model = platform.machine()
    with contextlib.suppress(OSError, StopIteration):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "thenar": thenar.__version__,
        "python": platform.python_version(),
        "processor": model,
        "cores": cores,
        "memory_gib": round(memory / (1 << 30)),
    }


def main() -> None:
    listed = "\n".join(f"  {name:<10}{text}" for name, text in SECTIONS.items())
    parser = argparse.ArgumentParser(
        "python -m bench",
        description=f"Measure thenar. Sections, all of them if none is named:\n{listed}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("sections", nargs="*", metavar="SECTION")
    parser.add_argument("--quick", action="store_true", help="small sizes only: two minutes instead of fifteen")
    parser.add_argument("--models", type=Path, default=MODELS, help="folder of other people's models")
    parser.add_argument("--plots", nargs="?", const="", metavar="JSON", help="draw a run, the last one, and do no more")
    given = parser.parse_args()
    if given.plots is not None:
        for path in plots.draw(Path(given.plots) if given.plots else plots.latest(RESULTS)):
            print(path)
        return
    if unknown := [name for name in given.sections if name not in SECTIONS]:
        parser.error(f"no section {', '.join(unknown)}; there are {', '.join(SECTIONS)}")

    console = Console(width=150 if not sys.stdout.isatty() else None)
    machine_s = where()
    console.print(
        ", ".join(f"{what} {value}" for what, value in machine_s.items()) + "; CPU seconds, best of several runs"
    )
    run: dict[str, Any] = {"machine": machine_s, "quick": given.quick}
    path = RESULTS / f"{datetime.now(UTC):%Y-%m-%dT%H%M%S}.json"
    RESULTS.mkdir(exist_ok=True)
    try:
        for section in [name for name in SECTIONS if not given.sections or name in given.sections]:
            console.print(f"\n[bold]{section}[/bold]: {SECTIONS[section]}")
            try:
                measure(section, console, run, given.quick, given.models)
            finally:
                path.write_text(json.dumps(run, indent=2))
    except KeyboardInterrupt:
        console.print("interrupted")
        sys.exit(130)
    finally:
        console.print(f"\nwritten to {path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path}")
    for picture in plots.draw(path, path.parent):
        console.print(f"drawn {picture.relative_to(Path.cwd()) if picture.is_relative_to(Path.cwd()) else picture}")


if __name__ == "__main__":
    main()
