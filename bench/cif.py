"""CIF's benchmark models and the cat and mouse tower: one process each, from the file to the guards, all of it counted.

The models are other people's and no part of the project: the folder is an argument, or ../shared/models beside the
repository.  CIF itself is not run: its seconds are those that the issue of this benchmark states.
"""

import tempfile
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from bench.fresh import ROOT, fresh, megabytes

MODELS = ROOT.parent / "shared" / "models"
STOP_S = 60
PARTS = ("start", "load", "encode", "saturate", "guards")

BENCHMARKS: dict[str, tuple[int, float | None]] = {  # controlled states as CIF counts them, CIF's CPU seconds if known
    "agv/agv.cif": (4_406, 2.2),
    "dining_philosophers/dining_philosophers.cif": (241, None),
    "cat_mouse_tower/cat_mouse_tower_v1_n3_k2.cif": (8_612, 3.8),
    "production_cell/production_cell.cif": (114_602_772, 8.4),
    "themepark/themepark.cif": (6_693_120, 2.5),
    "mri_state/mri.cif": (27_872, 1.8),
    "adas/adas.cif": (20_384_317_440, 2.6),
    "festo/station5.cif": (126_720, None),
    "festo/stations12.cif": (3_822_059_520, 2.5),
    "swarm/swarm_aggregation.cif": (9, None),
    "swarm/swarm_clustering.cif": (16, None),
    "swarm/swarm_formation.cif": (138, None),
    "swarm/swarm_segregation.cif": (128, None),
}
TOWERS = {(3, 2): 8_612}  # levels and animals: controlled states, where CIF has counted them

# The festo models import what is not beside them.  These definitions give the states that CIF counts; that the second
# kind of actuator is as the first does not follow from the counts.
FESTO = """
plant def TwoStateSensor(alg bool on):
  uncontrollable u_on, u_off;
  location Off: initial not on; marked; edge u_on goto On;
  location On: initial on; marked; edge u_off goto Off;
end
plant def TwoStateActuator(alg bool on):
  controllable c_on, c_off;
  location Off: initial not on; marked; edge c_on goto On;
  location On: initial on; marked; edge c_off goto Off;
end
plant def TwoStateActuator2(alg bool on):
  controllable c_on, c_off;
  location Off: initial not on; marked; edge c_on goto On;
  location On: initial on; marked; edge c_off goto Off;
end
"""

Rows = list[dict[str, Any]]


def cif(console: Console, rows: Rows, quick: bool, models: Path = MODELS) -> None:
    """Run each benchmark model that is there, then towers of other sizes."""
    folder = models / "cif" / "benchmarks"
    table = Table("model", "states", "CPU s", "CIF s", "CIF /", *PARTS, "MB", box=box.SIMPLE)
    table.caption = "CPU s: whole process; CIF s: stated, not measured here, 2x is asked; ?: not counted by others"
    try:
        if not folder.is_dir():
            console.print(f"skipped CIF's models: there is no folder {_shown(folder)}; say where: --models FOLDER")
        else:
            with tempfile.TemporaryDirectory() as scratch:
                for name, (states, theirs) in BENCHMARKS.items():
                    if (folder / name).exists():
                        row = _run(name, str(_complete(folder / name, Path(scratch))), states, theirs)
                        rows.append(row)
                        table.add_row(*_cells(row))
                    else:
                        console.print(f"skipped {name}: not in {_shown(folder)}")
        for levels in range(1, 4 if quick else 6):
            for animals in range(1, 3 if quick else 4):
                name = f"tower({levels},{animals})"
                row = _run(name, name, TOWERS.get((levels, animals)), None)
                rows.append(row)
                table.add_row(*_cells(row))
    finally:
        console.print(table)


def _shown(path: Path) -> str:
    return str(path.relative_to(ROOT.parent)) if path.is_relative_to(ROOT.parent) else str(path)


def _complete(file: Path, scratch: Path) -> Path:
    """Return ``file``, or a copy beside which there is what it imports."""
    if file.parent.name != "festo" or (file.parent / "definitions.cif").exists():
        return file
    (scratch / "definitions.cif").write_text(FESTO)
    copy = scratch / file.name
    copy.write_bytes(file.read_bytes())
    return copy


def _run(name: str, model: str, states: int | None, theirs: float | None) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as scratch:
        # the best of three: start-up is most of it, and the first one may have to read the libraries from the disk
        runs = [fresh("bench.whole", model, str(Path(scratch) / "guards"), limit_s=STOP_S)]
        while runs[0] and len(runs) < 3 and runs[0].cpu_s < 2.0:
            runs.append(fresh("bench.whole", model, str(Path(scratch) / "guards"), limit_s=STOP_S))
    found = min(runs, key=lambda run: run.cpu_s)
    row = {"model": name, "cif_s": theirs, "cpu_s": found.cpu_s, **found.said}
    if not found:
        return row | {"trouble": found.trouble}
    if states not in (None, row["states"]):
        raise SystemExit(f"{name}: {row['states']:,} controlled states; CIF counts {states:,}")
    return row | {"checked": states is not None}


def _cells(row: dict[str, Any]) -> list[str]:
    name = Path(row["model"]).stem
    if "trouble" in row:
        return [name, "", row["trouble"]]
    theirs = row["cif_s"]
    ratio = ["-", "-"] if theirs is None else [f"{theirs:.1f}", f"{theirs / row['cpu_s']:.1f}x"]
    parts = [f"{row['parts_s'][part]:.3f}" for part in PARTS]
    states = f"{row['states']:,}" + ("" if row["checked"] else " ?")
    return [name, states, f"{row['cpu_s']:.2f}", *ratio, *parts, megabytes(row["peak_bytes"])]
