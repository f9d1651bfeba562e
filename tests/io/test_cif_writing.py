"""What is written as a CIF model is read again as the same problem."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest
from tests.io.test_writing import content
from tests.symbolic.test_cif_answers import BENCHMARKS, MODELS

import thenar
from thenar.errors import InputError
from thenar.io import cif, load, save
from thenar.io.side import ENDING
from thenar.library import glr
from thenar.testing.random_models import random_extended_problem, random_problem

Model = thenar.Problem | thenar.ExtendedProblem


def again(problem: Model, folder: Path, *, without_table: bool = False) -> Model:
    file = folder / "model.cif"
    save(problem, file)
    if without_table:
        file.with_name(file.name + ENDING).unlink(missing_ok=True)
    return load(file)


def sizes(problem: Model) -> tuple[int, int]:
    found = thenar.synthesize(problem, "symbolic").size
    return found.states, found.transitions


def test_random_extended_problems_have_the_same_supervisor(tmp_path: Path) -> None:
    for seed in range(200):
        problem = random_extended_problem(Random(seed))
        read = again(problem, tmp_path)
        assert sizes(read) == sizes(problem), seed
        assert [a.name for a in read.automata] == [a.name for a in problem.automata]
        assert read.alphabet == problem.alphabet


def test_random_plain_problems_come_back_state_by_state(tmp_path: Path) -> None:
    for seed in range(1_000):
        problem = random_problem(Random(seed))
        read = again(problem, tmp_path)
        assert isinstance(read, thenar.Problem)
        assert list(map(content, read.automata)) == list(map(content, problem.automata)), seed
        assert (read.name or "model", read.alphabet) == (problem.name or "model", problem.alphabet)


def test_names_and_texts_come_back(tmp_path: Path) -> None:
    problem = glr.problem()
    read = again(problem, tmp_path)
    assert isinstance(read, thenar.Problem)
    assert list(map(content, read.automata)) == list(map(content, problem.automata))
    assert [(e, e.meaning) for e in read.alphabet] == [(e, e.meaning) for e in problem.alphabet]
    assert (read.name, read.description) == (problem.name, problem.description)


def test_without_the_table_the_behaviour_is_the_same(tmp_path: Path) -> None:
    assert sizes(again(glr.problem(), tmp_path, without_table=True)) == sizes(glr.problem())


@pytest.mark.parametrize("divisor", [1, 2, 3, -1, -2, -3])
@pytest.mark.parametrize("operator", ["//", "%"])
def test_division_rounds_down_after_reading_too(tmp_path: Path, operator: str, divisor: int) -> None:
    """CIF's own div and mod round towards zero."""
    cell = thenar.ExtendedAutomaton.from_edges(
        "CELL", [("0", "go", "0", "true", {"m": f"n {operator} ({divisor})", "n": "n + 1"})], initial="0", marked=["0"]
    )
    variables = [thenar.Variable("n", range(-7, 8)), thenar.Variable("m", range(-9, 10), initial=0)]
    problem = thenar.ExtendedProblem(cell, variables=variables)
    goal = [f"m == {n // divisor if operator == '//' else n % divisor} or n != {n + 1}" for n in range(-7, 7)]
    for text in goal:
        checked = thenar.ExtendedProblem(cell, thenar.invariant(text), variables=variables)
        assert sizes(again(checked, tmp_path)) == sizes(checked) == sizes(problem), text


def test_what_cif_has_no_words_for_is_refused() -> None:
    gaps = thenar.Variable("n", [0, 2, 4])
    plant = thenar.ExtendedAutomaton.from_edges("P", ["0 -a-> 0"], initial="0")
    with pytest.raises(InputError, match="variable 'n' has whole numbers with gaps"):
        thenar.dumps(thenar.ExtendedProblem(plant, variables=[gaps]), "cif")


@pytest.mark.skipif(not MODELS.is_dir(), reason=f"no {MODELS}: models of others are no part of the project")
@pytest.mark.parametrize("name", [name for name in BENCHMARKS if BENCHMARKS[name] < 10**8])
def test_benchmarks_written_and_read_have_as_many_controlled_states(name: str, tmp_path: Path) -> None:
    problem = cif.load(MODELS / "benchmarks" / f"{name}.cif")
    read = again(problem, tmp_path)
    assert sizes(read)[0] == BENCHMARKS[name]
    assert read.alphabet == problem.alphabet
