"""Model files: read one with :func:`load` or :func:`loads`, write one with :func:`save` or :func:`dumps`."""

from __future__ import annotations

from typing import Any

from thenar.io.files import atomic_write, check_writable
from thenar.io.formats import FORMATS, format_named, format_of
from thenar.io.read import load, loads
from thenar.io.write import Saved, dumps, save

__all__ = [
    "FORMATS",
    "Saved",
    "atomic_write",
    "check_writable",
    "dumps",
    "format_named",
    "format_of",
    "json_schema",
    "load",
    "loads",
    "save",
]


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of the model file; ``docs/schema/thenar-model.schema.json`` is its copy for editors.

    >>> sorted(json_schema()["properties"])  # doctest: +ELLIPSIS
    ['$schema', 'automata', 'computed', 'conditions', 'description', 'events', ..., 'variables']
    """
    from thenar.io.schema import ModelFile, PlainSchema

    draft = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return draft | ModelFile.model_json_schema(schema_generator=PlainSchema)
