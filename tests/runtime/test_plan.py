"""Policies: the shortest one is as good as a slow obvious twin says that one can be."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from tests.runtime.conftest import GOALS, Task
from tests.runtime.fake import FakeDriver

from thenar.errors import Fault, InputError, ModelError, UnknownName
from thenar.explicit.components import strong_components
from thenar.explicit.products import sync
from thenar.library.glr.automata import ERROR_FREE
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.runtime.driver import Detector, Skill
from thenar.runtime.plan import CAP_S, PENALTY_S, Shortest
from thenar.runtime.policy import Operator, Priority, RandomPolicy, policy_named
from thenar.synthesis.api import synthesize
from thenar.testing.strategies import problems

Cell = tuple[int, frozenset[str]]


class Oracle:
    """The same Markov decision process in plain Python, one state at a time, as the docstring of Shortest says it."""

    def __init__(self, supervisor: Supervisor, driver: FakeDriver, through: Iterable[str]) -> None:
        self.S, self.driver, self.through = supervisor.automaton, driver, frozenset(through)
        self.cells = self.reachable()
        self.value: dict[Cell, float] = dict.fromkeys(self.cells, CAP_S)
        while True:
            new = {cell: self.best(cell) for cell in self.cells}
            change = max(self.value[c] - new[c] for c in self.cells)
            self.value = new
            if change <= 1e-12:
                break

    def after(self, cell: Cell, event: str) -> Cell:
        x, done = cell
        target = self.S.step(x, event)
        assert target is not None
        return target, (frozenset() if self.S.marked[x] else done) | ({event} & self.through)

    def reachable(self) -> list[Cell]:
        cells: list[Cell] = [(self.S.initial, frozenset())]
        for cell in cells:
            for e in self.S.enabled(cell[0]):
                if (target := self.after(cell, e.name)) not in cells:
                    cells.append(target)
        return cells

    def wait(self, cell: Cell) -> float:
        free = [self.driver.detectors[e.name] for e in self.S.enabled(cell[0]) if not e.controllable]
        if not free:
            return math.inf
        total = sum(d.odds for d in free)
        weights = [d.odds / total if total else 1 / len(free) for d in free]
        return sum(
            w * (d.expected_s + self.value[self.after(cell, d.event)]) for w, d in zip(weights, free, strict=True)
        )

    def start(self, cell: Cell, event: str) -> float:
        skill = self.driver.skills[event]
        cost, there = max(skill.expected_s, self.driver.period_s), self.value[self.after(cell, event)]
        free = [self.driver.detectors[e.name] for e in self.S.enabled(cell[0]) if not e.controllable]
        total = sum(d.odds for d in free)
        if skill.commit == "command" or not total:
            return cost + there
        first = 1 - math.prod(1 - d.odds for d in free)
        interrupted = sum(d.odds / total * self.value[self.after(cell, d.event)] for d in free)
        return cost + first * interrupted + (1 - first) * there

    def best(self, cell: Cell, here: bool = False) -> float:
        """Return the value of a cell: of one on the way, or of the one where the run is now."""
        x, done = cell
        events = [e.name for e in self.S.enabled(x) if e.controllable]
        if not self.S.marked[x]:
            return min([CAP_S, self.wait(cell), *(self.start(cell, e) for e in events)])
        onward = [self.start(cell, e) for e in events if here or not self.comes_back(x, self.after(cell, e)[0])]
        return min([PENALTY_S * len(self.through - done), *onward])

    def comes_back(self, x: int, target: int) -> bool:
        seen = [target]
        for q in seen:
            seen += [t for _, t in self.S.row(q) if t not in seen and not seen.append(t)]  # type: ignore[func-returns-value]
        return x in seen


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])
@given(problems(max_events=5, max_plants=2, max_specs=1, max_states=3), st.integers(0, 10**6))
def test_no_policy_has_a_shorter_expected_time(problem: Problem, seed: int) -> None:
    supervisor = synthesize(problem).supervisor
    assume(not supervisor.is_empty)
    rng = Random(seed)
    alphabet = supervisor.automaton.alphabet
    skills = {
        e.name: Skill(e.name, rng.choice(["command", "achievement"]), rng.uniform(0.1, 2.0), 9.0)
        for e in alphabet
        if e.controllable
    }
    detectors = {
        e.name: Detector(e.name, rng.choice([0.0, 0.05, 0.3]), rng.uniform(0.1, 2.0), 9.0)
        for e in alphabet
        if not e.controllable
    }
    plant = sync(*problem.plants)
    driver = FakeDriver(plant, alphabet, rng, skills=skills, detectors=detectors)
    through = alphabet.names[: rng.randint(0, 2)]
    policy, oracle = Shortest(supervisor, driver, through=through), Oracle(supervisor, driver, through)
    for cell in oracle.cells:
        found = policy.expected_s(cell[0], map(alphabet.index, cell[1]))
        assert found == pytest.approx(oracle.best(cell, here=True), rel=1e-6)


def test_the_choice_is_one_of_the_least_expected_times(task: Task) -> None:
    policy = Shortest(task.supervisor, task.driver(), through=GOALS)
    S, events = task.supervisor.automaton, task.supervisor.automaton.alphabet
    lifted = S.run("approach_1, approach_2, align_finger2*, prox_make_C1, suppress_vib1, orient_normal1, prox_make_C2, "
                   "suppress_vib2, orient_normal2, apply_gripF*, apply_loadF*, remote_breakC*")[-1]  # fmt: skip
    choices = [events.index(e) for e in S.enabled(lifted) if e.controllable]
    best = policy.choose(lifted, choices, may_wait=False)
    assert best == events.index("dec_gripF*")
    assert policy.choose(lifted, [e for e in choices if e != best], may_wait=False) == events.index("move_to_Z*")


@pytest.mark.parametrize("seed", range(6))
def test_the_papers_task_is_found_however_long_its_steps_take(task: Task, seed: int) -> None:
    driver, rng = task.driver(seed), Random(seed)
    driver.skills = {n: replace(s, expected_s=rng.uniform(0.2, 2.0), limit_s=9.0) for n, s in driver.skills.items()}
    run = task.run(driver)
    assert run.discrete_success
    assert sorted(run.trace) == sorted(ERROR_FREE.split(", "))


def test_a_goal_counts_from_the_last_marked_state_on() -> None:
    plant = Automaton.from_transitions(["0 -a-> 1 -b-> 2 -c-> 3 -d-> 4", "1 -d-> 4"], initial="0", marked=["2", "4"])
    supervisor = synthesize(Problem([plant])).supervisor
    names = supervisor.automaton.alphabet
    policy = Shortest(supervisor, FakeDriver(plant, names, Random(0)), through=["a"])
    policy.saw(names.index("a"), 1)
    assert policy.expected_s(1) == pytest.approx(0.02)
    policy.saw(names.index("b"), supervisor.automaton.run("a, b")[-1])
    assert policy.choose(supervisor.automaton.run("a, b")[-1], [names.index("c")], may_wait=False) is None


def test_of_equal_choices_the_first_of_the_alphabet_is_taken() -> None:
    plant = Automaton.from_transitions(["0 -c,a,b-> 1"], initial="0", marked=["1"], events=["b", "a", "c"])
    supervisor = synthesize(Problem([plant])).supervisor
    policy = Shortest(supervisor, FakeDriver(plant, supervisor.automaton.alphabet, Random(0)))
    assert policy.choose(0, [0, 1, 2], may_wait=False) == 0
    assert policy.choose(0, [2, 1], may_wait=False) == 1


def test_idle_commands_are_never_preferred_to_the_end() -> None:
    plant = Automaton.from_transitions(["0 -spin-> 0", "0 -go-> 1"], initial="0", marked=["1"])
    supervisor = synthesize(Problem([plant])).supervisor
    skills = {"spin": Skill("spin", "command", 0.0, 1.0), "go": Skill("go", "achievement", 5.0, 9.0)}
    policy = Shortest(supervisor, FakeDriver(plant, plant.alphabet, Random(0), skills=skills))
    assert policy.expected_s(0) == 5.0
    assert policy.choose(0, [0, 1], may_wait=False) == plant.alphabet.index("go")


def test_a_plan_says_what_it_cannot_do(task: Task) -> None:
    driver = task.driver()
    with pytest.raises(UnknownName, match="did you mean 'dec_gripF"):
        Shortest(task.supervisor, driver, through=["dec_grip*"])
    with pytest.raises(InputError, match="at most 8 events, not 9"):
        Shortest(task.supervisor, driver, through=task.supervisor.automaton.alphabet.names[:9])
    driver.skills = {}
    with pytest.raises(ModelError, match="no skill"):
        Shortest(task.supervisor, driver)


@given(st.integers(0, 10**6))
def test_states_of_one_component_reach_each_other(seed: int) -> None:
    rng = Random(seed)
    n = rng.randint(1, 7)
    rows = [sorted({rng.randrange(n) for _ in range(rng.randint(0, 2))}) for _ in range(n)]
    reach = np.eye(n, dtype=bool)
    for q, row in enumerate(rows):
        reach[q, row] = True
    for _ in range(n):
        reach = reach @ reach
    offsets = np.cumsum([0, *map(len, rows)]).tolist()
    component = strong_components(offsets, [t for row in rows for t in row])
    assert ((component[:, None] == component) == (reach & reach.T)).all()


def test_priority_takes_the_first_of_its_list_and_waits_for_what_is_listed(task: Task) -> None:
    names = task.supervisor.automaton.alphabet
    state = task.supervisor.automaton.run("approach_1, approach_2")[-1]
    choices = [names.index(e) for e in task.supervisor.automaton.enabled(state) if e.controllable]
    first = Priority(task.supervisor, ["align_finger2*", "detect_misalignment*"])
    waits = Priority(task.supervisor, ["detect_misalignment*", "align_finger2*"])
    assert first.choose(state, choices, may_wait=True) == names.index("align_finger2*")
    assert waits.choose(state, choices, may_wait=True) is None
    assert waits.choose(state, choices, may_wait=False) == names.index("align_finger2*")


def test_policies_are_known_by_name(task: Task) -> None:
    driver = task.driver()

    def named(text: str) -> object:
        return policy_named(text, task.supervisor, driver, seed=7, through=GOALS, ask=lambda text: "q")

    assert isinstance(named("shortest"), Shortest)
    assert isinstance(named("operator"), Operator)
    assert isinstance(named(" priority ( move_to_Z*, dec_gripF* )"), Priority)
    drawn = [named(text) for text in ("random", "random(7)", "random(8)")]
    runs = [[p.choose(0, range(100), False) for _ in range(5)] for p in drawn if isinstance(p, RandomPolicy)]
    assert runs[0] == runs[1] != runs[2]


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("shortes", UnknownName, "unknown policy 'shortes'; did you mean 'shortest'?"),
        ("", UnknownName, "unknown policy ''"),
        ("priority(move_to_Y*)", UnknownName, "unknown event 'move_to_Y*'; did you mean 'move_to_Z*'?"),
        ("random(x)", InputError, "policy 'random(x)': random takes one whole number, its seed, as in 'random(7)'"),
        ("random(1, 2)", InputError, "policy 'random(1, 2)': random takes one whole number"),
        ("shortest(3)", InputError, "policy 'shortest(3)': shortest takes no arguments"),
        ("random(", UnknownName, "unknown policy 'random('; did you mean 'random'?"),
    ],
)
def test_a_policy_that_does_not_exist_is_one_clear_error(
    task: Task, text: str, error: type[Exception], message: str
) -> None:
    with pytest.raises(error) as caught:
        policy_named(text, task.supervisor, task.driver())
    assert str(caught.value).startswith(message)


def test_an_operator_who_is_gone_stops_the_run(task: Task) -> None:
    def gone(text: str) -> str:
        raise EOFError

    with pytest.raises(Fault, match="the operator stopped the run"):
        Operator(task.supervisor, gone).choose(0, [0], may_wait=False)


def test_one_plan_serves_many_runs(task: Task) -> None:
    policy = Shortest(task.supervisor, task.driver(), through=GOALS)
    runs = [task.run(task.driver(seed, other=0.002), policy=policy) for seed in (1, 2, 1)]
    assert runs[0].entries == runs[2].entries == task.run(task.driver(1, other=0.002)).entries
