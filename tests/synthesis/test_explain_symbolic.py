"""Explanations of a symbolic result are those of the explicit one, found by a few steps from one state."""

from random import Random

import thenar
from thenar.synthesis.api import SynthesisResult, synthesize
from thenar.testing.random_models import random_extended_problem, random_problem


def both(problem: thenar.Problem | thenar.ExtendedProblem) -> tuple[SynthesisResult, SynthesisResult]:
    return synthesize(problem, "explicit"), synthesize(problem, "symbolic")


def test_verdict_length_and_specifications_are_those_of_the_evidence() -> None:
    """The string may be another of the same length."""
    asked = 0
    for seed in range(200):
        problem = random_problem(Random(seed))
        explicit, symbolic = both(problem)
        if not explicit:
            continue
        for q in range(min(explicit.supervisor.n_states, 8)):
            trace = thenar.shortest_trace(explicit.supervisor.automaton, to=q) or thenar.Trace()
            for event in problem.alphabet.names:
                a, b = (thenar.explain_disabled(r, event, after=trace) for r in (explicit, symbolic))
                assert (a.verdict, len(a.continuation), a.enabled) == (b.verdict, len(b.continuation), b.enabled)
                assert {v.spec for v in a.violations} == {v.spec for v in b.violations}
                asked += 1
    assert asked > 3000


def test_conflicts_are_as_small_as_those_of_the_evidence() -> None:
    for seed in range(200):
        explicit, symbolic = both(random_problem(Random(seed)))
        if explicit:
            continue
        a, b = explicit.reason, symbolic.reason
        assert a is not None
        assert b is not None
        assert (a.verdict, len(a.conflict), b.minimal) == (b.verdict, len(b.conflict), True)


def test_traces_that_are_cut_and_states_that_are_removed() -> None:
    explicit, symbolic = both(thenar.library.glr.problem())
    for seed in range(20):
        rng = Random(seed)
        plant = thenar.sync(*explicit.plain.plants)
        state, trace = 0, []
        for _ in range(12):  # what the plants can do, supervised or not
            event = rng.choice(plant.enabled(state))
            trace.append(event.name)
            state = plant.step(state, event) or 0
            if state == 0:
                break
        for question in (thenar.explain_removed, lambda r, t: thenar.explain(r, after=t)[0]):
            a, b = (question(r, trace) for r in (explicit, symbolic))
            assert (a.verdict, len(a.after), a.event) == (b.verdict, len(b.after), b.event)


def test_extended_problems_are_explained_whatever_is_asked() -> None:
    kinds = set()
    for seed in range(200):
        problem = random_extended_problem(Random(seed))
        result = synthesize(problem, "symbolic")
        if not result:
            assert str(result.reason).startswith("No supervisor exists: ")
            continue
        for event in problem.alphabet.names:
            why = thenar.explain_disabled(result, event)
            kinds.add(why.verdict)
            assert result.symbolic is not None
            pattern = result.symbolic.after("")
            assert pattern is not None
            assert (why.verdict == "enabled") == (event in pattern)
    assert kinds == {"enabled", "impossible", "forbidden", "uncontrollable", "blocking"}


def test_a_hundred_philosophers_with_a_fork_each() -> None:
    result = synthesize(thenar.library.model("dining(100)"), "symbolic")
    why = thenar.explain_disabled(result, "take_left_100", after=[f"take_left_{k}" for k in range(1, 100)])
    assert why.verdict == "blocking"
    assert "a deadlock" in str(why)
    assert why.enabled == ("take_right_99",)
    assert len(str(why)) < 2000
