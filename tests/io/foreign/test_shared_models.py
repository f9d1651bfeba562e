"""Every file of other people's models loads, or is refused with a sentence; read from a folder that may be missing."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.oracles import tct

import thenar
from thenar.errors import InputError
from thenar.io import FORMATS, load

MODELS = Path(__file__).resolve().parents[4] / "shared" / "models"
pytestmark = pytest.mark.skipif(not MODELS.is_dir(), reason=f"no {MODELS}: models of others are no part of the project")

ENDINGS = {ending for format in FORMATS if format.module for ending in format.endings}
FOLDERS = sorted({file.parent for file in MODELS.rglob("*") if file.suffix.lower() in ENDINGS})
# What a file that is refused lacks, or has too much of, as the message says it.
REASONS = (
    "no such file",
    "CIF construct 'cont'",
    "CIF construct 'channel'",
    "CIF construct 'tau'",
    "neither controllable nor uncontrollable",
    "no plant; a problem needs at least one automaton",
    "has no initial location",
    "cannot stand here; an expression should",
    "no Supremica project: it begins with <Alphabet>",
    "a workspace, a list of model files",
    "a transition without an event",
    "an instance of module 'robot_module', which is a file of its own",
)


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: str(folder.relative_to(MODELS)))
def test_every_file_loads_or_is_refused_with_a_sentence(folder: Path) -> None:
    for file in sorted(folder.iterdir()):
        if file.suffix.lower() not in ENDINGS:
            continue
        complaint = ""
        try:
            assert load(file).plants
        except InputError as error:
            complaint = str(error)
        assert not complaint or complaint.startswith(str(folder)), complaint
        assert not complaint or any(reason in complaint for reason in REASONS), complaint


SUPREDUCED = sorted((MODELS / "supremica_xml").glob("*.xml"))


@pytest.mark.parametrize("file", SUPREDUCED, ids=lambda file: file.stem)
def test_reduced_supervisors_are_never_larger_than_tcts(file: Path) -> None:
    problem = load(file)
    assert isinstance(problem, thenar.Problem)
    supervisor = thenar.synthesize(problem).supervisor
    if supervisor.is_empty:
        pytest.skip("there is no supervisor")
    small = thenar.supreduce(problem.plants, supervisor)
    assert small.lower_bound <= small.n_states <= tct.supreduce(problem.plants, supervisor.automaton).n_states
    whole = thenar.closed_loop(problem.plants, supervisor)
    again = thenar.closed_loop(problem.plants, small)
    assert thenar.is_sublanguage(whole, again)
    assert thenar.is_sublanguage(again, whole)
