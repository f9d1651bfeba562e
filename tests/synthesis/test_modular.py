"""Modular synthesis: many small supervisors are the one large supervisor, and say so for the right reason."""

import dataclasses
import time
from collections import Counter
from collections.abc import Iterator
from random import Random

import pytest

import thenar
from thenar.errors import InputError, LimitReached, UnknownName
from thenar.library import glr
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem, compose
from thenar.synthesis import modular
from thenar.synthesis.modular import Group, ModularResult, synthesize_modular
from thenar.testing import random_extended_problem, random_problem
from thenar.testing.random_models import PLANT, random_automaton

ENGINES = ("auto", "explicit", "symbolic")
BATCH = 100


def renamed(problem: Problem, tag: str, shared: dict[str, str]) -> Problem:
    """The same problem with other names; two problems are coupled by the events that both call the same."""

    def again(a: Automaton) -> Automaton:
        events = (dataclasses.replace(e, name=shared.get(e.name, f"{e.name}_{tag}")) for e in a.alphabet)
        return dataclasses.replace(a, alphabet=Alphabet(events), name=f"{a.name}_{tag}")

    return Problem([again(p) for p in problem.plants], [again(s) for s in problem.specs])


def coupled_problem(seed: int) -> Problem:
    """Two or three small random problems, which share none, one or two events."""
    rng = Random(seed)
    pieces = []
    for tag in "abc"[: rng.randint(2, 3)]:
        piece = random_problem(rng, max_events=5, max_plants=2, max_specs=2, max_states=3)
        shared = {}
        for kind, name in ((True, "c"), (False, "u")):
            known = [e.name for e in piece.alphabet if e.controllable == kind]
            if known and rng.random() < 0.5:
                shared[rng.choice(known)] = name
        pieces.append(renamed(piece, tag, shared))
    return compose(pieces)


def problems(seeds: range) -> Iterator[Problem]:
    for seed in seeds:
        yield random_problem(Random(seed), max_plants=4, max_events=10) if seed % 2 else coupled_problem(seed)


def supervised(result: ModularResult) -> Automaton:
    """The closed loop, built from what the result consists of."""
    parts: list[Automaton] = []
    for group in result.groups:
        parts += [group.closed_loop.supervisor.automaton] if group.route == "coordinated" else group.parts
    return thenar.sync(*parts)


def check(problem: Problem, result: ModularResult) -> None:
    """Compare with the supervisor of the whole: verdict, states, transitions, marks."""
    whole = thenar.synthesize(problem, "explicit")
    assert bool(result) == bool(whole)
    assert result.size == whole.size
    if whole:
        same = thenar.is_isomorphic(supervised(result), whole.supervisor.automaton)
        assert same, f"{problem}: {same}"


# -- the theorems ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("seeds", [range(k, k + BATCH) for k in range(0, 600, BATCH)], ids=str)
def test_verdict_and_closed_loop_are_those_of_the_whole(seeds: range, engine: str) -> None:
    routes = Counter[str]()
    for problem in problems(seeds):
        result = synthesize_modular(problem, engine=engine)
        check(problem, result)
        routes.update(g.route for g in result.groups)
    assert min(routes[r] for r in ("local", "coordinated", "none")) > BATCH // 20  # no route is a rare one


@pytest.mark.parametrize("engine", ["auto", "symbolic"])
def test_after_a_trace_the_supervisors_together_say_what_the_one_says(engine: str) -> None:
    for seed, problem in enumerate(problems(range(200))):
        whole, result = thenar.synthesize(problem, "explicit"), synthesize_modular(problem, engine=engine)
        if not whole:
            assert result.after("ε") is None
            continue
        trace = thenar.random_trace(whole.supervisor, 12, seed)
        for k in range(len(trace) + 1):
            pattern = whole.supervisor.after(trace[:k])
            assert pattern is not None
            assert result.after(trace[:k]) == pattern
            for event in problem.alphabet:
                if event not in pattern.enabled:
                    assert result.after([*trace[:k], event.name]) is None


