"""Models of known size: the oracle finds as many states as CIF does.

Source: Eclipse ESCET, regression tests of CIF's data-based synthesis, tests/datasynth/NAME.cif; the size of the
controlled system ("exactly N states") is from NAME.cif.out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from thenar.model.extended import ExtendedAutomaton, ExtendedProblem, Variable, disables, invariant, needs
from thenar.testing.extended_oracle import supcon


def plant(name: str, *edges: Any, initial: str, marked: str = "", uncontrollable: str = "") -> ExtendedAutomaton:
    return ExtendedAutomaton.from_edges(
        name,
        edges,
        initial=initial.split(),
        marked=marked.split(),
        uncontrollable=uncontrollable.split(),
    )


def guards_upds() -> ExtendedProblem:
    p1 = plant(
        "p1", ("l0", "a", "l1", "", {"p1.x": "p1.x + 1"}), ("l0", "b", "l0", "p1.x >= 3"), initial="l0", marked="l0"
    )
    p2 = plant("p2", ("l", "a", "l", "p2.y > 2", {"p2.y": "3"}), ("l", "b", "l", "p1.x != 4"), initial="l", marked="l")
    return ExtendedProblem([p1, p2], variables=[Variable("p1.x", range(6)), Variable("p2.y", range(6))])


def asgn_inc_mod() -> ExtendedProblem:
    p = plant("p", ("l", "next", "l", "", {"x": "(x + 1) % 5"}), initial="l", marked="l")
    return ExtendedProblem([p], [invariant("x % 2 == 0")], variables=[Variable("x", range(5), initial=2)])


def marking2() -> ExtendedProblem:
    p = plant("p", "l1 -c-> l2", initial="l1", marked="l1 l2")
    marked = "x != 4 and x != 5 and (p.l1 and x > 1 or p.l2 and x > 2)"
    return ExtendedProblem([p], variables=[Variable("x", range(6))], marked=marked)


def non_determinism() -> ExtendedProblem:
    edges = [
        ("l0", "c1", "l0", "", {"x1": "true"}),
        ("l0", "c2", "l0", "", {"x2": "true"}),
        ("l0", "u", "l1", "x1"),
        ("l0", "u", "l2", "x2"),
        "l1 -u-> l0",
        "l2 -u-> l0",
    ]
    p = plant("p", *edges, initial="l0", marked="l0", uncontrollable="u")
    variables = [Variable("x1", [False, True]), Variable("x2", [False, True])]
    return ExtendedProblem([p], [invariant("not p.l1")], variables=variables)


def initial1() -> ExtendedProblem:
    p = plant("p", initial="l", marked="l")
    domains = {1: [0], 2: [2], 3: [2], 4: range(10), 5: range(10), 6: range(10), 7: range(0, 10, 2)}
    variables = [Variable(f"x{k}", range(10), initial=first) for k, first in domains.items()]
    initial = "x1 == 0 and x2 == 2 and x3 == 2 and x4 >= 0 and x5 != 5 and x6 != 6 and x6 != 7 and x7 != 8"
    return ExtendedProblem([p], variables=variables, initial=initial, marked="x5 != 1 and x6 != 2 and x7 != 6")


def initial_bad() -> ExtendedProblem:
    p = plant("p", "l0 -u1-> l1", "l1 -u2-> l2", initial="l0", marked="l0 l1 l2", uncontrollable="u1 u2")
    marked = "p.l0 and x <= 10 or p.l1 and x == 13 or p.l2 and x == 16"
    x = Variable("x", range(21), initial=range(21))
    return ExtendedProblem([p], [needs("u1", "x != 3"), needs("u2", "x != 6")], variables=[x], marked=marked)


def req_counter() -> ExtendedProblem:
    adder = plant("adder", "l1 -add-> l2 -add-> l3 -remove-> l1", initial="l1", marked="l1", uncontrollable="remove")
    count = plant(
        "count_max3",
        ("l", "add", "l", "", {"cnt": "cnt + 1"}),
        ("l", "remove", "l", "", {"cnt": "cnt - 1"}),
        initial="l",
        marked="l",
        uncontrollable="remove",
    )
    return ExtendedProblem([adder], [count, invariant("cnt <= 3")], variables=[Variable("cnt", range(11))])


def state_plant_invs_simple() -> ExtendedProblem:
    a = plant(
        "A",
        *("l1 -c-> l2", "l2 -u1-> l3", "l2 -u2-> l4", "l2 -u3-> l5"),
        initial="l1 l3 l4 l5",
        marked="l1 l2 l3 l4 l5",
        uncontrollable="u1 u2 u3",
    )
    return ExtendedProblem([a, invariant("not A.l4"), invariant("not A.l5"), invariant("not A.l3")])


def edge_granularity() -> ExtendedProblem:
    edge = ("l1", "e", "y2", "x == 0", {"y": "2"})
    p = plant("p", edge, edge, initial="l1", marked="y2", uncontrollable="e")
    variables = [Variable(name, range(4), initial=range(4)) for name in "xy"]
    return ExtendedProblem([p], variables=variables, marked="y == 2")


def state_req_inv_all_ctrl_beh() -> ExtendedProblem:
    p = plant(
        "p",
        ("l", "u_e", "l", "not b", {"x": "x + 2", "b": "true"}),
        ("l", "c_e", "l", "", {"y": "y + 2"}),
        initial="l",
        marked="l",
        uncontrollable="u_e",
    )
    variables = [Variable("b", [False, True]), *(Variable(n, range(11), initial=range(11)) for n in "xyz")]
    return ExtendedProblem([p], [invariant(f"{n} <= 6") for n in "xyz"], variables=variables)


def inv_state_evt_exclusion_req_comp() -> ExtendedProblem:
    a = plant("a", ("l", "e", "l", "x < 20", {"x": "x + 1"}), *(f"l -{e}-> l" for e in "fgh"), initial="l", marked="l")
    rules = [needs("f", "x >= 10"), needs("f", "x <= 15"), disables("x < 11", "g"), disables("x > 14", "g")]
    rules += [needs("h", "x >= 12"), disables("x > 13", "h")]
    return ExtendedProblem([a], rules, variables=[Variable("x", range(26), initial=1)])


def multi_req_auts() -> ExtendedProblem:
    p = plant("p", ("l", "a", "l", "x < 13", {"x": "x + 1"}), "l -b-> l", initial="l", marked="l")
    r2 = plant("r2", "l1 -a-> l2 -a-> l1", "l2 -b-> l2", initial="l1", marked="l1")
    r3 = plant("r3", "l1 -a-> l2 -a-> l3 -a-> l1", "l3 -b-> l3", initial="l1", marked="l1")
    return ExtendedProblem([p], [r2, r3], variables=[Variable("x", range(14))])


CIF: dict[Callable[[], ExtendedProblem], int] = {
    guards_upds: 1,
    asgn_inc_mod: 1,
    marking2: 0,
    non_determinism: 3,
    initial1: 1680,
    initial_bad: 3,
    req_counter: 7,
    state_plant_invs_simple: 2,
    edge_granularity: 5,
    state_req_inv_all_ctrl_beh: 490,
    inv_state_evt_exclusion_req_comp: 20,
    multi_req_auts: 13,
}


@pytest.mark.parametrize("model", CIF, ids=lambda model: model.__name__)
def test_cif_finds_as_many_states(model: Callable[[], ExtendedProblem]) -> None:
    assert supcon(model()).n_states == CIF[model]


def test_the_controlled_states_of_non_determinism_are_those_that_cif_lists() -> None:
    """Source: tests/datasynth/non_determinism.statespace.cif."""
    result = supcon(non_determinism())
    a, b, c = ("l0", False, False), ("l0", False, True), ("l2", False, True)
    assert result.transitions == ((a, "c2", b), (b, "c2", b), (b, "u", c), (c, "u", b))
    assert result.disabled == {a: ("c1",), b: ("c1",), c: ()}
