"""The schema of a table of names: which keys there are beside a file, and what each one means."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from thenar.io.schema import EventTable, Table

__all__ = ["AutomatonNames", "AutomatonTable", "ProblemTable"]


class NamedEvent(EventTable):
    """An event of the file, and what it is."""

    name: str = Field(description="What the event is called.")


class AutomatonNames(Table):
    """What the file of one automaton does not say."""

    kind: Literal["plant", "spec"] = Field(default="plant", description="What the automaton is.")
    name: str = Field(description="What it is called.")
    says: str = Field(default="", description="What it says, in words.")
    events: dict[str, NamedEvent] | None = Field(
        default=None, description="By what the file calls them, the events of the automaton, in order."
    )
    size: Annotated[list[int], Field(min_length=2, max_length=2)] = Field(
        description="How many states and transitions the automaton has: what the file has too, if they belong together."
    )
    added: int = Field(default=0, description="How many states were added in the file, after the others.")
    states: list[str] | None = Field(
        default=None, description="The states, in the order in which the file numbers them."
    )


class AutomatonTable(Table):
    """An automaton of a file that holds several."""

    name: str = Field(description="What it is called.")
    says: str = Field(default="", description="What it says, in words.")
    states: dict[str, str] = Field(default={}, description="The states whose names the file does not have, by its own.")


class ProblemTable(Table):
    """What the file of a whole problem does not say; everything by what the file calls it."""

    name: str = Field(default="", description="The name of the problem.")
    description: str = Field(default="", description="What the problem is about.")
    events: dict[str, NamedEvent] = Field(description="Every event, in the order of the alphabet.")
    automata: dict[str, AutomatonTable] = Field(description="Every automaton.")
    variables: dict[str, str] = Field(default={}, description="The names of variables.")
    literals: dict[str, str] = Field(default={}, description="The values of enumerations.")
