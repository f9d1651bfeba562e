"""The least cost of a closed loop: against all policies one by one, and answers from the literature."""

from __future__ import annotations

import math
import time
from fractions import Fraction
from itertools import product
from random import Random

import numpy as np
import pytest

import thenar
from thenar._native import kernel
from thenar.errors import InputError, LimitReached, UnknownName
from thenar.explicit.cost import Case, CostToGo, cheapest_trace, cost_to_go
from thenar.explicit.linear import System
from thenar.explicit.rows import kept, sources
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.limits import Limits
from thenar.synthesis.optimal import optimal_supervisor
from thenar.testing import cost_oracle
from thenar.testing.random_models import random_alphabet, random_automaton, random_problem

SEEDS = range(1000)
FEW = range(400)


def drawn(seed: int) -> tuple[Automaton, dict[str, float], dict[str, float]]:
    """A small automaton with costs, some of them 0, and weights."""
    rng = Random(seed)
    automaton = random_automaton(rng, random_alphabet(rng, max_events=5), max_states=5)
    costs = {e: float(rng.choice([0, 1, 1, 2, 3, 5])) for e in automaton.alphabet.names}
    weights = {
        e.name: rng.choice([1.0, 2.0, 5.0, math.inf] if e.controllable else [0.0, 1.0, 1.0, 3.0])
        for e in automaton.alphabet
    }
    return automaton, costs, weights


def test_the_least_cost_at_best_is_the_oracles() -> None:
    for seed in SEEDS:
        automaton, costs, _ = drawn(seed)
        assert list(cost_to_go(automaton, costs).values) == cost_oracle.best_cost(automaton, costs), seed


def test_the_worst_cost_is_the_least_that_a_policy_never_exceeds() -> None:
    for seed in SEEDS:
        automaton, costs, _ = drawn(seed)
        found = cost_to_go(automaton, costs, case="worst").values
        assert list(found) == cost_oracle.worst_cost(automaton, costs), seed


def test_the_expected_cost_is_the_least_of_all_policies() -> None:
    for seed in SEEDS:
        automaton, costs, weights = drawn(seed)
        found = cost_to_go(automaton, costs, case="expected", weights=weights)
        exact = [float(v) for v in cost_oracle.expected_cost(automaton, costs, weights)]
        np.testing.assert_allclose(found.values, exact, rtol=1e-9, err_msg=str(seed))
        assert found.error <= 1e-9


def positive(costs: dict[str, float]) -> dict[str, float]:
    return {e: cost + 1.0 for e, cost in costs.items()}


def policies_within(found: CostToGo, policy: cost_oracle.Policy) -> bool:
    """Whether the policy takes choices of least cost only."""
    a = found.automaton
    states = [q for q in range(a.n_states) if not a.marked[q] and math.isfinite(found.values[q])]
    return all(found.waits[q] if policy[q] is None else policy[q] in found.choices(q) for q in states)


def test_the_policies_within_the_choices_are_those_of_least_worst_cost() -> None:
    for seed in FEW:
        automaton, costs, _ = drawn(seed)
        costs = positive(costs)
        found = cost_to_go(automaton, costs, case="worst")
        for policy in cost_oracle.policies(automaton):
            best = cost_oracle.strings_cost(automaton, costs, policy) == list(found.values)
            assert policies_within(found, policy) == best, (seed, policy)


def test_the_policies_within_the_choices_are_those_of_least_expected_cost() -> None:
    for seed in FEW:
        automaton, costs, weights = drawn(seed)
        costs = positive(costs)
        found = cost_to_go(automaton, costs, case="expected", weights=weights)
        for policy in cost_oracle.policies(automaton):
            means = [float(v) for v in cost_oracle.mean_cost(automaton, costs, weights, policy)]
            assert policies_within(found, policy) == np.allclose(means, found.values, rtol=1e-9), (seed, policy)


def test_events_without_cost_lead_round_in_no_circle() -> None:
    for seed in FEW:
        automaton, costs, weights = drawn(seed)
        for case in ("worst", "expected"):
            found = cost_to_go(automaton, costs, case=case, weights=weights)
            for policy in filter(lambda p: policies_within(found, p), cost_oracle.policies(automaton)):
                if case == "worst":
                    values = [float(v) for v in cost_oracle.strings_cost(automaton, costs, policy)]
                else:
                    values = [float(v) for v in cost_oracle.mean_cost(automaton, costs, weights, policy)]
                np.testing.assert_allclose(values, found.values, rtol=1e-9, err_msg=str((seed, policy)))


