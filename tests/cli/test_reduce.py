"""thenar reduce, as a user types it."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import thenar
from thenar.cli import cli
from thenar.errors import InputError
from thenar.library.classics import small_factory, transfer_line


def run(*words: str | Path) -> Result:
    return CliRunner().invoke(cli, [str(word) for word in words])


def test_sizes_and_the_bound_are_printed() -> None:
    """Wonham's transfer line: 28 states, reduced to 8 (Su and Wonham 2004)."""
    done = run("reduce", "transfer_line")
    assert done.exit_code == 0
    assert "supervisor 28 states, reduced to\n         8 states (at least 8)" in done.output


def test_what_is_written_controls_alike(tmp_path: Path) -> None:
    assert run("reduce", "small_factory", "-o", tmp_path / "small.gen").exit_code == 0
    problem = small_factory()
    small = thenar.load(tmp_path / "small.gen").plants[0]
    assert isinstance(small, thenar.Automaton)
    whole = thenar.synthesize(problem).supervisor
    assert thenar.is_isomorphic(thenar.sync(*problem.plants, small), thenar.closed_loop(problem.plants, whole))


def test_local_controllers_go_to_a_folder_or_into_one_file(tmp_path: Path) -> None:
    assert run("reduce", "transfer_line", "--local", "-o", tmp_path, "--to", "ads").exit_code == 0
    assert sorted(f.stem for f in tmp_path.glob("*.ADS")) == ["LOC_L1_M1", "LOC_L1_M2", "LOC_L1_TU"]
    assert run("reduce", "transfer_line", "--local", "-o", tmp_path / "local.toml").exit_code == 0
    problem = transfer_line()
    local = thenar.load(tmp_path / "local.toml").plants
    whole = thenar.closed_loop(problem.plants, thenar.synthesize(problem).supervisor)
    together = thenar.sync(*problem.plants, *(a for a in local if isinstance(a, thenar.Automaton)))
    assert thenar.is_sublanguage(whole, together)
    assert thenar.is_sublanguage(together, whole)


def test_json_and_no_supervisor() -> None:
    found = json.loads(run("reduce", "small_factory", "--json").output)
    assert (found["supervisor"], found["reduced"][0]["states"]) == (12, 2)
    with pytest.raises(InputError, match="unknown ending"):
        CliRunner().invoke(cli, ["reduce", "small_factory", "-o", "x.yaml"], catch_exceptions=False)
