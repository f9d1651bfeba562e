"""CIF models that other people wrote: all load or are refused in words, and synthesis finds what CIF found."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from thenar.errors import InputError
from thenar.io import cif
from thenar.testing.extended_oracle import supcon

MODELS = Path(__file__).resolve().parents[3] / "shared" / "models" / "cif"
pytestmark = pytest.mark.skipif(not MODELS.is_dir(), reason=f"no {MODELS}: models of others are no part of the project")

CONT, TAU, CHANNEL = "construct 'cont'", "construct 'tau'", "construct 'channel'"
NO_PLANT, NO_INITIAL, NO_KIND = "no plant", "has no initial location", "neither controllable nor uncontrollable"
NO_FILE = "no such file"

REFUSED = {
    "benchmarks/festo/station5.cif": NO_FILE,  # of what it imports
    "benchmarks/festo/stations12.cif": NO_FILE,
    "examples/bridge/diagnosers/diagnoser_templates.cif": CONT,
    "examples/bridge/diagnosers/diagnosers.cif": CONT,
    "examples/bridge/simulation/plant.cif": CONT,
    "examples/bridge/simulation/plant_and_sim.cif": CONT,
    "examples/bridge/simulation/plant_and_sim_and_viz.cif": CONT,
    "examples/bridge/simulation/timers.cif": CONT,
    "examples/bridge/simulation/ui_and_viz.cif": NO_KIND,
    "examples/bridge/synthesis/plant_templates.cif": NO_PLANT,
    "examples/button_lamp/button_lamp_usecase.cif": CONT,
    "examples/button_lamp_timer/button_lamp_timer_hw.cif": CONT,
    "examples/button_lamp_timer/button_lamp_timer_sim.cif": CONT,
    "examples/fifo/fifo.manually_modeled_supervisor.cif": CHANNEL,
    "examples/fifo/fifo.plants.cif": CHANNEL,
    "examples/fifo/fifo.plants_and_requirements.cif": CHANNEL,
    "examples/fifo/fifo.simulation.cif": NO_FILE,
    "examples/wolf_goat_cabbage_game/models/wolf_goat_cabbage.actions.cif": NO_PLANT,
    "examples/wolf_goat_cabbage_game/models/wolf_goat_cabbage.delays.cif": CONT,
    "examples/wolf_goat_cabbage_game/models/wolf_goat_cabbage.game.cif": CHANNEL,
    "examples/wolf_goat_cabbage_game/models/wolf_goat_cabbage.requirements.no_useless_moves.cif": CHANNEL,
    "examples/wolf_goat_cabbage_game/models/wolf_goat_cabbage.requirements.only_safe_moves.cif": CHANNEL,
    "tests_eventbased/automaton_abstraction/empty_automaton.cif": NO_INITIAL,
    "tests_eventbased/automaton_abstraction/marked_and_nonmarked.cif": NO_INITIAL,
    "tests_eventbased/controllability_check/evt_non_ctrl.cif": NO_KIND,
    "tests_eventbased/controllability_check/non_deterministic.cif": TAU,
    "tests_eventbased/nfa_to_dfa/empty_automaton.cif": NO_INITIAL,
    "tests_eventbased/nfa_to_dfa/empty_automaton.run.expected.cif": NO_INITIAL,
    "tests_eventbased/nonconflicting_check/empty.cif": NO_PLANT,
    "tests_eventbased/projection/empty_automaton.cif": NO_INITIAL,
    "tests_eventbased/projection/empty_automaton.run.expected.cif": NO_INITIAL,
    "tests_eventbased/supervisor_synthesis/empty_file.cif": NO_PLANT,
    "tests_eventbased/synchronous_product/empty_file.cif": NO_PLANT,
    "tests_eventbased/trim/empty_file.cif": NO_PLANT,
}
"""The files that are refused, each with a piece of the sentence that says why."""


def test_each_model_loads_or_is_refused_in_words() -> None:
    files = sorted(MODELS.rglob("*.cif"))
    refused = {}
    for file in files:
        try:
            cif.load(file)
        except InputError as error:
            refused[file.relative_to(MODELS).as_posix()] = str(error)
    print(f"{len(files) - len(refused)} of {len(files)} CIF models load")
    expected = {name for name in REFUSED if (MODELS / name).exists()}
    if (MODELS / "benchmarks" / "festo" / "definitions.cif").exists():
        expected -= {name for name in expected if "/festo/" in name}
    assert set(refused) == expected
    assert {name: said for name, said in refused.items() if REFUSED[name] not in said} == {}


def controlled_states() -> list[tuple[str, int]]:
    """Return the models that CIF's data-based synthesis was run on, and how many states it says are controlled."""
    found = []
    for out in sorted((MODELS / "tests_datasynth").glob("*.cif.out")):
        if said := re.search(r"Controlled system: exactly ([\d,]+) state", out.read_text()):
            found.append((out.name.removesuffix(".out"), int(said[1].replace(",", ""))))
    return found


@pytest.mark.parametrize(("name", "states"), controlled_states())
def test_as_many_states_are_controlled_as_cif_counts(name: str, states: int) -> None:
    assert supcon(cif.load(MODELS / "tests_datasynth" / name)).n_states == states


@pytest.mark.parametrize(
    ("name", "states"),  # counts of CIF's data-based synthesis
    [
        ("agv/agv.cif", 4406),
        ("dining_philosophers/dining_philosophers.cif", 241),
        ("swarm/swarm_aggregation.cif", 9),
        ("swarm/swarm_clustering.cif", 16),
        ("swarm/swarm_formation.cif", 138),
        ("swarm/swarm_segregation.cif", 128),
    ],
)
def test_the_small_benchmarks_have_the_sizes_that_cif_reports(name: str, states: int) -> None:
    assert supcon(cif.load(MODELS / "benchmarks" / name)).n_states == states


def test_what_cif_writes_after_synthesis_has_the_state_space_that_cif_explores() -> None:
    """Nothing has to be removed from a controlled system: its supervisors, read as specifications, stay as they are."""
    differ, compared = {}, 0
    for file in sorted((MODELS / "tests_datasynth").glob("*.ctrlsys.cif")):
        (space,) = cif.load(file.with_name(file.name.replace("ctrlsys", "statespace"))).plants
        result = supcon(cif.load(file))
        compared += 1
        if result.n_states != len(space.states) or len(result.transitions) != len(space.edges):
            differ[file.name] = (result.n_states, len(space.states), len(result.transitions), len(space.edges))
    assert compared > 20
    assert differ == {}
