"""The schema of a model file, TOML or JSON: which tables and keys there are, and what each one means."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaMode

__all__ = [
    "RANGE",
    "AutomatonTable",
    "ConditionTable",
    "EventTable",
    "ModelFile",
    "PlainSchema",
    "Table",
    "TransitionTable",
    "VariableTable",
]

RANGE = r"^(-?[0-9]{1,19})\.\.(-?[0-9]{1,19})$"  # "0..5"; 19 digits are 64 bits


class PlainSchema(GenerateJsonSchema):
    """JSON Schema without a title on every field: an editor shows the key already."""

    def field_title_should_be_set(self, schema: object) -> bool:
        """Never: the descriptions say more."""
        return False

    def generate(self, schema: object, mode: JsonSchemaMode = "validation") -> dict[str, object]:
        """Generate, and give the whole a title that says what it is."""
        return super().generate(schema, mode) | {"title": "thenar model"}  # type: ignore[arg-type]


class Table(BaseModel):
    """A table whose keys are all known, and whose values are of their types already."""

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
Value = bool | int | str
Size = Annotated[
    list[Annotated[int, Field(ge=0)]],
    Field(min_length=2, max_length=2, description="[states, transitions].", examples=[[90, 242]]),
]


def _shape(value: Any) -> str:
    """Tell what an author meant a value to be, so that messages speak of that alone."""
    return "table" if isinstance(value, dict | BaseModel) else _one_or_list(value)


def _one_or_list(value: Any) -> str:
    return "list" if isinstance(value, list) else "one"


StateNames = Annotated[
    Annotated[StateName, Tag("one")] | Annotated[list[StateName], Field(min_length=1), Tag("list")],
    Discriminator(_one_or_list),
]
Lines = Annotated[
    Annotated[str, Tag("one"), Field(min_length=1)] | Annotated[list[StateName], Tag("list")],
    Discriminator(_one_or_list),
]
Values = Annotated[Annotated[Value, Tag("one")] | Annotated[list[Value], Tag("list")], Discriminator(_one_or_list)]


class EventTable(Table):
    """The properties of an event; {} is a controllable, observable event that cannot be forced."""

    controllable: bool = Field(default=True, description="Can a supervisor disable the event?")
    observable: bool = Field(default=True, description="Does a supervisor see the event happen?")
    forcible: bool = Field(default=False, description="Can a supervisor make the event happen before others do?")
    meaning: str = Field(default="", description="What happens, in words.")


class VariableTable(Table):
    """A variable: the values that it can take, and those that it has at first."""

    values: Annotated[
        Annotated[str, Tag("one"), Field(json_schema_extra={"pattern": rf"{RANGE}|^bool$"})]
        | Annotated[list[Value], Field(min_length=1), Tag("list")],
        Discriminator(_one_or_list),
    ] = Field(
        description="Its values: 'lowest..highest', 'bool', or a list of names, whole numbers or truths.",
        examples=["0..5", "bool", ["red", "green"]],
    )
    initial: Values = Field(
        default_factory=list,
        description="The value that it has at first, or a list of those that it may have; by default the first one.",
    )
    marked: Values = Field(
        default_factory=list,
        description="The value that it has in a marked state, or a list of those that it may have; by default all.",
    )
    note: str = Field(default="", description="A remark to whoever reads the file.")


class TransitionTable(Table):
    """A transition with a guard and updates."""

    arrow: Arrows | Triple = Field(description="The transition, or several with the same guard and updates.")
    when: str = Field(
        default="", description="The guard: where the transition is possible.", examples=["stock < 3 and not DOOR.open"]
    )
    do: dict[str, Value] = Field(
        default={},
        description="The updates: for each variable that changes, its new value, over the values before.",
        examples=[{"stock": "stock + 1", "lamp": "green"}],
    )


Transition = Annotated[
    Annotated[Arrows, Tag("one")] | Annotated[Triple, Tag("list")] | Annotated[TransitionTable, Tag("table")],
    Discriminator(_shape),
]


class AutomatonTable(Table):
    """An automaton: what part of the plant can do, or what a specification allows."""

    kind: Literal["plant", "spec"] = Field(
        description="'plant': the automaton says what can happen; 'spec': it says what may happen."
    )
    initial: StateNames = Field(
        description="The state in which the automaton starts, or a list of those in which it may."
    )
    marked: Lines = Field(
        default=[],
        description="The marked states: a task is complete where every automaton is in one. "
        "A list, or a text with one a line.",
    )
    states: Lines = Field(
        default=[],
        description="The states, in the order of their numbers; any other name is then an error. "
        "Without it, the states are those mentioned in initial and transitions. A list, or a text with one a line.",
    )
    alphabet: list[str] = Field(
        default=[], description="Events that belong to the automaton though no transition carries them: it blocks them."
    )
    transitions: Annotated[
        Annotated[str, Tag("one")] | Annotated[list[Transition], Tag("list")], Discriminator(_one_or_list)
    ] = Field(
        default=[],
        description="The transitions, as arrow texts, as triples [source, event, target], or as tables "
        "with guards and updates; or one text with an arrow text a line.",
    )
    nondeterministic: bool = Field(
        default=False, description="May an event lead from a state to several, though no guards tell them apart?"
    )
    note: str = Field(default="", description="A remark to whoever reads the file.")
    says: str = Field(default="", description="What the automaton says, in words; explanations quote it.")


class ConditionTable(Table):
    """What holds in every state, or where an event can or may happen."""

    model_config = ConfigDict(
        json_schema_extra={
            "oneOf": [
                {"required": ["invariant"], "not": {"required": ["event"]}},
                {"required": ["event", "needs"]},
                {"required": ["event", "disabled_when"]},
            ]
        }
    )

    kind: Literal["plant", "spec"] = Field(
        description="'plant': the condition says what can be; 'spec': it says what may be."
    )
    name: str = Field(default="", description="What messages call it.")
    invariant: str = Field(
        default="", description="What holds in every state.", examples=["not (CAT.room1 and MOUSE.room1)"]
    )
    event: str = Field(default="", description="The event that the condition is about.")
    needs: str = Field(
        default="", description="The event happens only where this holds.", examples=["CUP.up and stock > 0"]
    )
    disabled_when: str = Field(
        default="", description="The event does not happen where this holds.", examples=["stock == 0 or DOOR.open"]
    )
    note: str = Field(default="", description="A remark to whoever reads the file.")
    says: str = Field(default="", description="What the condition says, in words; explanations quote it.")


class ModelFile(Table):
    """A control problem of plants and specifications over one alphabet, or a part of one."""

    name: str = Field(default="", description="The name of the problem.")
    description: str = Field(default="", description="What the problem is about.")
    initial: str = Field(
        default="", description="An expression that narrows where the automata and variables start together."
    )
    marked: str = Field(
        default="", description="An expression that narrows which of the states that all of them mark are marked."
    )
    events: dict[str, EventTable] = Field(
        default={},
        description="Every event that the automata use. The order is that of the alphabet, and so numbers the states.",
        json_schema_extra={"propertyNames": {"pattern": r"^[^\s,]+$"}},
    )
    variables: dict[str, VariableTable] = Field(
        default={}, description="The variables, by name: what guards speak of and transitions update."
    )
    automata: dict[str, AutomatonTable] = Field(
        default={}, description="The automata, by name; at least one is a plant."
    )
    conditions: list[ConditionTable] = Field(
        default=[], description="What holds besides: invariants, and what events need in order to happen."
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
