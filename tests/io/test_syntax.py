"""Texts that are no TOML and no JSON: every kind is one test, with its message."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from thenar.errors import InputError, ModelError
from thenar.io import loads

Says = Callable[..., None]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "[events]\nslip* = {}",
            "hand.toml:2:5: expected '=' after the key; a name with other characters than letters, digits, '-' and "
            "'_' stands in double quotes",
        ),
        (
            "name = hand",
            "hand.toml:1:8: expected a value; text stands in double quotes, and every list ends with ']'",
        ),
        (
            "[automata.M]\nmarked = [\n",
            "hand.toml:2:11: expected a value; text stands in double quotes, and every list ends with ']'",
        ),
        (
            'marked = ["x"\n[events]',
            "hand.toml:2:1: expected ',' or ']' in a list",
        ),
        (
            "*",
            "hand.toml:1:1: expected 'key = value' or a [table]; a name with other characters than letters, digits, "
            "'-' and '_' stands in double quotes",
        ),
        (
            "slip = { controllable = false, }",
            "hand.toml:1:32: expected a key; a table in braces stays on one line, without a comma at its end",
        ),
        ("slip = { controllable = false", "hand.toml:1:30: expected ',' or '}' in a table in braces"),
        (
            'name = "hand\n',
            "hand.toml:1:13: a line break or control character inside a text; close its quotes on the same line, or "
            'put """ around several lines',
        ),
        ('name = """hand\n', "hand.toml:1:15: a text is not closed; add the quotes at its end"),
        (r'name = "\q"', r"hand.toml:1:11: unknown escape in a text; write '\\' for a backslash"),
        (
            'name = "a" "b"',
            "hand.toml:1:12: expected the end of the line after the value; one 'key = value' a line",
        ),
        (
            "events = {}\nevents.slip = {}",
            "hand.toml:2:17: a table in braces is complete; write the key inside the braces",
        ),
    ],
)  # fmt: skip
def test_a_toml_syntax_error_has_line_column_and_way_out(text: str, message: str, says: Says) -> None:
    says(text, message, error=ModelError)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "{name: 1}",
            "hand.json:1:2: expected a key in double quotes; JSON has no comments and no comma before '}'",
        ),
        (
            '{\n"name": hand}',
            "hand.json:2:9: expected a value; text stands in double quotes, and JSON has no comments and no comma "
            "before ']'",
        ),
        ('{"marked": ["x" "y"]}', "hand.json:1:17: expected ',' or a closing bracket"),
        ('{"name" "hand"}', "hand.json:1:9: expected ':' after the key"),
        ('{"name": "hand"}}', "hand.json:1:17: expected the end of the file; everything stands in one pair of braces"),
        ('{"name": "hand', "hand.json:1:10: a text is not closed; add the quotes at its end"),
        (
            '{"name": "ha\nnd"}',
            r"hand.json:1:13: a line break or control character inside a text; write '\n' for a line break",
        ),
        (r'{"name": "\q"}', r"hand.json:1:11: unknown escape in a text; write '\\' for a backslash"),
    ],
)
def test_a_json_syntax_error_has_line_column_and_way_out(text: str, message: str, says: Says) -> None:
    says(text, message, format="json", error=ModelError)


def test_a_comma_before_a_brace_is_told_to_go() -> None:
    with pytest.raises(ModelError, match=r"^hand.json:1:1\d: .*comma before"):  # where exactly: parsers differ
        loads('{"name": "x",}', source="hand.json")


def test_a_key_given_twice_names_both_lines(says: Says) -> None:
    says(
        '[events]\nslip = {}\nlift = {}\n"slip" = {}\nlift = {}',
        "hand.toml:4: event 'slip': given twice, first in line 2; keep one of them",
        "hand.toml:5: event 'lift': given twice, first in line 3; keep one of them",
        error=ModelError,
    )


def test_a_table_given_twice_names_both_lines(says: Says) -> None:
    says(
        '[automata.M]\nkind = "plant"\n[automata.M]\nkind = "spec"',
        "hand.toml:3: automaton 'M': given twice, first in line 1; keep one of them",
    )


def test_a_key_given_twice_in_braces_is_found(says: Says) -> None:
    says(
        "[events]\nslip = { forcible = true, forcible = true }",
        "hand.toml:2: event 'slip', forcible: given twice, first in line 2; keep one of them",
    )


def test_a_key_given_twice_in_json_names_both_lines(says: Says) -> None:
    says(
        '{"automata": {"M": {\n"initial": "x",\n"initial": "y"}}}',
        "hand.json:3: automaton 'M', initial: given twice, first in line 2; keep one of them",
        format="json",
        error=ModelError,
    )


def test_a_key_given_twice_deep_inside_a_list_is_found() -> None:
    with pytest.raises(ModelError, match=r"^<string>:2: .* given twice, first in line 2"):
        loads('{"events": [\n{"a": 1, "a": 2}]}')


@pytest.mark.parametrize("text", ["", " \n\t\n", "\ufeff"])
@pytest.mark.parametrize("format", ["toml", "json"])
def test_an_empty_file_says_so(text: str, format: str, says: Says) -> None:
    says(text, f"hand.{format}: the file is empty; a model file gives events and automata", format=format)


@pytest.mark.parametrize("opening", ["a = " + "[" * 100_000, '{"a":' + "[" * 100_000 + "]" * 100_000 + "}"])
def test_deep_nesting_is_refused(opening: str) -> None:
    with pytest.raises(InputError) as caught:
        loads(opening, source="hand.toml")
    assert str(caught.value) == "hand.toml: nested too deeply; a model file has 6 levels at most"


@pytest.mark.parametrize("text", ["a" + ".a" * 14 + " = 1", '{"a":' * 500 + "1" + "}" * 500])
def test_nesting_that_a_parser_survives_is_an_unknown_key(text: str) -> None:
    with pytest.raises(ModelError, match=r"^<string>:1: a: unknown key"):
        loads(text)


def test_a_key_of_many_parts_is_refused_before_it_takes_all_memory() -> None:
    with pytest.raises(ModelError) as caught:
        loads('"""a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a"""\n' + "a" + " . 'a'" * 100_000 + " = 1", source="hand.toml")
    assert str(caught.value) == "hand.toml:2: a key of more than 16 parts; a model file has 6 levels at most"


@pytest.mark.parametrize("text", ["a = " + "1" * 5000, '{"a": ' + "1" * 5000 + "}"])
def test_a_number_without_end_is_refused(text: str) -> None:
    with pytest.raises(InputError) as caught:
        loads(text, source="hand.toml")
    assert str(caught.value) == "hand.toml: a number of thousands of digits; a model file needs no such"


@pytest.mark.parametrize("text", [r'{"name": "\ud800"}', '{"name": "\ud800"}', 'name = "\ud800"'])
def test_half_a_character_is_refused(text: str) -> None:
    with pytest.raises(InputError) as caught:
        loads(text, source="hand.json")
    assert str(caught.value) == r"hand.json: '\ud800' is half a character; write the character itself"


def test_two_halves_are_a_character() -> None:
    text = r'{"name": "\ud83e\udd0f", "automata": {"M": {"kind": "plant", "initial": "x"}}}'
    assert loads(text).name == "\N{PINCHING HAND}"
