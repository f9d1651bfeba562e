"""Expressions: what is printed can be read again, and what is accepted can be evaluated."""

from __future__ import annotations

from itertools import product
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import thenar
from thenar.model.expressions import (
    TRUE,
    At,
    Constant,
    Expression,
    Name,
    Operation,
    Value,
    conjunction,
    evaluate,
    leaves,
    parse,
    resolve,
)
from thenar.model.extended import ExtendedProblem
from thenar.model.scope import Scope
from thenar.testing import extended_oracle
from thenar.testing.random_models import random_extended_problem

BINARY = ["==", "!=", "<", "<=", ">", ">=", "+", "-", "*", "//", "%"]
NAMES = st.sampled_from(["n", "CELL.n", "lamp", "é", "M1.idle"])
LEAVES = st.one_of(
    st.integers(-5, 5).map(Constant),
    st.booleans().map(Constant),
    st.sampled_from(["dark red", "if", "it's", "1", "", "true", "a..b", "\\", "\n"]).map(Constant),
    NAMES.map(Name),
    # a state whose name stands after a dot comes back as a name, and is found out by the problem
    st.builds(At, st.sampled_from(["M1", "A.B", "M 1", "in", ""]), st.sampled_from(["0", "a b", "a.b", "is", "", "'"])),
)


def operations(leaf: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    """Whatever the parser can return: minus before a whole number is part of the number."""

    def extend(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
        no_number = inner.filter(lambda x: not (isinstance(x, Constant) and type(x.value) is int))
        return st.one_of(
            st.builds(Operation, st.sampled_from(["and", "or"]), st.lists(inner, min_size=2, max_size=3).map(tuple)),
            st.builds(Operation, st.sampled_from(BINARY), st.tuples(inner, inner)),
            st.builds(Operation, st.just("not"), st.tuples(inner)),
            st.builds(Operation, st.just("neg"), st.tuples(no_number)),
            st.builds(Operation, st.just("if"), st.tuples(inner, inner, inner)),
        )

    return st.recursive(leaf, extend, max_leaves=8)


@given(operations(LEAVES))
def test_what_is_printed_is_read_as_the_same(expression: Expression) -> None:
    assert parse(str(expression)) == expression


def test_resolved_expressions_are_printed_so_that_they_resolve_to_the_same() -> None:
    count = 0
    for seed in range(200):
        problem = random_extended_problem(Random(seed))
        values = {v.name: v.values for v in problem.variables}
        states = {a.name: a.states for a in problem.automata}
        for expression in expressions(problem):
            assert resolve(parse(str(expression)), values, states) == expression
            assert resolve(expression, values, states) == expression
            count += expression != TRUE
    assert count > 1000


def test_arrays_scalars_and_the_oracle_agree() -> None:
    for seed in range(100):
        problem = random_extended_problem(Random(seed))
        parts = [*(a.states for a in problem.automata), *(v.values for v in problem.variables)]
        place = {part.name: k for k, part in enumerate(problem.automata)}
        place |= {v.name: len(place) + k for k, v in enumerate(problem.variables)}
        states = list(product(*parts))[:500]
        columns = [np.array(column) for column in zip(*states, strict=True)]

        def on_arrays(
            leaf: Constant | Name | At, place: dict[str, int] = place, columns: list[np.ndarray] = columns
        ) -> object:
            if isinstance(leaf, Constant):
                return leaf.value
            return columns[place[leaf.name]] if isinstance(leaf, Name) else columns[place[leaf.automaton]] == leaf.state

        for expression in set(expressions(problem)):
            together = np.broadcast_to(evaluate(expression, on_arrays), len(states))
            for x, value in zip(states, together.tolist(), strict=True):

                def on_scalars(
                    leaf: Constant | Name | At, place: dict[str, int] = place, x: tuple[Value, ...] = x
                ) -> object:
                    return extended_oracle.evaluate(leaf, place, x)

                assert value == extended_oracle.evaluate(expression, place, x) == evaluate(expression, on_scalars)


def expressions(problem: ExtendedProblem) -> list[Expression]:
    edges = [e for a in problem.automata for e in a.edges]
    found = [problem.initial, problem.marked, *(e.guard for e in edges), *(x for e in edges for _, x in e.updates)]
    return found + [c.predicate for c in (*problem.plant_conditions, *problem.spec_conditions)]


VALUES: dict[str, tuple[Value, ...]] = {
    "n": (-1, 0, 1, 2),
    "b": (False, True),
    "lamp": ("red", "green"),
    "paint": ("red", "green", "blue"),
}
TYPED = st.one_of(
    st.integers(-2, 3).map(Constant),
    st.booleans().map(Constant),
    st.sampled_from(["red", "blue"]).map(Constant),
    st.sampled_from(sorted(VALUES)).map(Name),
    st.sampled_from(["idle", "busy"]).map(lambda q: At("M", q)),
)


@given(operations(TYPED), st.sampled_from(sorted(VALUES)))
def test_what_a_problem_accepts_can_be_evaluated_everywhere(expression: Expression, variable: str) -> None:
    truths, updates = (Scope(VALUES, {"M": ("idle", "busy")}) for _ in range(2))
    truths.truth(expression, "", "a guard")
    updates.new_value(variable, expression, "")
    place = {name: k for k, name in enumerate([*VALUES, "M"])}
    for x in product(*VALUES.values(), ("idle", "busy")):
        if not truths.mistakes:
            assert isinstance(extended_oracle.evaluate(expression, place, x), bool)
        if not updates.mistakes:
            assert type(extended_oracle.evaluate(expression, place, x)) is type(VALUES[variable][0])


@pytest.mark.parametrize(
    "text", ["n + 1 < 3", "not b", "lamp == paint", "lamp == red", "(red if b else blue) == paint"]
)
def test_sensible_expressions_are_accepted(text: str) -> None:
    scope = Scope(VALUES, {"M": ("idle", "busy")})
    scope.truth(text, "", "a guard")
    assert not scope.mistakes


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("n", "a guard is true or false, but 'n' is a number"),
        ("b and n", "in 'b and n': 'n' is a number, where a truth is needed"),
        ("n + b > 1", "in 'n + b': 'b' is true or false, where a number is needed"),
        ("lamp < n", "in 'lamp < n': 'lamp' is green or red, where a number is needed"),
        ("lamp == n", "in 'lamp == n': 'lamp' is green or red, 'n' is a number; they cannot be compared"),
        ("lamp == b", "in 'lamp == b': 'lamp' is green or red, 'b' is true or false; they cannot be compared"),
        ("(n if b else lamp) == 1", "'n' is a number, 'lamp' is green or red; they cannot be values of one thing"),
        ("n // n > 0", "in 'n // n': the divisor must be written as a number other than 0"),
        ("n % 0 > 0", "in 'n % 0': the divisor must be written as a number other than 0"),
        ("n * 9223372036854775807 > 0", "'n * 9223372036854775807' may leave the 64 bits of a whole number"),
        ("m > 0", "'m' is no variable, no state of an automaton and no value"),
        ("lanp == red", "'lanp' is no variable, no state of an automaton and no value; did you mean 'lamp'?"),
        ("M.idel", "automaton 'M' has no state 'idel'; did you mean 'idle'?"),
        ("M['bus']", "automaton 'M' has no state 'bus'; did you mean 'busy'?"),
        ("MM[1]", "unknown automaton 'MM'"),
        ("lamp == 'gren'", "'gren' is a value of no variable; did you mean 'green'?"),
        ("n = 3", "expression 'n = 3', column 3: not understood; for '=' write '=='"),
        ("b && b", "expression 'b && b', column 3: not understood; for '&&' write 'and'"),
        ("! b", "column 1: not understood; for '!' write 'not'"),
        ("  é.f(n)", "expression '  é.f(n)', column 3: not understood; there are names"),
        ("b and é + f(n)", "column 11: not understood; there are names"),
        ("n <", "not understood; invalid syntax"),
        ("", "an expression is empty"),
        ("1.5 > n", "column 1: not understood"),
        ("n" + " + n" * 300, "nested deeper than 200"),
        ("9" * 5000, "not understood"),
    ],
)
def test_each_mistake_is_named(text: str, complaint: str) -> None:
    scope = Scope(VALUES, {"M": ("idle", "busy")})
    assert scope.truth(text, "here", "a guard") is not None
    assert complaint in scope.mistakes[0].what
    assert len(scope.mistakes[0].what) < 250


