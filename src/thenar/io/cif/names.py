"""What names of a CIF file can stand for."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias, Union

from lark import Token, Tree

from thenar.io.cif.syntax import Node

if TYPE_CHECKING:
    from thenar.io.cif.scopes import Scope

__all__ = [
    "Alg",
    "Argument",
    "Component",
    "Const",
    "Definition",
    "Enum",
    "Event",
    "Literal",
    "Location",
    "Named",
    "TypeName",
    "Variable",
]


@dataclass(eq=False, slots=True)
class Event:
    """An event; ``controllable`` is None where the file does not say, ``channel`` if it carries data."""

    name: str
    controllable: bool | None
    channel: bool


@dataclass(eq=False, slots=True)
class Variable:
    """A variable: of an automaton (``disc``), or one that changes by itself (``input``)."""

    name: str
    at: Token
    scope: Scope
    type: Tree[Token]
    initial: Node | None  # as the text gives it
    input: bool


@dataclass(eq=False, slots=True)
class Alg:
    """A name for an expression, that may be another one in each location of its automaton."""

    name: str
    scope: Scope
    value: Node | None
    by_location: list[tuple[Location, Node]] = field(default_factory=list)


@dataclass(eq=False, slots=True)
class Const:
    """A name for a value."""

    name: str
    scope: Scope
    value: Node


@dataclass(eq=False, slots=True)
class Enum:
    """A type with the literals ``literals``."""

    name: str
    literals: tuple[str, ...]


@dataclass(eq=False, slots=True)
class Literal:
    """A literal of an enumeration."""

    enum: Enum
    name: str


@dataclass(eq=False, slots=True)
class TypeName:
    """A name for a type."""

    scope: Scope
    type: Tree[Token]


@dataclass(eq=False, slots=True)
class Location:
    """A location of an automaton."""

    automaton: Scope
    name: str
    position: int  # among the locations of the automaton
    tree: Tree[Token]


@dataclass(eq=False, slots=True)
class Argument:
    """What an instance gives for a parameter: ``value`` means what it means in ``scope``."""

    kind: str
    scope: Scope
    value: Node
    busy: bool = False  # while it is looked up


@dataclass(eq=False, slots=True)
class Definition:
    """A component with parameters, to be instantiated."""

    tree: Tree[Token]
    scope: Scope


@dataclass(eq=False, slots=True)
class Component:
    """An instance of a definition; ``scope`` is filled when it is first looked into."""

    name: str
    tree: Tree[Token]
    outer: Scope
    scope: Scope | None = None
    busy: bool = False  # while its definition is looked up


Named: TypeAlias = Union[
    Event,
    Variable,
    Alg,
    Const,
    Enum,
    Literal,
    TypeName,
    Location,
    Argument,
    Definition,
    Component,
    "Scope",
]
"""Any of them, or a group or an automaton that is there without a definition."""
