"""thenar convert and thenar formats, as a user types them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import thenar
from thenar.cli import cli
from thenar.errors import InputError
from thenar.io import FORMATS
from thenar.io.formats import Format
from thenar.library.classics import small_factory

WRITTEN = [format for format in FORMATS if format.writes]


def run(*words: str | Path) -> Result:
    return CliRunner().invoke(cli, [str(word) for word in words])


def complaint(*words: str | Path) -> str:
    with pytest.raises(InputError) as caught:
        CliRunner().invoke(cli, [str(word) for word in words], catch_exceptions=False)
    return str(caught.value)


def test_every_format_is_listed() -> None:
    listed = run("formats").output
    for format in FORMATS:
        assert re.search(rf"^ {format.name} +{re.escape(format.title)}", listed, re.MULTILINE)


@pytest.mark.parametrize("format", WRITTEN, ids=lambda format: format.name)
def test_a_problem_goes_there_and_comes_back_with_the_same_supervisor(tmp_path: Path, format: Format) -> None:
    problem = small_factory()
    out = f"{tmp_path}/" if format.one else tmp_path / f"factory{format.endings[0]}"
    done = run("convert", "small_factory", out, "--to", format.name)
    assert done.exit_code == 0, (done.output, done.exception)
    if not format.reads:
        return
    files = sorted(f for f in tmp_path.iterdir() if not f.name.endswith(".names.json"))
    back = tmp_path / "back.toml"
    assert run("convert", *files, back, "--from", format.name).exit_code == 0
    again = thenar.load(back)
    assert thenar.synthesize(again).size == thenar.synthesize(problem).size
    assert {a.name for a in again.specs} == {a.name for a in problem.specs}


def test_a_lone_automaton_needs_to_be_told_from_a_specification(tmp_path: Path) -> None:
    run("convert", "small_factory", f"{tmp_path}/", "--to", "faudes")
    for table in tmp_path.glob("*.names.json"):
        table.unlink()
    machines, buffer = sorted(tmp_path.glob("M*.gen")), next(tmp_path.glob("B*.gen"))
    checked = run("synth", *machines, "--spec", buffer)
    assert "12 states" in checked.output, checked.output


def test_standard_output_takes_a_format() -> None:
    assert run("convert", "small_factory", "-", "--to", "json").output == thenar.dumps(small_factory(), "json")
    assert complaint("convert", "small_factory", "-") == "-: say by --to in which format to write to standard output"


def test_wrong_words_are_one_message(tmp_path: Path) -> None:
    assert complaint("convert", "small_factory", tmp_path / "x.yaml").startswith(f"{tmp_path}/x.yaml: unknown ending")
    assert complaint("convert", "small_factory", "x.toml", "--to", "tcd") == "unknown format 'tcd'; did you mean 'tct'?"
    assert "is written only" in complaint("convert", "x.hoa", "x.toml")
    assert "holds one automaton, and there are 3" in complaint("convert", "small_factory", tmp_path / "x.DES")
    assert not list(tmp_path.iterdir())


def test_variables_are_flattened_when_asked(tmp_path: Path) -> None:
    cup = tmp_path / "cup.toml"
    cup.write_text(
        '[events]\nfill = {}\npour = {}\n[variables.n]\nvalues = "0..3"\n[automata.CUP]\nkind = "plant"\n'
        'initial = "up"\nmarked = ["up"]\ntransitions = [{ arrow = "up -fill-> up", do = { n = "n + 1" } },\n'
        '{ arrow = "up -pour-> up", when = "n == 3", do = { n = 0 } }]\n'
    )
    assert "has variables, for which TCT ADS has no words" in complaint("convert", cup, tmp_path / "cup.ads")
    assert run("convert", cup, tmp_path / "flat.toml", "--flatten").exit_code == 0
    flat = thenar.load(tmp_path / "flat.toml")
    assert isinstance(flat, thenar.Problem)
    assert thenar.synthesize(flat).size == thenar.synthesize(thenar.load(cup)).size


def test_an_output_never_overwrites_a_specification(tmp_path: Path) -> None:
    run("convert", "small_factory", f"{tmp_path}/", "--to", "tct")
    plants, buffer = [tmp_path / f"MACHINE{k}.DES" for k in (1, 2)], tmp_path / "BUFFER1.DES"
    before = buffer.read_bytes()
    for command, option in (("synth", "-o"), ("reduce", "-o"), ("synth", "--certificate")):
        assert "would overwrite the model" in complaint(command, *plants, "--spec", buffer, option, buffer)
    drawing = ("--automaton", "MACHINE1", "--format", "svg", "-o")
    assert "would overwrite the model" in complaint("show", *plants, *drawing, plants[0])
    assert buffer.read_bytes() == before


def test_a_library_model_takes_specifications_from_files(tmp_path: Path) -> None:
    never = thenar.Automaton.from_transitions(
        [], initial="0", marked=["0"], events=small_factory().alphabet, alphabet=["start_1"], name="NEVER"
    )
    thenar.save(never, tmp_path / "never.gen")
    done = run("synth", "small_factory", "--spec", tmp_path / "never.gen")
    assert re.search(r"supervisor +1 states", done.output), done.output


def test_a_certificate_is_checked_against_files_with_specifications(tmp_path: Path) -> None:
    run("convert", "small_factory", f"{tmp_path}/", "--to", "tct")
    files: list[str | Path] = [*tmp_path.glob("M*.DES"), "--spec", tmp_path / "BUFFER1.DES"]
    assert run("synth", *files, "--certificate", tmp_path / "c.cert").exit_code == 0
    assert "proved" in run("verify", tmp_path / "c.cert", *files).output


def test_flattening_names_the_events_that_it_adds_and_keeps_its_limits(tmp_path: Path) -> None:
    both = thenar.ExtendedAutomaton.from_edges("B", ["x -a-> y", "x -a-> z"], initial="x", marked=["y", "z"])
    thenar.save(thenar.ExtendedProblem(both), tmp_path / "both.toml")
    done = run("convert", tmp_path / "both.toml", tmp_path / "flat.DES", "--flatten")
    assert done.output.startswith("note: added were choice1, choice2: ")
    limited = run("convert", tmp_path / "both.toml", tmp_path / "flat.DES", "--flatten", "--max-states", "1")
    assert isinstance(limited.exception, thenar.LimitReached)


def test_what_a_synthesis_does_not_consider_is_said(tmp_path: Path) -> None:
    (tmp_path / "g.gen").write_text(
        "<Generator> g <Alphabet> a +o+ </Alphabet> <TransRel> 1 a 1 </TransRel> <InitStates> 1 </InitStates> "
        "<MarkedStates> 1 </MarkedStates> </Generator>"
    )
    output = run("synth", tmp_path / "g.gen").output
    assert "note: 1 of its events cannot be observed; that is not considered" in output
    assert "note: none of its events is controllable" in output


def test_a_plain_cif_model_is_taken_by_every_command(tmp_path: Path) -> None:
    run("convert", "small_factory", tmp_path / "f.cif")
    for command in ("check", "reduce", "modular", "lint"):
        assert run(command, tmp_path / "f.cif").exit_code in (0, 1), command
    assert "12 states" in run("reduce", tmp_path / "f.cif").output
