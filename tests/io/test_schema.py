"""The published schema says what the reader reads."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thenar.errors import InputError, ModelError
from thenar.io import json_schema, loads

PUBLISHED = Path(__file__).parents[2] / "docs" / "schema" / "thenar-model.schema.json"
SCHEMA = jsonschema.Draft202012Validator(json_schema())
SOUND: dict[str, Any] = {
    "$schema": "thenar-model.schema.json",
    "name": "lamp",
    "events": {"on": {"controllable": False}, "off": {}},
    "automata": {
        "LAMP": {
            "kind": "plant",
            "initial": "dark",
            "marked": ["dark"],
            "states": ["dark", "lit"],
            "alphabet": ["on"],
            "transitions": ["dark -on-> lit", ["lit", "off", "dark"]],
            "note": "a note",
            "says": "on and off",
        }
    },
    "computed": {"G": [2, 2]},
    "published": {"G": [2, 2]},
}
EXTENDED: dict[str, Any] = {
    "initial": "n == 0",
    "marked": "not ready",
    "events": {"on": {}, "off": {}},
    "variables": {
        "n": {"values": "-1..3", "initial": 0, "marked": [0, 1], "note": "a note"},
        "ready": {"values": "bool"},
        "light": {"values": ["red", "green"], "initial": ["red", "green"], "marked": "red"},
    },
    "automata": {
        "LAMP": {
            "kind": "plant",
            "initial": ["dark", "lit"],
            "nondeterministic": True,
            "transitions": [
                {"arrow": "dark -on-> lit", "when": "n < 3", "do": {"n": "n + 1", "ready": True, "light": "green"}},
                {"arrow": ["lit", "off", "dark"], "do": {"n": 0}},
                "lit -off-> lit",
            ],
        }
    },
    "conditions": [
        {"kind": "spec", "invariant": "n < 3 or LAMP.lit", "name": "few", "says": "Few.", "note": "a note"},
        {"kind": "spec", "event": "on", "needs": "ready"},
        {"kind": "plant", "event": "off", "disabled_when": "ready"},
    ],
}


def test_the_published_schema_is_the_one_in_force() -> None:
    expected = json.dumps(json_schema(), indent=2) + "\n"
    assert PUBLISHED.read_text() == expected, f"write json.dumps(thenar.io.json_schema(), indent=2) to {PUBLISHED}"


def test_the_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(json_schema())


def test_every_field_is_described() -> None:
    def fields(schema: Any, path: str = "") -> Iterator[tuple[str, Any]]:
        for name, field in schema.get("properties", {}).items():
            yield f"{path}.{name}", field
        for name, definition in schema.get("$defs", {}).items():
            assert definition.get("description"), name
            yield from fields(definition, name)

    described = dict(fields(json_schema()))
    assert len(described) == 39
    assert [path for path, field in described.items() if not field.get("description")] == []


def test_a_sound_model_is_valid(glr: Path) -> None:
    SCHEMA.validate(SOUND)
    SCHEMA.validate(EXTENDED)
    SCHEMA.validate(json.loads(glr.read_text()))
    assert loads(json.dumps(SOUND)).name == "lamp"
    assert "3 variables, 3 conditions" in repr(loads(json.dumps(EXTENDED)))


def test_the_models_in_the_documentation_are_valid() -> None:
    text = (PUBLISHED.parents[1] / "model-file.md").read_text()
    for k in (1, 2):
        SCHEMA.validate(tomllib.loads(text.split("```toml\n")[k].split("```")[0]))


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield path
    for step, inner in (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    ):
        yield from paths(inner, (*path, step))


@settings(deadline=None)  # the first example imports the parsers
@given(
    st.sampled_from([(model, path) for model in (SOUND, EXTENDED) for path in [*paths(model)][1:]]),
    st.sampled_from([None, 7, -1, 1.5, True, "", "x -on-> x", [], ["x"], [[]], {}, {"x": {}}, "gone"]),
)
def test_the_schema_and_the_reader_refuse_the_same(where: tuple[Any, tuple[Any, ...]], value: Any) -> None:
    """Whatever single value is replaced or removed: what breaks the schema, the reader complains of."""
    sound, path = where
    model = json.loads(json.dumps(sound))
    owner = model
    for step in path[:-1]:
        owner = owner[step]
    if value == "gone":
        del owner[path[-1]]
    else:
        owner[path[-1]] = value
    if SCHEMA.is_valid(model):
        with suppress(InputError):  # what it means may still be wrong
            loads(json.dumps(model))
        return
    with pytest.raises(ModelError) as caught:
        loads(json.dumps(model))
    assert caught.value.mistakes


@pytest.mark.parametrize("extra", ["colour", "Name"])
def test_the_schema_knows_no_other_key(extra: str) -> None:
    assert not SCHEMA.is_valid(SOUND | {extra: "red"})
