"""Both engines find as many controlled states of CIF's models as CIF itself; read from a folder that may be missing."""

import re
from pathlib import Path

import pytest

import thenar
from thenar.io import cif

MODELS = Path(__file__).resolve().parents[3] / "shared" / "models" / "cif"
pytestmark = pytest.mark.skipif(not MODELS.is_dir(), reason=f"no {MODELS}: models of others are no part of the project")

# Controlled states as CIF's data-based synthesis prints them.
BENCHMARKS = {
    "adas/adas": 20_384_317_440,
    "agv/agv": 4_406,
    "cat_mouse_tower/cat_mouse_tower_v1_n3_k2": 8_612,
    "dining_philosophers/dining_philosophers": 241,
    "mri_state/mri": 27_872,
    "production_cell/production_cell": 114_602_772,
    "swarm/swarm_aggregation": 9,
    "swarm/swarm_clustering": 16,
    "swarm/swarm_formation": 138,
    "swarm/swarm_segregation": 128,
    "themepark/themepark": 6_693_120,
}
FESTO = {"station5": 126_720, "stations12": 3_822_059_520}
# What the festo models import is not beside them; sensors and actuators with two states.
DEFINITIONS = "".join(
    f"plant def {kind}(alg bool on): {events}; location Off: initial not on; marked; edge {up} goto On; "
    f"location On: initial on; marked; edge {down} goto Off; end\n"
    for kind, events, up, down in (
        ("TwoStateSensor", "uncontrollable u_on, u_off", "u_on", "u_off"),
        ("TwoStateActuator", "controllable c_on, c_off", "c_on", "c_off"),
        ("TwoStateActuator2", "controllable c_on, c_off", "c_on", "c_off"),
    )
)
LISTED = 30_000  # states that are listed one by one too: Python does it


def assert_controlled_states(problem: thenar.Problem | thenar.ExtendedProblem, states: int) -> None:
    symbolic = thenar.synthesize(problem, "symbolic")
    assert symbolic.symbolic is not None
    assert symbolic.symbolic.n_states == states
    if symbolic.symbolic.reachable.count() <= LISTED:
        explicit = thenar.synthesize(problem, "explicit")
        assert explicit.size == symbolic.size


@pytest.mark.parametrize("name", BENCHMARKS)
def test_benchmarks(name: str) -> None:
    assert_controlled_states(cif.load(MODELS / "benchmarks" / f"{name}.cif"), BENCHMARKS[name])


@pytest.mark.parametrize("name", FESTO)
def test_festo_stations(name: str, tmp_path: Path) -> None:
    file = MODELS / "benchmarks" / "festo" / f"{name}.cif"
    given = file.parent / "definitions.cif"
    (tmp_path / "definitions.cif").write_text(given.read_text() if given.exists() else DEFINITIONS)
    (tmp_path / file.name).write_bytes(file.read_bytes())
    assert_controlled_states(cif.load(tmp_path / file.name), FESTO[name])


def stated() -> list[Path]:
    return sorted((MODELS / "tests_datasynth").glob("*.cif.out")) if MODELS.is_dir() else []


@pytest.mark.parametrize("output", stated(), ids=lambda path: path.name)
def test_datasynth(output: Path) -> None:
    """What CIF prints in its own tests; an output without a count is one of a system without a supervisor."""
    said = re.search(r"Controlled system: +exactly ([\d,]+) states?", output.read_text())
    assert_controlled_states(cif.load(output.with_suffix("")), int(said[1].replace(",", "")) if said else 0)
