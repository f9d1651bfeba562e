"""Waters modules of other people: their answers, and those that CIF wrote beside the models that they are of."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from thenar import ExtendedProblem, Problem, Variable, is_nonblocking, sync, synthesize
from thenar.errors import InputError, ModelError
from thenar.io import cif
from thenar.io.foreign import waters
from thenar.testing.extended_oracle import explore, supcon

MODELS = Path(__file__).resolve().parents[4] / "shared" / "models" / "supremica_wmod"
pytestmark = pytest.mark.skipif(not MODELS.is_dir(), reason=f"no {MODELS}: models of others are no part of the project")
PAIRS = sorted(p.stem for p in MODELS.glob("cif2supremica/*.wmod"))
SUPERVISORS = {  # states and transitions; ANSWERS.md, and for those with variables what both engines and the twin find
    "RCU_Supremica": (6, 24),
    "deadlock_in_database_system": (3, 3),
    "digit_sequence_detector": (4, 12),
    "buffer": None,
    "controleTrafego4vias": None,
    "conveyor_control": None,
}


def read(name: str) -> Problem | ExtendedProblem:
    file = MODELS / f"{name}.wmod"
    return waters.loads(file.read_bytes(), file.name)


def test_every_file_is_tried() -> None:
    assert {f.stem for f in MODELS.glob("*.wmod")} == {*SUPERVISORS, "desmodel"}


@pytest.mark.parametrize("name", SUPERVISORS)
def test_supervisors(name: str) -> None:
    problem = read(name)
    twin = supcon(problem)
    for engine in ("explicit", "symbolic"):
        size = synthesize(problem, engine).size
        assert (size.states, size.transitions) == (SUPERVISORS[name] or (twin.n_states, len(twin.transitions)))
    assert len(twin.transitions) == size.transitions


@pytest.mark.parametrize("name", SUPERVISORS)
def test_written_and_read_again(name: str) -> None:
    problem = read(name)
    again = waters.loads("".join(map(str, waters.dumps(problem).chunks)).encode(), name)
    assert repr(again) == repr(problem)
    assert synthesize(again).size == synthesize(problem).size


@pytest.mark.parametrize(
    ("name", "size", "nonblocking"),
    [("deadlock_in_database_system", (6, 8), False), ("digit_sequence_detector", (4, 12), True)],
)
def test_plants(name: str, size: tuple[int, int], nonblocking: bool) -> None:
    problem = read(name)
    assert isinstance(problem, Problem)
    plant = sync(*problem.plants)
    assert (plant.n_states, plant.n_transitions) == size
    assert bool(is_nonblocking(plant)) == nonblocking


def test_an_instance_of_another_module_is_refused_with_its_name() -> None:
    with pytest.raises(ModelError, match=r"desmodel.wmod:24:1: an instance of module 'robot_module', which is a file"):
        read("desmodel")


# -- pairs ---------------------------------------------------------------------------------------------------


def everywhere(problem: Problem | ExtendedProblem) -> ExtendedProblem:
    """Return the problem with all states marked: most pairs mark values that no variable has."""
    p = ExtendedProblem.of(problem)
    plants, specs = ([replace(a, marked=(True,) * len(a.states)) for a in automata] for automata in (p.plants, p.specs))
    variables = [Variable(v.name, v.values, v.initial) for v in p.variables]
    return ExtendedProblem(
        [*plants, *p.plant_conditions],
        [*specs, *p.spec_conditions],
        variables=variables, initial=p.initial, alphabet=p.alphabet,
    )  # fmt: skip


def model(name: str) -> ExtendedProblem:
    """Return the CIF model; casts and divisors that are variables are written out, which thenar's CIF asks for."""
    source = (MODELS / "cif2supremica" / f"{name}.cif").read_text()
    source = source.replace("<int[39..39]>", "")
    return cif.loads(re.sub(r"(div|mod)( +-?)i5", r"\1\g<2>5", source), name)


def facts(problem: ExtendedProblem, names: list[str]) -> tuple[set[object], set[object], set[object], set[object]]:
    """Return the initial states, moves, illegal and controlled states, seen by the automata and variables ``names``."""
    listed = [a.name for a in problem.automata] + [v.name for v in problem.variables]
    order = [listed.index(n) for n in names]

    def seen(x: tuple[object, ...]) -> tuple[object, ...]:
        return tuple("*" if x[k] == "X" else int(x[k]) if isinstance(x[k], bool) else x[k] for k in order)  # type: ignore[call-overload]

    system, controlled = explore(problem), supcon(problem)
    moves: set[object] = {
        (seen(x), e.replace(":", "."), seen(y)) for x, row in system.step.items() for e, ys in row.items() for y in ys
    }
    return set(map(seen, system.initial)), moves, set(map(seen, system.illegal)), set(map(seen, controlled.states))


@pytest.mark.parametrize("name", PAIRS)
def test_a_module_that_cif_wrote_does_what_its_model_does(name: str) -> None:
    if name == "empty":
        with pytest.raises(InputError, match="no plant"):
            model(name)
        with pytest.raises(InputError, match="no plant"):
            read(f"cif2supremica/{name}")
        return
    given, written = model(name), read(f"cif2supremica/{name}")
    assert supcon(given).n_states == supcon(written).n_states
    given, written = everywhere(given), everywhere(written)
    names = [a.name for a in given.automata] + [v.name for v in given.variables]
    assert facts(given, names) == facts(written, names)
    sizes = {synthesize(p, "explicit").size for p in (given, written)}
    if name != "exprs":  # for the symbolic engine its five variables on one edge have too many values together
        sizes |= {synthesize(p, "symbolic").size for p in (given, written)}
    assert len(sizes) == 1


def test_arithmetic_is_what_the_comments_of_the_model_say() -> None:
    problem = ExtendedProblem.of(read("cif2supremica/exprs"))
    names = [v.name for v in problem.variables]
    known = [dict(zip(names, x[1:], strict=True)) for x in explore(problem).states]
    source = (MODELS / "cif2supremica" / "exprs.cif").read_text()
    blocks = [block for block in source.split("location ")[1:] if "edge" in block]
    for before, block in enumerate(blocks):
        for variable, value in re.findall(r"(\w\d) := .*// *(-?\d+|true|false)", block):
            expected = {"true": 1, "false": 0}.get(value, value)
            assert known[before + 1][f"p.{variable}"] == int(expected), (block, variable)
    assert len(known) == len(blocks) + 1 == 17