def test_all_mistakes_of_an_expression_are_named() -> None:
    scope = Scope(VALUES, {"M": ("idle", "busy")})
    scope.truth("n and M.idle + 1 > 2 or x == y", "here", "a guard")
    assert [m.what for m in scope.mistakes] == [
        "'x' is no variable, no state of an automaton and no value",
        "'y' is no variable, no state of an automaton and no value",
    ]
    scope.mistakes.clear()
    scope.truth("n and M.idle + 1 > 2", "here", "a guard")
    assert len(scope.mistakes) == 2


@pytest.mark.parametrize(
    ("variable", "text", "complaint"),
    [
        ("n", "b", "'n' is a number, but its new value 'b' is true or false"),
        ("lamp", "blue", "'lamp' is green or red, but its new value 'blue' is the name blue"),
        ("b", "n", "'b' is true or false, but its new value 'n' is a number"),
        ("m", "3", "updates 'm', which is no variable"),
    ],
)
def test_an_update_fits_its_variable(variable: str, text: str, complaint: str) -> None:
    scope = Scope(VALUES, {})
    scope.new_value(variable, text, "here")
    assert [m.what for m in scope.mistakes] == [complaint]


def test_an_operation_made_by_hand_is_checked_too() -> None:
    for made in (Operation("xor", (TRUE, TRUE)), Operation("not", (TRUE, TRUE)), Operation("and", ()), 3.5):
        scope = Scope(VALUES, {})
        scope.truth(made, "here", "a guard")  # type: ignore[arg-type]
        assert len(scope.mistakes) == 1


def test_a_truth_is_no_number() -> None:
    assert Constant(True) != Constant(1)
    assert len({Constant(True), Constant(1), Constant(False), Constant(0)}) == 4
    assert parse(1) == Constant(1) != TRUE == parse(True)


def test_a_long_condition_may_take_several_lines() -> None:
    assert parse("n > 0\n  and b\n") == parse("n > 0 and b")


def test_a_chain_of_comparisons_is_their_conjunction() -> None:
    assert parse("0 < n <= 3") == parse("0 < n and n <= 3")


def test_conjunctions_are_flat() -> None:
    a, b, c = (Name(x) for x in "abc")
    assert conjunction([a, conjunction([b, c]), TRUE]) == Operation("and", (a, b, c))
    assert (conjunction([]), conjunction([TRUE, a])) == (TRUE, a)


def test_leaves_are_listed_from_left_to_right() -> None:
    assert [str(x) for x in leaves(parse("a + 1 > b or M[2] or a"))] == ["a", "1", "b", "M['2']", "a"]


def test_resolving_names_all_that_is_unknown() -> None:
    with pytest.raises(thenar.ModelError) as caught:
        resolve(parse("x > 0 and y > 0"), {}, {})
    assert len(caught.value.mistakes) == 2