def test_no_larger_part_of_the_loop_has_the_least_worst_cost_from_all_its_states() -> None:
    """Every set of controllable transitions is tried; everything that is left enabled may happen."""
    tried = 0
    for seed in SEEDS:
        automaton, costs, _ = drawn(seed)
        costs = positive(costs)
        found = cost_to_go(automaton, costs, case="worst")
        finite = np.isfinite(found.values) & ~automaton.marked
        free = automaton.alphabet.uncontrollable[automaton.events]
        open_ = np.flatnonzero(~free & finite[sources(automaton)])
        if not 0 < len(open_) <= 6:
            continue
        for chosen in range(1 << len(open_)):
            keep = np.ones(automaton.n_transitions, np.bool_)
            keep[open_[[not chosen >> k & 1 for k in range(len(open_))]]] = False
            values = cost_oracle.strings_cost(kept(automaton, keep), costs)
            least = all(v == w for v, w in zip(values, found.values, strict=True) if math.isfinite(w))
            goes_on = all(found.waits[q] or any(keep[k] for k in own) for q, own in owned(automaton))
            assert least == (goes_on and not (keep & ~found.chosen)[open_].any()), (seed, chosen)
            tried += 1
    assert tried > 5_000


def owned(automaton: Automaton) -> list[tuple[int, range]]:
    """Each state with the numbers of its transitions."""
    return [(q, range(automaton.offsets[q], automaton.offsets[q + 1])) for q in range(automaton.n_states)]


@pytest.mark.parametrize("case", ["best", "worst", "expected"])
def test_the_optimal_supervisor_is_a_supervisor_with_the_same_least_costs(case: Case) -> None:
    rng, compared = Random(4), 0
    for seed in range(400):
        problem = random_problem(Random(seed))
        supervisor = thenar.synthesize(problem).supervisor
        costs = {e: float(rng.choice([0, 1, 2, 3])) for e in problem.alphabet.names}
        least, found = optimal_supervisor(problem.plants, supervisor, costs, case=case)
        loop = thenar.closed_loop(problem.plants, least)
        assert thenar.is_controllable(least.automaton, problem.plants)
        assert thenar.is_nonblocking(loop)
        values = cost_to_go(loop, costs, case=case).values
        for q, before in pairs(loop, found.automaton):  # and so the loop is part of the one before
            assert values[q] == pytest.approx(found.values[before], rel=1e-8)
            compared += 0 < values[q] < math.inf
    assert compared > 1000


def pairs(part: Automaton, whole: Automaton) -> list[tuple[int, int]]:
    """The states that the same strings lead to."""
    found = [(part.initial, whole.initial)] if not part.is_empty else []
    for q, r in found:
        for event, target in part.row(q):
            there = whole.step(r, part.alphabet[event].name)
            assert there is not None
            if (target, there) not in found:
                found.append((target, there))
    return found


def test_the_cheapest_trace_costs_what_it_says_and_no_trace_costs_less() -> None:
    for seed in SEEDS:
        automaton, costs, _ = drawn(seed)
        found = cheapest_trace(automaton, costs)
        best = cost_oracle.best_cost(automaton, costs)[automaton.initial]
        assert (found is None) == math.isinf(best)
        if found is not None:
            trace, cost = found
            assert automaton.marks(trace)
            assert cost == best == sum(costs[e] for e in trace)


def test_with_equal_costs_the_cheapest_trace_is_the_shortest() -> None:
    for seed in SEEDS:
        automaton, _, _ = drawn(seed)
        found = cheapest_trace(automaton)
        assert (found and found[0]) == thenar.shortest_trace(automaton)


def test_chance_is_kinder_than_an_adversary_and_less_kind_than_a_friend() -> None:
    for seed in SEEDS:
        automaton, costs, _ = drawn(seed)
        best, mean, worst = (cost_to_go(automaton, costs, case=case).values for case in ("best", "expected", "worst"))
        assert (best <= mean * (1 + 1e-9)).all(), seed
        assert (mean <= worst * (1 + 1e-9)).all(), seed


