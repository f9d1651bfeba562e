"""Every file of other people's models loads, or is refused with a sentence; read from a folder that may be missing."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.oracles import libfaudes, tct

import thenar
from thenar.errors import InputError
from thenar.io import FORMATS, load
from thenar.testing import oracle
from thenar.testing.asserts import assert_isomorphic, assert_same_supervisor

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


def plain_models() -> list[tuple[str, tuple[str, ...], tuple[str, ...]]]:
    """Name, files of plants, and files of specifications, of the models of ANSWERS.md without variables."""
    models = [(file.stem, (f"supremica_xml/{file.name}",), ()) for file in sorted((MODELS / "supremica_xml").glob("*"))]
    models += [
        (name, (f"supremica_wmod/{name}.wmod",), ())
        for name in ("RCU_Supremica", "deadlock_in_database_system", "digit_sequence_detector")
    ]
    cats, factory = "ides/Cat and Mouse Problem/Plant -", "ides/Small Factory/Centralized_Approach"
    line = "tct/Transfer_Line_-_OK"
    return [
        *models,
        ("libFAUDES syn_1", ("faudes/synthesis/verysimplemachine.gen",), ()),
        ("TCT transfer line", (f"{line}/M1.DES", f"{line}/M2.DES", f"{line}/TU.DES"),
         (f"{line}/B1.DES", f"{line}/B2.DES")),
        ("IDES small factory", (f"{factory}/Machine_1.xmd", f"{factory}/Machine_2.xmd"),
         (f"{factory}/SPEC_1.xmd", f"{factory}/SPEC_2.xmd")),
        ("IDES cat and mouse", (f"{cats} Cat.xmd", f"{cats} Mouse.xmd"), (f"{cats[:-7]}Specification.xmd",)),
    ]  # fmt: skip


@pytest.mark.parametrize(("name", "plants", "specs"), plain_models(), ids=lambda x: x if isinstance(x, str) else "")
def test_both_engines_and_three_other_tools_agree(name: str, plants: tuple[str, ...], specs: tuple[str, ...]) -> None:
    problem = load(*(MODELS / file for file in plants), specs=[MODELS / file for file in specs])
    assert isinstance(problem, thenar.Problem)
    explicit, symbolic = (thenar.synthesize(problem, engine) for engine in ("explicit", "symbolic"))
    assert_same_supervisor(explicit.supervisor, symbolic.supervisor)
    ours = explicit.supervisor.automaton
    assert_isomorphic(ours, oracle.supcon(problem.plants, problem.specs))
    assert_isomorphic(ours, tct.supcon(problem.plants, problem.specs))
    assert_isomorphic(ours, libfaudes.supcon(problem.plants, problem.specs))


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