def test_a_local_supervisor_loses_nothing_and_asks_for_nothing_that_cannot_be_done() -> None:
    """The two halves of the proof: an upper bound of every supervisor of the whole, and controllable by itself."""
    needed = 0
    for problem in problems(range(300)):
        whole = thenar.synthesize(problem, "explicit").supervisor.automaton
        for group in synthesize_modular(problem).groups:
            for local in group.locals:
                if local.result is None:
                    free = not local.plants or thenar.is_controllable(local.specs, problem.plants)
                    assert free
                    continue
                supervisor = local.result.supervisor.automaton
                needed += 1
                if not whole.is_empty:
                    seen = thenar.project(whole, supervisor.alphabet.names)
                    assert thenar.is_sublanguage(seen, supervisor)
                assert thenar.is_controllable(supervisor, problem.plants)
                assert thenar.is_nonblocking(supervisor)
    assert needed > 100


def test_a_specification_that_needs_no_supervisor_is_controllable() -> None:
    for problem in problems(range(200)):
        for group in synthesize_modular(problem).groups:
            for local in group.locals:
                if local.result is None:
                    assert thenar.is_controllable(local.specs, problem.plants)


def test_the_local_route_is_taken_exactly_if_there_is_no_conflict() -> None:
    for problem in problems(range(300)):
        for group in synthesize_modular(problem).groups:
            if group.route != "none":
                assert bool(thenar.is_nonconflicting(*group.parts)) == (group.route == "local")


def test_independent_groups_multiply() -> None:
    for seed in range(100):
        pieces = [renamed(random_problem(Random(1000 * seed + k), max_events=6), str(k), {}) for k in range(3)]
        alone = [synthesize_modular(p) for p in pieces]
        together = synthesize_modular(compose(pieces))
        assert bool(together) == all(alone)
        if together:
            assert len(together.groups) == sum(len(x.groups) for x in alone)
            assert together.n_states == alone[0].n_states * alone[1].n_states * alone[2].n_states
        else:
            assert together.groups[-1].route == "none"
            assert together.n_states == 0
            assert together.supervisors == ()


# -- the routes --------------------------------------------------------------------------------------------------


def test_what_is_too_large_locally_is_left_to_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(modular, "LOCALLY", 3)
    opened = 0
    for engine in ENGINES:
        for problem in problems(range(150)):
            result = synthesize_modular(problem, engine=engine)
            check(problem, result)
            opened += sum(local.is_open for g in result.groups for local in g.locals)
    assert opened > 100


def test_conflicts_are_found_by_abstraction_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(modular, "SURELY_SMALL", 0)
    found = Counter[bool]()
    for problem in problems(range(300)):
        result = synthesize_modular(problem, engine="explicit")
        check(problem, result)
        found.update(g.whole is None for g in result.groups if g.route == "local")
    assert found[True] > 100
    assert not found[False]


def test_where_abstraction_gets_too_large_states_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_large(*automata: Automaton, most: int) -> bool:
        raise LimitReached("states", 1, len(automata), 0)

    monkeypatch.setattr(modular, "SURELY_SMALL", 0)
    monkeypatch.setattr(modular, "is_nonconflicting_by_abstraction", too_large)
    for problem in problems(range(50)):
        check(problem, synthesize_modular(problem, engine="explicit"))


def test_supervisors_that_block_in_pairs_are_merged() -> None:
    """The transfer line's two buffers are the textbook's example of a conflict; here one supervisor keeps both."""
    [group] = synthesize_modular(thenar.library.model("transfer_line")).groups
    [local] = group.locals
    assert [s.name for s in local.specs] == ["L1_B1", "L1_B2"]
    assert group.route == "local"
    assert local.result is not None
    assert local.result.size == (28, 65)


def test_a_supervisor_looks_at_no_more_plants_than_it_needs() -> None:
    result = synthesize_modular(thenar.library.model("chain(30)"))
    for k, local in enumerate(result.groups[0].locals, 1):
        assert [p.name for p in local.plants] == [f"MACHINE{k}"]  # who takes from the buffer can be kept from it
        assert local.result is not None
        assert local.result.size.states == 3


