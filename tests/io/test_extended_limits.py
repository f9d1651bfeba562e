"""Extended models in several files, and files that would take for ever to read."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

from thenar.errors import InputError, ModelError
from thenar.io import loads, meaning

Cup = Callable[..., str]
Says = Callable[..., None]


# -- several files ---------------------------------------------------------------------------------------------


def test_a_variable_has_one_home(cup: Cup, files_say: Says) -> None:
    files_say(
        {"hand.toml": cup(), "more.toml": '[variables]\nlamp = { values = "bool" }'},
        "more.toml:2: variable 'lamp': already given in hand.toml; rename one of the two",
    )


# -- hostile files ---------------------------------------------------------------------------------------------


def test_an_expression_has_an_end(cup: Cup, says: Says, monkeypatch: pytest.MonkeyPatch) -> None:
    long = " or ".join(["stock < 3"] * 10_000)
    says(
        cup("stock < 3", long),
        f"hand.toml:14: automaton 'CUP', transition 1, when: an expression of {len(long):,} characters; "
        "100,000 are enough",
    )
    monkeypatch.setattr(meaning, "MAX_TEXT", 20)
    says(cup(), "hand.toml:20: condition 1, invariant: the expressions up to here have more than 20 characters")


def test_an_expression_has_a_bottom(cup: Cup) -> None:
    with pytest.raises(
        ModelError, match=r"^hand.toml:14: automaton 'CUP', transition 1, when: expression '\(\(\("
    ) as caught:
        loads(cup("stock < 3", "(" * 1000 + "stock < 3" + ")" * 1000), source="hand.toml")
    assert "nested" in str(caught.value)
    with pytest.raises(ModelError, match="nested"):
        loads(cup("stock < 3", "not " * 5000 + "CUP.up"))


def test_the_values_of_all_variables_have_an_end(cup: Cup, says: Says) -> None:
    many = "".join(f'v{k} = {{ values = "1..1000000" }}\n' for k in range(3))
    says(
        cup('lamp = { values = ["red", "green"] }\n', many),
        "hand.toml:8: variable 'v1', values: the variables up to here have more than 2,000,000 values",
        "hand.toml:9: variable 'v2', values: the variables up to here have more than 2,000,000 values",
    )


def test_names_without_end_are_told_in_seconds(cup: Cup) -> None:
    states = ", ".join(f'"q{k}"' for k in range(20_000))
    unknown = " or ".join(f"CUP.r{k}" for k in range(5_000))
    many = "".join(f'[[conditions]]\nkind = "spec"\ninvariant = "CUP.p{k}"\n' for k in range(2_000))
    values = ", ".join(f'"x{k}"' for k in range(10_000))
    wrong = ", ".join(f'"y{k}"' for k in range(10_000))
    text = cup(
        '"up"\n',
        f'"up"\nstates = ["up", "down", {states}]\n',
        "stock < 3",
        unknown,
        "[[conditions]]",
        many + "[[conditions]]",
    )
    start = time.process_time()
    for hostile in (text, cup('"red", "green"', values, '"] }', f'"], initial = [{wrong}] }}')):
        with pytest.raises(InputError):
            loads(hostile)
    assert time.process_time() - start < 15.0  # an unguarded search for near names takes hours
