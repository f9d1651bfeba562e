"""The policy of least cost keeps to the plan of cost_to_go, and does what the task is for."""

from __future__ import annotations

import math
from random import Random
from typing import Any

import numpy as np
import pytest
from tests.runtime.conftest import GOALS, Task

import thenar
from thenar.errors import InputError, UnknownName
from thenar.explicit.cost import Case, CostToGo, cost_to_go
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.runtime.cheapest import Cheapest
from thenar.runtime.plan import Shortest
from thenar.runtime.policy import policy_named
from thenar.synthesis.api import synthesize
from thenar.testing import cost_oracle
from thenar.testing.random_models import random_alphabet, random_automaton


def drawn(seed: int) -> tuple[Supervisor, dict[str, float]]:
    """A supervisor of a small plant, and costs."""
    rng = Random(seed)
    plant = random_automaton(rng, random_alphabet(rng, max_events=5), max_states=6)
    costs = {e: rng.choice([1.0, 2.0, 3.0, 5.0]) for e in plant.alphabet.names}
    return synthesize(Problem([plant])).supervisor, costs


def decision(policy: Cheapest, S: Automaton, q: int) -> str | None:
    """What the policy does in state ``q`` if all is ready, and it may wait."""
    policy.begin()
    trace = thenar.shortest_trace(S, q)
    assert trace is not None
    for e, x in zip(trace, S.run(trace)[1:], strict=True):
        policy.saw(S.alphabet.index(e), x)
    chosen = policy.choose(q, [S.alphabet.index(e) for e in S.enabled(q) if e.controllable], may_wait=True)
    return None if chosen is None else S.alphabet[chosen].name


def test_who_follows_it_never_pays_more_than_the_least_worst_cost() -> None:
    compared = 0
    for seed in range(300):
        supervisor, costs = drawn(seed)
        S = supervisor.automaton
        if S.is_empty:
            continue
        policy = Cheapest(supervisor, costs, case="worst")
        decisions = {q: None if S.marked[q] else decision(policy, S, q) for q in range(S.n_states)}
        paid = cost_oracle.strings_cost(S, costs, decisions)
        for value, least in zip(paid, cost_to_go(S, costs, case="worst").values, strict=True):
            assert math.isinf(least) or value == least, seed
            compared += 0 < least < math.inf
    assert compared > 200


def test_who_follows_it_pays_the_least_expected_cost() -> None:
    compared = 0
    for seed in range(300):
        supervisor, costs = drawn(seed)
        S = supervisor.automaton
        if S.is_empty:
            continue
        weights = {e.name: 1.0 + len(e.name) for e in S.alphabet}
        policy = Cheapest(supervisor, costs, case="expected", weights=weights)
        decisions = {q: None if S.marked[q] else decision(policy, S, q) for q in range(S.n_states)}
        paid = [float(v) for v in cost_oracle.mean_cost(S, costs, weights, decisions)]
        least = cost_to_go(S, costs, case="expected", weights=weights).values
        sure = np.isfinite(least)
        np.testing.assert_allclose(np.array(paid)[sure], least[sure], rtol=1e-9)
        compared += int((least[sure] > 0).sum())
    assert compared > 200


@pytest.mark.parametrize("case", ["best", "worst"])
def test_the_papers_task_is_done(task: Task, case: Case) -> None:
    for seed in range(5):
        policy = Cheapest(task.supervisor, case=case, through=GOALS)
        assert task.run(task.driver(seed), policy=policy).outcome == "complete"


def test_with_the_seconds_of_skills_as_costs_and_nothing_in_between_it_is_the_shortest(task: Task) -> None:
    driver = task.driver()
    seconds = {e: skill.expected_s for e, skill in driver.skills.items()}
    seconds |= {e: detector.expected_s for e, detector in driver.detectors.items()}
    cheapest = Cheapest(task.supervisor, seconds, through=GOALS)
    done = task.run(task.driver(), policy=cheapest)
    also = task.run(task.driver(), policy=Shortest(task.supervisor, driver, through=GOALS))
    assert done.trace == also.trace


@pytest.mark.parametrize(
    ("case", "through", "plans"), [("best", [], 1), ("best", ["c0"], 2), ("worst", [], 2), ("worst", ["c0"], 3)]
)
def test_no_plan_is_made_twice(case: Case, through: list[str], plans: int, monkeypatch: pytest.MonkeyPatch) -> None:
    plant = Automaton.from_transitions(["0 -c0-> 1 -c1-> 0"], initial="0", marked=["0"])
    made: list[Automaton] = []

    def noted(automaton: Automaton, *args: Any, **more: Any) -> CostToGo:
        made.append(automaton)
        return cost_to_go(automaton, *args, **more)

    monkeypatch.setattr("thenar.runtime.cheapest.cost_to_go", noted)
    Cheapest(synthesize(Problem([plant])).supervisor, case=case, through=through)
    assert len(made) == plans


def test_a_cost_makes_it_go_another_way() -> None:
    plant = Automaton.from_transitions(["0 -fly-> 1", "0 -walk-> 2 -walk-> 1"], initial="0", marked=["1"])
    supervisor = synthesize(Problem([plant])).supervisor
    fly, walk = (supervisor.automaton.alphabet.index(e) for e in ("fly", "walk"))
    for text, chosen in (("cheapest", fly), ("cheapest(fly=2.5)", walk), ("cheapest( worst fly=1.5, best )", fly)):
        assert policy_named(text, supervisor, None).choose(0, [fly, walk], False) == chosen  # type: ignore[arg-type]
    # what is best does not get ready, so that it is not among the choices
    assert policy_named("cheapest", supervisor, None).choose(0, [walk], False) == walk  # type: ignore[arg-type]


def test_where_the_goal_is_lost_it_goes_to_any_marked_state() -> None:
    plant = Automaton.from_transitions(
        ["0 -work-> 1 -done-> home", "1 -fail-> lost -back-> home", "lost -roam-> lost"],
        initial="0",
        marked=["home"],
        uncontrollable=["done", "fail"],
    )
    supervisor = synthesize(Problem([plant])).supervisor
    S = supervisor.automaton
    policy = Cheapest(supervisor, through=["done"])
    for event in ("work", "fail"):
        policy.saw(S.alphabet.index(event), 0)
    back, roam = S.alphabet.index("back"), S.alphabet.index("roam")
    lost = S.run("work, fail")[-1]
    assert policy.choose(lost, [roam, back], False) == back
    policy.saw(back, 0)
    assert policy.choose(S.run("work, fail, back")[-1], [], False) is None


def test_what_it_cannot_plan_is_refused() -> None:
    supervisor, _ = drawn(1)
    for text in ("cheapest(3)", "cheapest(c0=-1)", "cheapest(c0=)", "cheapest(expected)"):
        with pytest.raises(InputError, match="cheapest takes best, worst and costs"):
            policy_named(text, supervisor, None)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="unknown event 'nothing'"):
        policy_named("cheapest(nothing=3)", supervisor, None)  # type: ignore[arg-type]
    nothing = Automaton.empty(supervisor.automaton.alphabet)
    with pytest.raises(InputError, match="no supervisor exists"):
        Cheapest(Supervisor(nothing, np.zeros(1, np.int64), np.zeros(0, np.int32)))