def test_a_plant_is_added_if_it_may_know_that_an_event_cannot_happen() -> None:
    """E forbids u at once; G1 could do it, but not together with G2, which first waits for a."""
    events = Alphabet([Event("a"), Event("u", controllable=False)])
    g1 = Automaton.from_transitions(["0 -u-> 0"], initial="0", marked=["0"], events=events, name="G1")
    g2 = Automaton.from_transitions(["0 -a-> 1 -u-> 1"], initial="0", marked=["0", "1"], events=events, name="G2")
    e = Automaton.from_transitions(["0 -a-> 1 -u-> 1"], initial="0", marked=["0", "1"], events=events, name="E")
    result = synthesize_modular(Problem([g1, g2], [e]))
    assert [[p.name for p in x.plants] for x in result.groups[0].locals] == [["G2"]]
    assert result.n_states == 2
    assert result.supervisors == ()
    assert not synthesize_modular(Problem([g1], [e]))


# -- families ----------------------------------------------------------------------------------------------------


def glr_states(fingers: int) -> int:
    """The number of states that docs/grasp-lift-replace.md gives for the task with so many fingers."""
    m: int = fingers - 1
    return sum(c * base**m for c, base in ((4, 115), (4, 99), (13, 63), (66, 18), (-6, 9)))


def pell_lucas(n: int) -> int:
    """Return Q(n): Q(0) = Q(1) = 2, Q(k) = 2 Q(k-1) + Q(k-2)."""
    a, b = 2, 2
    for _ in range(n - 1):
        a, b = b, 2 * b + a
    return b


def assert_the_pages_pieces(fingers: int, group: Group) -> None:
    """A supervisor for each finger that looks at this finger and its specification 3; the rest is obeyed as it is."""
    needed = {x.specs[0].name: [p.name for p in x.plants] for x in group.locals if x.result is not None}
    assert needed == {f"SPEC3_{k}": [f"FINGER{k}"] for k in range(1, fingers + 1)}
    assert len(group.locals) == 3 * fingers - 1
    assert group.route == "local"


@pytest.mark.parametrize("engine", ENGINES)
def test_three_fingers_are_the_whole_tasks_supervisor(engine: str) -> None:
    problem = glr.problem(fingers=3)
    result = synthesize_modular(problem, engine=engine)
    check(problem, result)
    assert_the_pages_pieces(3, result.groups[0])
    whole = thenar.synthesize(problem).supervisor
    trace = thenar.random_trace(whole, 200, seed=1)
    assert all(result.after(trace[:k]) == whole.after(trace[:k]) for k in range(0, 200, 20))


@pytest.mark.parametrize(("fingers", "seconds"), [(10, 1), (100, 60)])
def test_many_fingers_are_solved_in_pieces(fingers: int, seconds: float) -> None:
    problem = glr.problem(fingers=fingers)
    start = time.process_time()
    result = synthesize_modular(problem)
    assert time.process_time() - start < seconds
    assert result.n_states == glr_states(fingers)
    assert_the_pages_pieces(fingers, result.groups[0])
    nominal = glr.nominal(fingers)
    assert result.after(nominal) is not None
    assert result.after([*nominal, "incip_slip*"]) is None


@pytest.mark.parametrize(
    ("model", "states", "groups", "engine"),
    [
        ("transfer_line(50)", 28**50, 50, "auto"),
        ("transfer_line(50)", 28**50, 50, "explicit"),
        ("chain(30)", 2 * 3**29, 1, "auto"),
        ("chain(30)", 2 * 3**29, 1, "explicit"),
        ("small_factory(50)", 3 * 4**49, 1, "explicit"),
        ("small_factory(100, repair_priority=True)", 3 * 4**99, 1, "auto"),  # as a whole, some 200 times the work
        ("dining(50)", pell_lucas(50) - 1, 1, "auto"),
    ],
)
def test_families_have_as_many_states_as_their_formulas_say(model: str, states: int, groups: int, engine: str) -> None:
    result = synthesize_modular(thenar.library.model(model), engine=engine)
    assert result.n_states == states
    assert len(result.groups) == groups
    assert result.seconds < 10


