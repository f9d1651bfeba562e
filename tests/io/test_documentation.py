"""The page about the model file tells the truth."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from thenar.errors import InputError
from thenar.io import expressions, loads, meaning
from thenar.io.schema import AutomatonTable, ConditionTable, EventTable, ModelFile, TransitionTable, VariableTable
from thenar.model.expressions import MAX_DEPTH
from thenar.model.variables import MAX_VALUES

PAGE = (Path(__file__).parents[2] / "docs" / "model-file.md").read_text()
BLOCKS = re.findall(r"```(toml|json|text)\n(.*?)```", PAGE, re.DOTALL)


def test_each_model_on_the_page_loads_or_fails_as_shown() -> None:
    shown = 0
    for (format, text), (after, output) in zip(BLOCKS, [*BLOCKS[1:], ("", "")], strict=True):
        if format == "text":
            continue
        shown += 1
        if after == "text":
            with pytest.raises(InputError) as caught:
                loads(text, format, f"hand.{format}")
            assert str(caught.value) == output.rstrip("\n")
        else:
            loads(text, format)
    assert shown >= 3


def test_each_key_is_explained_on_the_page() -> None:
    tables = (ModelFile, AutomatonTable, EventTable, VariableTable, TransitionTable, ConditionTable)
    keys = [f.alias or k for table in tables for k, f in table.model_fields.items()]
    assert [key for key in keys if f"`{key}`" not in PAGE] == []


def test_the_limits_on_the_page_are_those_of_the_reader() -> None:
    limits = (MAX_VALUES, meaning.MAX_ALL_VALUES, expressions.MAX_EXPRESSION, expressions.MAX_TEXT, MAX_DEPTH)
    assert [limit for limit in (*limits, meaning.MAX_MISTAKES) if f"{limit:,}" not in PAGE] == []
