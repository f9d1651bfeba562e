"""State names: composed when looked at, and never ambiguous."""

import pytest

import thenar
from thenar.model.automaton import Automaton


def one_way(name: str, first: str, second: str) -> Automaton:
    return Automaton.from_transitions([(first, f"go_{name}", second)], initial=first, marked=[second], name=name)


def test_names_with_the_separator_in_them_are_quoted() -> None:
    product = thenar.sync(one_way("A", "a|b", "a"), one_way("B", "c", "b|c"))
    names = {product.states[q] for q in range(product.n_states)}
    assert names == {"'a|b'|c", "'a|b'|'b|c'", "a|c", "a|'b|c'"}


def test_a_product_of_products_lists_its_parts_once() -> None:
    product = thenar.sync(thenar.sync(one_way("A", "a", "b"), one_way("B", "c", "d")), one_way("C", "e", "f"))
    assert product.states[0] == "a|c|e"


def test_a_state_of_a_product_is_found_by_its_name() -> None:
    inner = thenar.sync(one_way("A", "a|b", "'"), one_way("B", "c", "b|c"))
    product = thenar.sync(inner, one_way("C", "e", "f"))
    for q in range(product.n_states):
        assert product.state(product.states[q]) == q
    for wrong in ("a", "a|b|c|e", product.states[0] + "|", ""):
        with pytest.raises(thenar.UnknownName):
            product.state(wrong)


def test_a_product_of_a_million_states_costs_no_strings() -> None:
    product = thenar.sync(*(one_way(f"T{k}", "off", "on") for k in range(20)))
    assert product.n_states == 1 << 20
    assert product.states[product.n_states - 1] == "|".join(["on"] * 20)
    assert repr(product).endswith("1,048,576 states (1 marked), 10,485,760 transitions, 20 events")
