"""The answers in libFAUDES's own test protocols, by our operations on its generators; the folder may be missing.

Each ``%%% test mark`` of a protocol holds what its tutorial computed: a generator's sizes, a truth, or a set's size.
Where an operation of a tutorial is ours too, the inputs are those of the tutorial: tutorial/3_functions.cpp and
7_interface.cpp, plugins/synthesis/tutorial/syn_1_simple.lua and .py of libFAUDES 2.33.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import pytest
from tests.io.foreign import peers
from tests.io.foreign.odd_automata import MODELS, said

import thenar
from thenar.errors import ModelError
from thenar.explicit.abstraction import is_nonconflicting_by_abstraction
from thenar.explicit.nondeterminism import determinise
from thenar.explicit.regular import concatenation, difference, inverse_project, kleene_star, prefix_closure, union
from thenar.io.foreign import faudes, faudes_xml
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.extended import ExtendedAutomaton

FOLDER = MODELS / "faudes"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"no {FOLDER}: models of others are no part of the project")

SIZES = ("States", "Transitions", "Marked")  # not the events: intersections keep the common ones there, all here


def read(name: str) -> Automaton | ExtendedAutomaton:
    path = next(FOLDER.rglob(f"{name}.gen"))
    return faudes.loads(path.read_bytes(), str(path))


def generator(name: str) -> Automaton:
    a = read(name)
    assert isinstance(a, Automaton)
    return a


def nondeterministic(name: str) -> ExtendedAutomaton:
    a = read(name)
    assert isinstance(a, ExtendedAutomaton)
    return a


def answers(protocol: str) -> list[tuple[str, dict[str, int] | bool]]:
    """Return the marks of a protocol with a truth, or the sizes of a generator or a set."""
    text = next(FOLDER.rglob(protocol)).read_text()
    found: list[tuple[str, dict[str, int] | bool]] = []
    for mark, body in re.findall(r"%%% test mark: (.*?) *\[at[^\n]*\n(.*?)(?=%%%|\Z)", text, re.DOTALL):
        if truth := re.search(r"<Boolean>\s*(true|false)", body):
            found.append((mark, truth[1] == "true"))
        else:
            sizes = {name: int(n) for name, n in re.findall(r"(States|Events|Transitions|Size): +(\d+)", body)}
            marked = re.search(r"Init/Marked: +\d+/(\d+)", body)
            found.append((mark, {**sizes, **({"Marked": int(marked[1])} if marked else {})}))
    return found


def sizes(a: Automaton) -> dict[str, int]:
    return {"States": a.n_states, "Transitions": a.n_transitions, "Marked": int(a.marked.sum())}


def nonblocking(*numbers: int) -> bool:
    return bool(is_nonconflicting_by_abstraction(*(generator(f"noblo_g{k}") for k in numbers)))


FUNCTIONS: dict[str, Callable[[], Automaton | bool]] = {
    "automaton": lambda: thenar.complement(thenar.complement(generator("automaton_g"))),
    "deterministic": lambda: determinise(nondeterministic("deterministic_nondet")),
    "minimal": lambda: thenar.minimize(generator("minimal_nonmin")),
    "project": lambda: thenar.minimize(thenar.project(generator("project_g"), ["a", "c", "e", "g"])),
    "parallel": lambda: thenar.sync(generator("parallel_g1"), generator("parallel_g2")),
    "boolean union": lambda: union(generator("boolean_g1"), generator("boolean_g2")),
    "boolean inter": lambda: thenar.meet(generator("boolean_g1"), generator("boolean_g2")),
    "boolean compl": lambda: thenar.complement(thenar.trim(generator("boolean_g1"))),
    "boolean equal": lambda: same_marked_language("lequal_g1", "lequal_g2"),
    "difference": lambda: thenar.trim(difference(generator("difference_g1"), generator("difference_g2"))),
    "concat": lambda: concatenation(generator("concat_g5"), generator("concat_g6")),
    "kleene closure 1": lambda: kleene_star(generator("kleene_g1")),
    "kleene closure 2": lambda: kleene_star(generator("kleene_g2")),
    "prefix closure": lambda: prefix_closure(generator("prefixclosure_g")),
    "nonblocking 1": lambda: nonblocking(2, 3, 4, 5),
    "nonblocking 2": lambda: nonblocking(5, 6, 7, 8, 9),
    "nonblocking 3": lambda: nonblocking(3, 4, 5, 6, 7),
    "nonblocking 4": lambda: nonblocking(1, 3, 5, 7),
    "nonblocking 9a": lambda: bool(thenar.is_nonconflicting(generator("noblo_yt1"), generator("noblo_yt2"))),
    "nonblocking 9b": lambda: bool(is_nonconflicting_by_abstraction(generator("noblo_yt1"), generator("noblo_yt2"))),
}


def same_marked_language(a: str, b: str) -> bool:
    first, second = (thenar.trim(generator(name)) for name in (a, b))
    return bool(thenar.is_sublanguage(first, second)) and bool(thenar.is_sublanguage(second, first))


@pytest.mark.parametrize("mark", FUNCTIONS)
def test_functions(mark: str) -> None:
    given: dict[str, dict[str, int] | bool] = {}
    for name, answer in answers("3_functions_cpp.prot"):
        twice = name == "kleene closure"
        given[f"{name} {1 + (f'{name} 1' in given)}" if twice else name] = answer
    check(FUNCTIONS[mark](), given[mark])


def check(ours: Automaton | bool, theirs: dict[str, int] | bool) -> None:
    if isinstance(theirs, bool):
        assert ours == theirs
    else:
        assert isinstance(ours, Automaton)
        assert sizes(ours) == {name: theirs[name] for name in SIZES}


def test_interface() -> None:
    given = dict(answers("7_interface_cpp.prot"))
    product = thenar.sync(generator("simplemachine"), generator("buffer"))
    check(product, given["rti parallel"])


# -- two machines and a buffer -------------------------------------------------------------------------------


def version(a: Automaton, suffix: str) -> Automaton:
    """Return ``a`` with a suffix on its events, as libFAUDES's Version does."""
    return replace(a, alphabet=Alphabet(replace(e, name=f"{e.name}_{suffix}") for e in a.alphabet))


