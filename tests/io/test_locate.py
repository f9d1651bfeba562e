"""Every key and entry is found on its line, however it is written."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thenar.io.locate import Places

TOML = """\
name = "hand"  # a comment

[events]
slip = {}
re.align = { controllable = false }
'with "quotes"' = {}
"with \\u00e9" = {}
a . "b.c" . d = 1

[automata."FINGER 1"]  # [automata.OTHER]
kind = "plant"
transitions = [  # the first
  "a -b-> c",
  # "not this one"
  ["a", "b", "c"], ["d",
    "e",
    "f"],
  \"\"\"
  over lines -x->
  y\"\"\",
]
[automata.FINGER2]
marked = [
  "x", "y",
  { z = 1,
]
[[hands]]
left = 1
[ automata . FINGER3 . inner ]
key = 3
"""


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ((), 1),
        (("name",), 1),
        (("events",), 3),
        (("events", "slip"), 4),
        (("events", "slip", "controllable"), 4),
        (("events", "re", "align", "controllable"), 5),
        (("events", 'with "quotes"'), 6),
        (("events", "with é"), 7),
        (("events", "a", "b.c", "d"), 8),
        (("automata",), 10),
        (("automata", "FINGER 1"), 10),
        (("automata", "FINGER 1", "initial"), 10),
        (("automata", "FINGER 1", "transitions"), 12),
        (("automata", "FINGER 1", "transitions", 0), 13),
        (("automata", "FINGER 1", "transitions", 1), 15),
        (("automata", "FINGER 1", "transitions", 2), 15),
        (("automata", "FINGER 1", "transitions", 2, 2), 17),
        (("automata", "FINGER 1", "transitions", 3), 18),
        (("automata", "FINGER 1", "transitions", 4), 12),
        (("automata", "FINGER2", "marked", 1), 24),
        (("hands", 0), 27),
        (("hands", 0, "left"), 28),
        (("automata", "FINGER3", "inner", "key"), 30),
        (("automata", "FINGER4"), 10),
        (("nothing", "at", "all"), 1),
    ],
)
def test_a_path_in_toml_is_on_its_line(path: tuple[str | int, ...], line: int) -> None:
    text = TOML.replace("{ z = 1,\n", '"z"\n')
    assert Places(text, "toml").line(path) == line


def test_a_broken_text_still_has_lines() -> None:
    assert Places(TOML, "toml").line(("events", "slip")) == 4


def test_the_lines_of_windows_count_the_same() -> None:
    text = TOML.replace("\n", "\r\n")
    assert Places(text, "toml").line(("automata", "FINGER 1", "transitions", 0)) == 13


NAMES = st.text(min_size=1, max_size=4).filter(lambda name: name.isprintable())
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | NAMES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3),
    max_leaves=12,
)


@settings(deadline=None)  # the first example imports the parsers
@given(st.dictionaries(NAMES, VALUES, min_size=1, max_size=4))
def test_a_path_in_json_is_on_its_line(data: dict[str, object]) -> None:
    text = json.dumps(data, indent=1)
    places = Places(text, "json")
    lines = text.split("\n")

    def visit(value: object, path: tuple[str | int, ...]) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                assert lines[places.line((*path, key)) - 1].lstrip().startswith(json.dumps(key) + ":")
                visit(inner, (*path, key))
        elif isinstance(value, list):
            for k, inner in enumerate(value):
                if not isinstance(inner, dict | list):
                    assert lines[places.line((*path, k)) - 1].strip().rstrip(",") == json.dumps(inner)
                visit(inner, (*path, k))

    visit(data, ())


def test_keys_given_twice_are_listed_with_their_lines() -> None:
    text = 'a = 1\n[b]\nc = 1\nc = 2\n[d]\n[b]\nx = { y = 1,  y = 2 }\n"a" = 3'
    assert sorted(Places(text, "toml").repeated()) == [(("b",), [2, 6])]
    text = '{"a": {"b": 1,\n"b": 2},\n"a\\u0061": 1, "aa": [{"c": 1,\n"c": 2}]}'
    assert sorted(Places(text, "json").repeated()) == [(("a", "b"), [1, 2]), (("aa",), [3, 3])]