@pytest.mark.parametrize("name", ["agv", "small_factory(6)", "transfer_line(2)"])
def test_large_loops_satisfy_bellmans_equation(name: str) -> None:
    a = thenar.synthesize(thenar.library.model(name)).supervisor.automaton
    costs = {e: 1.0 + k % 3 for k, e in enumerate(a.alphabet.names)}
    v = cost_to_go(a, costs, case="expected").values
    for q in np.flatnonzero(~a.marked).tolist():
        row = [(a.alphabet[e].controllable, costs[a.alphabet[e].name] + v[t]) for e, t in a.row(q)]
        free, started = [x for c, x in row if not c], [x for c, x in row if c]
        moves = [(s + sum(free)) / (1 + len(free)) for s in started] + ([sum(free) / len(free)] if free else [])
        assert v[q] == pytest.approx(min(moves), rel=1e-9)


def test_elimination_solves_what_a_dense_system_solves() -> None:
    rng = np.random.default_rng(3)
    for n in [1, 2, 3, 5, 8, 20, 60] * 10:
        share = rng.random((n, n + 1)) * (rng.random((n, n + 1)) < 0.3)
        share[:, n] += 0.01
        share /= share.sum(axis=1, keepdims=True)
        row, column = np.nonzero(share)
        cost = rng.random(n)
        system = System(row, np.where(column == n, -1, column), share[row, column], cost)
        dense = np.linalg.solve(np.eye(n) - share[:, :n], cost)
        np.testing.assert_allclose(system.eliminate(kernel.Ticker()), dense, rtol=1e-9)


# -- answers from the literature ------------------------------------------------------------------------------


def test_the_shortest_paths_of_a_textbook() -> None:
    """Cormen, Leiserson, Rivest and Stein, Introduction to Algorithms, 3rd ed. 2009, figure 24.6: 0, 8, 9, 5, 7."""
    arcs = {"st": 10, "sy": 5, "tx": 1, "ty": 2, "yt": 3, "yx": 9, "yz": 2, "xz": 4, "zx": 6, "zs": 7}
    for goal, length in {"s": 0, "t": 8, "x": 9, "y": 5, "z": 7}.items():
        graph = Automaton.from_transitions([(a[0], a, a[1]) for a in arcs], initial="s", marked=[goal])
        assert cost_to_go(graph, arcs).value == length
        found = cheapest_trace(graph, arcs, to=goal)
        assert found is not None
        assert found[1] == length


def eggs(floors: int, n: int) -> tuple[Automaton, dict[str, float]]:
    """From which floor on does an egg break?  A drop costs 1, what comes of it nothing."""
    arrows = []
    for f, e in product(range(1, floors + 1), range(1, n + 1)):
        for k in range(1, f + 1):
            air = f"{f},{e},{k}"
            arrows += [
                (f"{f},{e}", f"drop_{k}", air),
                (air, "break", f"{k - 1},{e - 1}"),
                (air, "hold", f"{f - k},{e}"),
            ]
    marked = [f"0,{e}" for e in range(n + 1)]
    hall = Automaton.from_transitions(arrows, initial=f"{floors},{n}", marked=marked, uncontrollable=["break", "hold"])
    return hall, {"break": 0, "hold": 0}


def test_two_eggs_and_a_hundred_floors_take_fourteen_drops() -> None:
    """Konhauser, Velleman and Wagon, Which Way Did the Bicycle Go?, 1996, problem 166."""
    hall, costs = eggs(100, 2)
    found = cost_to_go(hall, costs, case="worst")
    assert found.value == 14
    # drops that leave the egg whole, or lost, with at most 13 more: from floor 9 to floor 14
    assert found.choices(0) == tuple(f"drop_{k}" for k in range(9, 15))


@pytest.mark.parametrize("p", [0.05, 0.2, 0.3, 0.34, 0.45])
def test_the_spider_moves_towards_the_fly_unless_the_fly_moves_much(p: float) -> None:
    """Bertsekas, Dynamic Programming and Optimal Control, vol. I, ch. 7: the spider and the fly.

    The fly moves to either side with probability p.  A spider that is n away comes nearer; only at 1 it may as
    well stay, and then takes 1 / p on average, but 1 / (1 - 2p) if it moves: it moves if p <= 1/3.
    """
    fly = ["away", "to", "still"]
    arrows = ["1 -move-> m1 -away,to-> 1", "m1 -still-> 0", "1 -stay-> s1 -away-> 2", "s1 -to-> 0", "s1 -still-> 1"]
    arrows += [f"{n} -move-> m{n} -away-> {n}" for n in range(2, 6)]
    arrows += [f"m{n} -{e}-> {n - k}" for n in range(2, 6) for k, e in ((2, "to"), (1, "still"))]
    web = Automaton.from_transitions(arrows, initial="1", marked=["0"], uncontrollable=fly)
    weights = {"away": p, "to": p, "still": 1 - 2 * p}
    found = cost_to_go(web, dict.fromkeys(fly, 0), case="expected", weights=weights)
    assert found.value == pytest.approx(min(1 / p, 1 / (1 - 2 * p)), rel=1e-9)
    assert found.choices(0) == (("move",) if p < 1 / 3 else ("stay",))