def under(a: Automaton, alphabet: Alphabet) -> Automaton:
    """Return a generator that says nothing of control, with the events of the plant."""
    return replace(a, alphabet=Alphabet(alphabet[e] for e in a.alphabet.names))


def test_synthesis() -> None:
    given = dict(answers("syn_1_simple_lua.prot"))
    machine = generator("verysimplemachine")
    plant = thenar.sync(version(machine, "1"), version(machine, "2"))
    path = FOLDER / "synthesis" / "buffer.gen"  # there is another one in corefaudes
    buffer = faudes.loads(path.read_bytes(), path.name)
    assert isinstance(buffer, Automaton)
    spec = inverse_project(under(buffer, plant.alphabet), plant.alphabet)
    assert bool(thenar.is_controllable(spec, plant)) == given["spec controllable"]
    supervisor = thenar.supcon(plant, spec)
    for mark in ("super", "supervisor"):
        check(supervisor, given[mark])
    check(supervisor, dict(answers("syn_1_simple_py.prot"))["gK"])
    assert bool(thenar.is_controllable(supervisor, plant)) == given["super controllable"]
    closed = [replace(a, marked=a.marked | True) for a in (plant, spec)]
    super_cl = given["super cl"]
    assert isinstance(super_cl, dict)
    assert sizes(thenar.supcon(*closed))["States"] == super_cl["States"]
    assert sizes(thenar.supcon(*closed))["Transitions"] == super_cl["Transitions"]


def test_relative_closure() -> None:
    given = dict(answers("syn_1_simple_lua.prot"))
    machine = generator("verysimplemachine")
    plant = thenar.sync(version(machine, "1"), version(machine, "2"))
    path = FOLDER / "synthesis" / "buffer.gen"
    buffer = faudes.loads(path.read_bytes(), path.name)
    assert isinstance(buffer, Automaton)
    spec = inverse_project(under(buffer, plant.alphabet), plant.alphabet)
    supervisor = thenar.supcon(plant, spec)
    assert bool(thenar.is_relatively_closed(supervisor, plant)) == given["super relclosed"]


@pytest.mark.parametrize("k", [1, 2])
def test_reduction(k: int) -> None:
    """The states are as many; our transitions are more, as events that never move the supervisor stay in it."""
    wanted = dict(answers("syn_3_reduction_lua.prot"))[f"red{k}"]
    assert isinstance(wanted, dict)
    plant, supervisor = (faudes.loads((FOLDER / "synthesis" / f"{n}{k}.gen").read_bytes(), n) for n in ("plant", "sup"))
    assert isinstance(plant, Automaton)
    assert isinstance(supervisor, Automaton)
    assert thenar.supreduce(plant, supervisor).n_states == wanted["States"]


# -- every file ----------------------------------------------------------------------------------------------


def files() -> list[str]:
    return sorted(str(path.relative_to(FOLDER)) for path in FOLDER.rglob("*.gen")) if FOLDER.is_dir() else []


@pytest.mark.parametrize("name", files())
def test_every_generator_loads_and_comes_back(name: str) -> None:
    a = faudes.loads((FOLDER / name).read_bytes(), name)
    for form in (faudes, faudes_xml):
        again = form.loads("".join(form.dumps(a).chunks).encode(), name)
        if form.dumps(a).names is None:
            assert (said(again), again.name) == (said(a), a.name)


def test_libfaudes_finds_in_every_generator_what_is_found_here() -> None:
    data = {name: (FOLDER / name).read_bytes() for name in files()}
    data = {name: file for name, file in data.items() if b"cGenerator" not in file and b"aGenerator" not in file}
    assert len(data) > 50
    for (name, file), (text, xml) in zip(data.items(), peers.faudes_rewrites(list(data.values())), strict=True):
        events, *rest = said(faudes.loads(file, name))
        for theirs in (text, xml):
            its_events, *its_rest = said(faudes.loads(theirs, name))
            assert set(its_events) == set(events), name  # type: ignore[call-overload]
            assert its_rest == rest, name


def test_a_set_of_events_is_no_generator() -> None:
    path = FOLDER / "corefaudes" / "alphabeta.xml"
    with pytest.raises(ModelError, match="no section <Generator>"):
        faudes_xml.loads(path.read_bytes(), path.name)