def test_a_ring_that_only_blocks_as_a_whole_gets_a_coordinator() -> None:
    problem = thenar.library.model("dining(12)")
    result = synthesize_modular(problem)
    check(problem, result)
    assert result.how == "1 group, 0 local supervisors, 1 coordinator"
    assert len(result.supervisors) == 1


# -- the door ----------------------------------------------------------------------------------------------------


def test_what_is_not_taken_is_refused_in_a_sentence() -> None:
    with pytest.raises(InputError, match="unknown engine 'symbolik'; did you mean 'symbolic'"):
        synthesize_modular(glr.problem(), engine="symbolik")
    with pytest.raises(InputError, match="modular synthesis takes automata only"):
        synthesize_modular(random_extended_problem(Random(1)))  # type: ignore[arg-type]
    result = synthesize_modular(glr.problem())
    with pytest.raises(UnknownName, match="unknown event 'aproach_1'"):
        result.after("incip_slip*, aproach_1")


def test_events_that_nobody_has_never_happen() -> None:
    plant = Automaton.from_transitions(["0 -a-> 0"], initial="0", marked=["0"], name="G")
    result = synthesize_modular(Problem([plant], alphabet=Alphabet(["a", "b"])))
    assert result.after("a") is not None
    assert result.after("a, b") is None


def test_specifications_and_plants_alone_are_groups() -> None:
    alone = Automaton.from_transitions(["0 -a-> 1", "0 -b-> 2 -b-> 0"], initial="0", marked=["0", "2"], name="E")
    plant = Automaton.from_transitions(["0 -x-> 1", "0 -y-> 0"], initial="0", marked=["0"], name="G")
    problem = Problem([plant], [alone])
    result = synthesize_modular(problem)
    check(problem, result)
    assert [g.route for g in result.groups] == ["coordinated", "local"]
    pattern = result.after("b")
    assert pattern is not None
    assert pattern == thenar.synthesize(problem).supervisor.after("b")
    assert str(pattern) == "enabled: y, b; disabled: x, a"


def test_an_empty_automaton_means_no_supervisor() -> None:
    plant = Automaton.from_transitions(["0 -a-> 0"], initial="0", marked=["0"], name="G")
    result = synthesize_modular(Problem([plant], [Automaton.empty(Alphabet(["a"]), "NOTHING")]))
    assert not result
    assert repr(result) == "ModularResult: no supervisor exists"
    assert result.size == (0, 0)
    assert result.after("ε") is None


def test_limits_hold_and_progress_is_told() -> None:
    calls: list[tuple[int, int]] = []
    synthesize_modular(thenar.library.model("chain(12)"), progress=lambda *x: calls.append(x))
    assert calls
    with pytest.raises(LimitReached, match="states"):
        synthesize_modular(thenar.library.model("chain(8)"), limits=thenar.Limits(states=1000))
    with pytest.raises(LimitReached, match="seconds"):
        synthesize_modular(glr.problem(fingers=3), limits=thenar.Limits(seconds=0.0))


def test_automata_may_be_called_as_a_supervisor_would_be() -> None:
    rng = Random(3)
    alphabet = Alphabet([Event("a"), Event("b", controllable=False)])
    for _ in range(20):
        g, e = (random_automaton(rng, alphabet, shape=PLANT, name=name) for name in ("S(E)", "E"))
        problem = Problem([g], [e, random_automaton(rng, alphabet, name="")])
        check(problem, synthesize_modular(problem))


def test_the_same_input_gives_the_same_result() -> None:
    first, second = (synthesize_modular(coupled_problem(8)) for _ in range(2))
    assert repr(first) == repr(second)
    for a, b in zip(first.groups, second.groups, strict=True):
        assert [p.name for p in a.parts] == [p.name for p in b.parts]
        assert [[p.name for p in x.plants] for x in a.locals] == [[p.name for p in x.plants] for x in b.locals]