def walk(n: int) -> Automaton:
    """A walk on 0 .. n that is marked at both ends."""
    alphabet = Alphabet([Event("left", controllable=False), Event("right", controllable=False)])
    inner = np.arange(1, n)
    targets = np.column_stack((inner - 1, inner + 1)).ravel()
    offsets = np.concatenate(([0], np.arange(0, 2 * n - 1, 2), [2 * n - 2]))
    marked = np.zeros(n + 1, np.bool_)
    marked[[0, n]] = True
    return Automaton.from_arrays(alphabet, offsets, np.tile([0, 1], n - 1), targets, marked=marked, initial=n // 3)


@pytest.mark.parametrize("n", [21, 900, 6000])  # a dense system, and two that are eliminated
def test_a_fair_game_lasts_as_long_as_a_textbook_says(n: int) -> None:
    """Feller, An Introduction to Probability Theory, vol. I, XIV.3: from z of n a fair game lasts z (n - z) rounds."""
    found = cost_to_go(walk(n), case="expected")
    z = np.arange(n + 1.0)
    np.testing.assert_allclose(found.values, z * (n - z), rtol=1e-9)


def test_an_unfair_game_lasts_as_long_as_a_textbook_says() -> None:
    """Feller, XIV.3: with q > p from z it lasts (z - n (1 - r^z) / (1 - r^n)) / (q - p), where r = q / p."""
    found = cost_to_go(walk(500), case="expected", weights={"left": 0.6, "right": 0.4})
    z, r = np.arange(501.0), 1.5
    exact = z / 0.2 - 500 / 0.2 * (r ** (z - 500) - r**-500.0) / (1 - r**-500.0)
    np.testing.assert_allclose(found.values, exact, rtol=1e-8, atol=1e-8)


# -- what a float can hold ------------------------------------------------------------------------------------


def throws(n: int, *more: str) -> Automaton:
    """A coin is thrown until n heads come in a row, before or after ``more``."""
    arrows = [*more]
    for k in range(n):
        arrows += [f"t{k} -throw-> a{k} -tails-> t0", f"a{k} -heads-> " + (f"t{k + 1}" if k < n - 1 else "goal")]
    first = "home" if more else "t0"
    return Automaton.from_transitions(arrows, initial=first, marked=["goal"], uncontrollable=["heads", "tails"])


@pytest.mark.parametrize("n", [5, 20, 40, 100, 250, 300, 400])
@pytest.mark.parametrize("tails", [1, 9])
def test_a_run_of_heads_takes_as_many_throws_as_a_textbook_says(n: int, tails: int) -> None:
    """Feller, vol. I, XIII.7: the first run of n successes takes (1 - p^n) / (q p^n) trials, that is Σ 1 / p^k."""
    exact = sum(Fraction(1 + tails) ** k for k in range(1, n + 1))
    found = cost_to_go(throws(n), {"heads": 0, "tails": 0}, case="expected", weights={"heads": 1, "tails": tails})
    if exact > Fraction(1.7e308):
        assert found.value == math.inf
    else:
        assert abs(Fraction(found.value) / exact - 1) <= Fraction(found.error) <= 1e-9


def test_twenty_heads_in_a_row_are_dearer_than_a_taxi() -> None:
    home = throws(20, "home -carry-> goal", "home -try-> t0")
    found = cost_to_go(home, {"carry": 1000}, case="expected", weights={"heads": 1, "tails": 9})
    assert (found.value, found.choices("home")) == (1000, ("carry",))
    assert found.error <= 1e-9


@pytest.mark.parametrize("n", [350, 800])
def test_whose_first_policy_costs_more_than_any_number_finds_a_better_one(n: int) -> None:
    """To give up is good only for who gives up at both doors; to try takes (9 / 10)^-n throws, which overflow."""
    doors = [f"{x} -try-> t0 / {x} -carry-> m{x} -luck-> goal / m{x} -slip-> {y}" for x, y in ("ab", "ba")]
    arrows = [arrow for door in doors for arrow in door.split(" / ")]
    home = throws(n, "home -go-> a", *arrows)
    plant = Automaton.from_transitions(
        list(home.transitions()), initial="home", marked=["goal"], uncontrollable=["heads", "tails", "luck", "slip"]
    )
    costs = {"carry": 1e5, "luck": 0, "slip": 0, "go": 0}
    found = cost_to_go(plant, costs, case="expected", weights={"heads": 1, "tails": 9})
    assert found.value == pytest.approx(2e5, rel=1e-9)
    assert found.choices("a") == found.choices("b") == ("carry",)
    assert found.values[plant.state("t0")] == math.inf


@pytest.mark.parametrize("n", [900, 1001, 3000])
def test_policy_iteration_goes_on_until_it_is_done(n: int) -> None:
    """Each state's way out is dear: the way through all of them is the best, and no state can know that at first."""
    arrows = [f"s{k} -next-> s{k + 1}" for k in range(n - 1)]
    arrows += [f"s{k} -direct-> goal" for k in range(n - 1)] + [f"s{n - 1} -exit-> goal"]
    found = cost_to_go(
        Automaton.from_transitions(arrows, initial="s0", marked=["goal"]), {"direct": 1e6}, case="expected"
    )
    assert found.value == n
    assert found.error <= 1e-9


def test_chances_far_apart_are_not_lost() -> None:
    fall = Automaton.from_transitions(
        ["0 -go-> goal", "0 -fall-> dead"], initial="0", marked=["goal"], uncontrollable=["fall"]
    )
    assert cost_to_go(fall, case="expected", weights={"go": 1e17}).value == math.inf
    mend = Automaton.from_transitions(
        ["0 -go-> goal", "0 -fail-> bad -fix-> goal"], initial="0", marked=["goal"], uncontrollable=["fail"]
    )
    for go, fail, value in ((1e308, 1e308, 51), (1, 1e-14, 1 + 1e-12), (1e300, 1e-300, 1), (5e-324, 1, 101)):
        found = cost_to_go(mend, {"fix": 100}, case="expected", weights={"go": go, "fail": fail})
        assert found.value == pytest.approx(value, rel=1e-15)
    # a failure is rare, but costs what all the rest does: 1 - b must not be lost
    rare = cost_to_go(mend, {"fix": 1e14, "fail": 0, "go": 0}, case="expected", weights={"go": 3e13})
    assert rare.value == pytest.approx(1e14 / (3e13 + 1), rel=1e-14)


@pytest.mark.parametrize("solver", ["table", "sparse"])
def test_elimination_neither_cancels_nor_overflows(solver: str) -> None:
    for n, p in ((60, 0.25), (180, 0.1), (300, 0.1), (400, 0.1), (400, 1e-300)):
        row, column = np.repeat(np.arange(n), 2), np.zeros(2 * n, np.int64)
        column[::2] = [*range(1, n), -1]
        system = System(row, column, np.tile([p, 1 - p], n), np.ones(n))
        x = system._tabulated() if solver == "table" else system.eliminate(kernel.Ticker())
        exact = sum(Fraction(p) ** -k for k in range(1, n + 1))
        assert x[0] == (math.inf if exact > 1.7e308 else pytest.approx(float(exact), rel=1e-12))


# -- what is refused, and the edges ---------------------------------------------------------------------------


def test_numbers_that_are_none_are_refused() -> None:
    lamp = Automaton.from_transitions(["off -on-> lit -fail-> off"], initial="off", uncontrollable=["fail"])
    for costs in ({"on": -1}, {"on": math.inf}, {"on": math.nan}, {"on": "1"}):
        with pytest.raises(InputError, match=r"costs of event 'on': .* is no number from 0 on"):
            cost_to_go(lamp, costs)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="unknown event 'onn'; did you mean 'on'"):
        cost_to_go(lamp, {"onn": 1})
    with pytest.raises(UnknownName, match="unknown case 'wurst'; did you mean 'worst'"):
        cost_to_go(lamp, case="wurst")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="weights of event 'on': a controllable event of weight 0"):
        cost_to_go(lamp, case="expected", weights={"on": 0})
    with pytest.raises(InputError, match="weights of event 'fail': inf"):
        cost_to_go(lamp, case="expected", weights={"fail": math.inf})


