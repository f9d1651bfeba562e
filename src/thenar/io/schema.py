"""The schema of a model file, TOML or JSON: which tables and keys there are, and what each one means."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaMode

__all__ = ["AutomatonTable", "EventTable", "ModelFile", "PlainSchema"]


class PlainSchema(GenerateJsonSchema):
    """JSON Schema without a title on every field: an editor shows the key already."""

    def field_title_should_be_set(self, schema: object) -> bool:
        """Never: the descriptions say more."""
        return False

    def generate(self, schema: object, mode: JsonSchemaMode = "validation") -> dict[str, object]:
        """Generate, and give the whole a title that says what it is."""
        return super().generate(schema, mode) | {"title": "thenar model"}  # type: ignore[arg-type]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


_ARROW = {"pattern": r"\s-\S+->\s"}

StateName = Annotated[str, Field(min_length=1)]
Arrows = Annotated[
    str,
    Field(
        description="Arrow text 'state -event-> state'; arrows can be chained, and one can carry several events.",
        examples=["idle -start-> busy -finish,abort-> idle"],
        json_schema_extra=_ARROW,
    ),
]
Triple = Annotated[
    list[str],
    Field(min_length=3, max_length=3, description="[source, event, target].", examples=[["idle", "start", "busy"]]),
]
Size = Annotated[
    list[Annotated[int, Field(ge=0)]],
    Field(min_length=2, max_length=2, description="[states, transitions].", examples=[[90, 242]]),
]


class EventTable(_Table):
    """The properties of an event; {} is a controllable, observable event that cannot be forced."""

    controllable: bool = Field(default=True, description="Can a supervisor disable the event?")
    observable: bool = Field(default=True, description="Does a supervisor see the event happen?")
    forcible: bool = Field(default=False, description="Can a supervisor make the event happen before others do?")
    meaning: str = Field(default="", description="What happens, in words.")


class AutomatonTable(_Table):
    """An automaton: what part of the plant can do, or what a specification allows."""

    kind: Literal["plant", "spec"] = Field(
        description="'plant': the automaton says what can happen; 'spec': it says what may happen."
    )
    initial: StateName = Field(description="The state in which the automaton starts.")
    marked: list[StateName] = Field(
        default=[], description="The marked states: a task is complete where every automaton is in one."
    )
    states: list[StateName] = Field(
        default=[],
        description="The states, in the order of their numbers; any other name is then an error. "
        "Without it, the states are those mentioned in initial and transitions.",
    )
    alphabet: list[str] = Field(
        default=[], description="Events that belong to the automaton though no transition carries them: it blocks them."
    )
    transitions: list[Arrows | Triple] = Field(
        default=[], description="The transitions, as arrow texts or as triples [source, event, target]."
    )
    note: str = Field(default="", description="A remark to whoever reads the file.")
    says: str = Field(default="", description="What the automaton says, in words; explanations quote it.")


class ModelFile(_Table):
    """A control problem of plants and specifications over one alphabet, or a part of one."""

    name: str = Field(default="", description="The name of the problem.")
    description: str = Field(default="", description="What the problem is about.")
    events: dict[str, EventTable] = Field(
        default={},
        description="Every event that the automata use. The order is that of the alphabet, and so numbers the states.",
        json_schema_extra={"propertyNames": {"pattern": r"^[^\s,]+$"}},
    )
    automata: dict[str, AutomatonTable] = Field(
        default={}, description="The automata, by name; at least one is a plant."
    )
    computed: dict[str, Size] = Field(
        default={},
        description="Computed sizes [states, transitions], kept for comparison; synthesis does not read them.",
    )
    published: dict[str, Size] = Field(
        default={},
        description="Published sizes [states, transitions], kept for comparison; synthesis does not read them.",
    )
    schema_: str = Field(
        default="", alias="$schema", description="Where an editor finds this schema; thenar does not read it."
    )
