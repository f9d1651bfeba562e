"""What is wrong with Waters modules is said with its place, and nothing that is given crashes or takes long."""

from __future__ import annotations

import contextlib
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.io.foreign.wmod import (
    LOOP,
    NEXT,
    ONE,
    X,
    between,
    binary,
    component,
    constant,
    edge,
    foreach,
    indexed,
    loads,
    module,
    name,
    node,
    number,
    run,
    unary,
    variable,
)

from thenar.errors import InputError, ModelError
from thenar.io.foreign import waters


def guarded(guard: str, *actions: str) -> list[str]:
    return [X, component("A", ONE, edge("p", "p", name("a"), guard, *actions))]


@pytest.mark.parametrize(
    ("components", "said"),
    [
        ([component("A", ONE, edge("p", "q", name("a")))], "unknown node 'q'"),
        ([component("A", ONE, edge("p", "p", name("b")))], "unknown event 'b'"),
        ([component("A", ONE, edge("p", "p", name(":accepting")))], "':accepting' is a proposition, not an event"),
        ([component("A", node("p"))], "automaton 'A' has no initial node"),
        ([component("A", ONE + ONE)], "node 'p' is there twice"),
        ([component("A", ONE), component("A", ONE)], "two components are called 'A'"),
        ([component("A", ONE, kind="PLAN")], "kind 'PLAN'; there are PLANT, SPEC, SUPERVISOR and PROPERTY"),
        ([LOOP, variable("x", number(3))], "a range is asked for here, and 3 is none; is a constant missing?"),
        ([LOOP, variable("x", between(0, name("N")))], "a number is asked for here, and 'N' is none; is a constant"),
        ([LOOP, variable("x", between(3, 0))], "the range of 'x' has no value"),
        ([LOOP, variable("x", between(0, 2**30))], "has more than 1,000,000 values"),
        ([LOOP, variable("x", between(0, 1), number(0))], "variable 'x' has no initial value"),
        (guarded(name("x")), "a condition is asked for here, and x is none"),
        (guarded(name("y")), "unknown name 'y'"),
        (guarded(name("A")), "'A' is an automaton; compare it with one of its states, A == STATE"),
        (guarded(binary("==", name("A"), name("z"))), "automaton 'A' has no state 'z'"),
        (guarded(binary("^", name("x"), name("x"))), "operator '^' of <BinaryExpression> is not read here; there are"),
        (guarded("", binary("==", name("x"), number(1))), "an action is x = VALUE, or one of += -= *="),
        (guarded(number(99**9)), "is no number of 32 bits"),
        ([foreach("ForeachComponent", "i", between(1, 999999), LOOP)], "loops up to here take more than 250,000 turns"),
        (["<Surprise/>", LOOP], "<Surprise> is no component that is read here"),
    ],
)
def test_mistakes(components: list[str], said: str) -> None:
    with pytest.raises(ModelError, match=re.escape(said)) as raised:
        loads(*components)
    assert all(re.match(r"m\.wmod:\d+:\d+", m.where) for m in raised.value.mistakes)


def test_all_mistakes_at_once() -> None:
    wrong = [component("A", ONE, edge("p", "q", name("a")) + edge("p", "p", name("b"))), component("B", node("p"))]
    with pytest.raises(ModelError) as raised:
        loads(*wrong)
    assert len(raised.value.mistakes) == 3


@pytest.mark.parametrize(
    ("before", "said"),
    [
        (constant("A", name("B")) + constant("B", name("A")), "constant 'A' is defined by itself"),
        ('<ConstantAlias Name="N" Scope="REQUIRED_PARAMETER"/>', "parameter 'N' has no value"),
        (constant("N", binary("/", number(1), number(0))), "cannot be worked out: 1 / 0"),
        (constant("N", binary("*", number(2**30), number(4))), "the number 4294967296 is too large"),
    ],
)
def test_constants(before: str, said: str) -> None:
    with pytest.raises(ModelError, match=re.escape(said)):
        loads(LOOP, before=f"<ConstantAliasList>{before}</ConstantAliasList>")


def test_bounds_of_hostile_files() -> None:
    events = '<EventDecl Kind="CONTROLLABLE" Name="e"><RangeList>' + between(1, 1000) * 3 + "</RangeList></EventDecl>"
    with pytest.raises(ModelError, match="the events up to here are more than 100,000"):
        loads(LOOP, events=events)
    deep = name("x")
    for _ in range(150):
        deep = unary("!", deep)
    with pytest.raises(ModelError, match="nested deeper than 100"):
        run(deep)
    with pytest.raises(ModelError, match="more than 500 elements within one another"):
        run("<UnaryExpression Operator='!'>" * 600)


def test_numbers_have_32_bits() -> None:
    product = binary("*", binary("*", name("x"), number(2**30)), number(2**30))
    with pytest.raises(ModelError, match="Waters' numbers have 32 bits"):
        run(binary("==", product, number(0)))


GOOD = module(
    X, foreach("ForeachComponent", "i", between(1, 2), component(indexed("A", name("i")), ONE + node("q", ":forbidden"),
    edge("p", "q", name("a"), binary("<", NEXT, name("x"))))), LOOP,
    aliases=f'<EventAliasList><EventAlias Name="z">{name("a")}</EventAlias></EventAliasList>',
)  # fmt: skip


@settings(max_examples=400, deadline=None)
@given(st.data())
def test_damaged_files_are_refused(data: st.DataObject) -> None:
    words = [
        b"Name",
        b"x",
        b"A[1]",
        b":accepting",
        b"..",
        b"'",
        b"&amp;",
        b"PLANT",
        b"<EdgeList>",
        b"</Edge>",
        b'"',
        b"99",
    ]
    damaged = bytearray(GOOD)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(damaged)))
        damaged[at : at + data.draw(st.integers(0, 12))] = data.draw(st.sampled_from(words) | st.binary(max_size=3))
    for text in (bytes(damaged), data.draw(st.binary(max_size=40)), GOOD[: data.draw(st.integers(0, len(GOOD)))]):
        with contextlib.suppress(InputError):
            waters.loads(text, "m.wmod")


def test_every_attribute_may_be_something_else() -> None:
    places = [m.span(1) for m in re.finditer(rb'="([^"]*)"', GOOD)]
    for low, high in places:
        for other in (b"", b"A", b"p", b"x", b"a", b"-", b"..", b"=", b"'", b"SPEC", b"-7", b"[", b"\xc3\xa4"):
            with contextlib.suppress(InputError):
                waters.loads(GOOD[:low] + other + GOOD[high:], "m.wmod")
