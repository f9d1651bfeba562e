"""The published schema says what the reader reads."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thenar.errors import ModelError
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
    assert len(described) == 19
    assert [path for path, field in described.items() if not field.get("description")] == []


def test_a_sound_model_is_valid(glr: Path) -> None:
    SCHEMA.validate(SOUND)
    SCHEMA.validate(json.loads(glr.read_text()))
    assert loads(json.dumps(SOUND)).name == "lamp"


def test_the_models_in_the_documentation_are_valid() -> None:
    text = (PUBLISHED.parents[1] / "model-file.md").read_text()
    first = text.split("```toml\n")[1].split("```")[0]
    SCHEMA.validate(tomllib.loads(first))


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield path
    for step, inner in (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    ):
        yield from paths(inner, (*path, step))


@settings(deadline=None)  # the first example imports the parsers
@given(
    st.sampled_from([*paths(SOUND)][1:]),
    st.sampled_from([None, 7, -1, 1.5, True, "", "x -on-> x", [], ["x"], {}, "gone"]),
)
def test_the_schema_and_the_reader_refuse_the_same(path: tuple[Any, ...], value: Any) -> None:
    """Whatever single value is replaced or removed: what breaks the schema, the reader complains of."""
    model = json.loads(json.dumps(SOUND))
    owner = model
    for step in path[:-1]:
        owner = owner[step]
    if value == "gone":
        del owner[path[-1]]
    else:
        owner[path[-1]] = value
    if SCHEMA.is_valid(model):
        return  # what it means may still be wrong
    with pytest.raises(ModelError) as caught:
        loads(json.dumps(model))
    assert caught.value.mistakes


@pytest.mark.parametrize("extra", ["colour", "Name"])
def test_the_schema_knows_no_other_key(extra: str) -> None:
    assert not SCHEMA.is_valid(SOUND | {extra: "red"})