def test_numbers_of_other_kinds_are_taken_and_too_large_ones_are_refused() -> None:
    lamp = Automaton.from_transitions(["off -on-> lit"], initial="off", marked=["lit"])
    for number in (Fraction(1, 4), np.float64(0.25)):
        assert cost_to_go(lamp, {"on": number}).value == 0.25
    for large in (10**400, Fraction(10**400), 1.7e308):
        with pytest.raises(InputError, match=r"costs of event 'on': a number above .* is too large to be added up"):
            cost_to_go(lamp, {"on": large})
    with pytest.raises(InputError, match=r"weights of event 'on': .* is too large"):
        cost_to_go(lamp, case="expected", weights={"on": 10**400})


@pytest.mark.parametrize("case", ["best", "worst", "expected"])
def test_weights_are_checked_also_where_they_do_not_count(case: Case) -> None:
    lamp = Automaton.from_transitions(["off -on-> lit"], initial="off", marked=["lit"])
    with pytest.raises(UnknownName, match="unknown event 'onn'"):
        cost_to_go(lamp, case=case, weights={"onn": 1})
    with pytest.raises(InputError, match="weights of event 'on': -1"):
        cost_to_go(lamp, case=case, weights={"on": -1})


def test_whole_numbers_tie_exactly() -> None:
    fork = Automaton.from_transitions(["0 -a,b-> goal"], initial="0", marked=["goal"])
    assert cost_to_go(fork, {"a": 10**10, "b": 10**10 + 5}).choices(0) == ("a",)
    assert cost_to_go(fork, {"a": 0.1 + 0.2, "b": 0.3}).choices(0) == ("a", "b")


