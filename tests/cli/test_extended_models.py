"""Models with variables, guards and conditions on the command line: shown, solved, and written as a result."""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

import thenar
from thenar.cli import main

PAGE = (Path(__file__).parents[2] / "docs" / "model-file.md").read_text(encoding="utf-8")
CUP = next(text for text in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if 'name = "cup"' in text)
SHOWN = re.search(r"```console\n\$ thenar synth cup.toml --guards \| tail -2\n(.*?)```", PAGE, re.DOTALL)


class Done(NamedTuple):
    code: int
    out: str
    err: str


Run = Callable[..., Done]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command line in this process."""

    def call(*args: object) -> Done:
        monkeypatch.setattr(sys, "argv", ["thenar", *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        assert isinstance(ended.value.code, int)
        return Done(ended.value.code, captured.out, captured.err)

    return call


@pytest.fixture
def cup(tmp_path: Path) -> Path:
    path = tmp_path / "cup.toml"
    path.write_text(CUP)
    return path


def test_the_guards_are_those_of_the_documentation(run: Run, cup: Path) -> None:
    assert SHOWN is not None
    done = run("synth", cup, "--guards")
    assert done.code == 0
    assert done.out.endswith(SHOWN[1])


@pytest.mark.parametrize("ending", ["toml", "json"])
@pytest.mark.parametrize("model", ["cup", "agv", "glr"])
def test_the_supervised_system_is_written_as_automata_and_guards(
    model: str, ending: str, run: Run, cup: Path, tmp_path: Path
) -> None:
    out = tmp_path / f"out.{ending}"
    name = cup if model == "cup" else model
    done = run("synth", name, "--guards", "-o", out)
    assert done.code == 0
    assert f"supervised system written to {out}" in done.out
    problem = thenar.load(cup) if model == "cup" else thenar.library.model(model)
    first, again = thenar.synthesize(problem, "symbolic"), thenar.synthesize(thenar.load(out), "symbolic")
    assert again.size == first.size
    assert again.explored.states == again.size.states  # there is nothing left to prevent
    assert again.symbolic is not None
    assert {str(guard) for guard in thenar.guards(again.symbolic).values()} == {"true"}


def test_a_large_supervised_system_is_written_too(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out.toml"
    done = run("synth", "transfer_line(20)", "-o", out)
    assert done.code == 3
    assert done.err == (
        f"thenar: {out}: the supervisor has 8.77e28 states, too many to list one by one; with --guards the supervised "
        "system is written as automata and guards\n"
    )
    assert not out.exists()
    assert run("synth", "transfer_line(20)", "--guards", "-o", out).code == 0
    assert thenar.synthesize(thenar.load(out)).size.states == 28**20


def test_a_supervisor_that_is_no_automaton_names_the_way_out(run: Run, cup: Path, tmp_path: Path) -> None:
    cup.write_text(CUP.replace('values = "0..5" }', 'values = "0..5", initial = [0, 1] }'))
    out = tmp_path / "out.json"
    done = run("synth", cup, "-o", out)
    assert done.code == 2
    assert "the supervisor has 2 initial states; an automaton has one; with --guards the supervised system" in done.err
    assert run("synth", cup, "--guards", "-o", out).code == 0
    assert thenar.synthesize(thenar.load(out)).size == thenar.synthesize(thenar.load(cup)).size


def test_guards_that_share_too_much_are_not_written_out(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("thenar.cli.large.MAX_TERMS", 100)
    out = tmp_path / "out.toml"
    done = run("synth", "agv", "--guards", "-o", out)
    assert done.code == 2
    assert re.search(r"written out for a model file they have [\d,]+ terms; leave out -o to print them", done.err)
    assert not out.exists()


def test_a_model_is_shown_as_a_model_file(run: Run, cup: Path, tmp_path: Path) -> None:
    shown = run("show", cup)
    assert shown.code == 0
    assert shown.out == thenar.dumps(thenar.load(cup))
    assert json.loads(run("show", cup, "--json").out)["variables"]["stock"] == {"values": "0..5", "initial": 0}
    out = tmp_path / "again.toml"
    assert run("show", cup, "-o", out).code == 0
    assert out.read_text() == shown.out


@pytest.mark.parametrize("option", [("--format", "svg"), ("--automaton", "CUP"), ("--after", "fill")])
def test_a_model_with_variables_is_not_drawn(option: tuple[str, str], run: Run, cup: Path) -> None:
    done = run("show", cup, *option)
    assert done.code == 2
    assert done.err == (
        f"thenar: {cup}: has variables or conditions, and is shown as a whole: as text, or with --json as JSON\n"
    )