def test_choices_are_found_by_name_and_numbers_are_checked() -> None:
    fork = Automaton.from_transitions(["0 -a,b-> goal"], initial="0", marked=["goal"])
    assert cost_to_go(fork).choices("0") == ("a", "b")
    for wrong in (-1, 2, "1"):
        with pytest.raises(UnknownName, match="unknown state"):
            cost_to_go(fork).choices(wrong)


def test_who_forces_is_refused_unless_nothing_is_forced() -> None:
    alphabet = Alphabet([Event("tick", controllable=False), Event("stop", forcible=True)])
    plant = Automaton.from_transitions(
        ["0 -tick-> 1 -stop-> 0", "1 -tick-> 1"], initial="0", marked=["0"], events=alphabet
    )
    spec = Automaton.from_transitions(["0 -tick-> 1 -stop-> 0"], initial="0", marked=["0", "1"], events=alphabet)
    with pytest.raises(InputError, match="forces events in 1 state, where nobody may wait; costs are defined for"):
        optimal_supervisor(plant, thenar.supcon_forcing(plant, spec))
    least, _ = optimal_supervisor(plant, thenar.supcon_forcing(plant, plant))
    assert thenar.is_isomorphic(least.automaton, plant)


def test_all_stages_share_the_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = walk(2000)

    def slow(*_: object, **__: object) -> Automaton:
        time.sleep(0.2)
        return loop

    monkeypatch.setattr("thenar.synthesis.optimal.closed_loop", slow)
    with pytest.raises(LimitReached, match=r"limit of 0.1\d* seconds"):
        optimal_supervisor(loop, thenar.condat(loop, loop), case="expected", limits=Limits(seconds=0.19))


def test_limits_stop_the_search() -> None:
    with pytest.raises(LimitReached):
        cost_to_go(walk(50_000), case="expected", limits=Limits(seconds=0.1))


@pytest.mark.parametrize("case", ["best", "worst", "expected"])
def test_without_states_or_transitions_there_is_little_to_pay(case: Case) -> None:
    nothing = Automaton.empty(Alphabet(["a"]))
    assert cost_to_go(nothing, case=case).value == math.inf
    assert cheapest_trace(nothing) is None
    for marked, value in ((["0"], 0.0), ([], math.inf)):
        point = Automaton.from_transitions([], initial="0", marked=marked)
        assert cost_to_go(point, case=case).value == value


@pytest.mark.parametrize("state", [-1, 2])
def test_the_choices_of_a_state_that_is_none_are_refused(state: int) -> None:
    lamp = Automaton.from_transitions(["off -on-> lit"], initial="off", marked=["lit"])
    with pytest.raises(UnknownName, match=f"unknown state {state}"):
        cost_to_go(lamp).choices(state)
