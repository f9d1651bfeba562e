"""What the names of a CIF file stand for: groups, automata, instances of definitions, and what they declare."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, NoReturn

from lark import Token, Tree

from thenar.errors import did_you_mean
from thenar.io.cif.names import (
    Alg,
    Argument,
    Component,
    Const,
    Definition,
    Enum,
    Event,
    Literal,
    Location,
    Named,
    TypeName,
    Variable,
)
from thenar.io.cif.syntax import Node, children, fail, unsupported, words

__all__ = ["Scope", "expand"]

MAX_NESTING = 100  # components in components
MAX_COMPONENTS = 20_000  # a definition that holds ten of another that holds ten ... is soon too much
MAX_LOOKS = 2_000  # at known names for the one nearest to an unknown one


@dataclass(eq=False, slots=True)
class Scope:
    """A group or an automaton; names not found in it are looked for in ``outer``.

    A group may be continued in another file: then two scopes share their ``members``, and each lists in
    ``declared`` and ``items`` what its own file says.
    """

    name: str
    outer: Scope | None
    source: str
    kind: str = "group"  # or the kind of the automaton
    at: Node | None = None
    members: dict[str, Named] = field(default_factory=dict)
    declared: list[Named] = field(default_factory=list)
    items: list[Tree[Token]] = field(default_factory=list)
    locations: list[Location] = field(default_factory=list)
    chain: tuple[Definition, ...] = ()  # the definitions whose instances it is in
    depth: int = 0
    count: list[int] = field(default_factory=lambda: [0, 0])  # of all files: components, and those being made

    def absolute(self, name: str) -> str:
        """Return the absolute name of ``name``, declared here."""
        return f"{self.name}.{name}" if self.name else name

    def fail(self, node: Node | None, what: str) -> NoReturn:
        """Raise ModelError: ``node``, written here, is wrong."""
        fail(node, self.source, what)

    def plain(self, token: Node | None) -> str:
        """Return the name that ``token`` declares."""
        name = str(token).replace("$", "")
        if "." in name or "^" in name:
            self.fail(token, f"{name!r} is declared here; a name that is declared has no dot")
        return name

    def add(self, token: Node | None, named: Named) -> None:
        """Declare ``token`` as the name of ``named``."""
        name = self.plain(token)
        if name in self.members:
            self.fail(token, f"{self.absolute(name)!r} is declared twice; rename one of the two")
        self.members[name] = named
        self.declared.append(named)

    # -- declaring -----------------------------------------------------------------------------------------

    def fill(self, items: list[Any]) -> None:
        """Declare what ``items`` declare, and keep those that say something about it."""
        for item in items:
            match str(item.data):
                case "group":
                    self._group(item)
                case "automaton":
                    kind, name, body = _automaton(item)
                    inner = self._inner(name, kind, item)
                    self.add(name, inner)
                    inner.fill(body)
                case "group_def" | "automaton_def":
                    name = next(c for c in item.children if isinstance(c, Token) and c.type == "NAME")
                    self.add(name, Definition(item, self))
                case "instance":
                    name = item.children[0]
                    self.count_component(name)
                    self.add(name, Component(self.absolute(self.plain(name)), item, self))
                case "location":
                    self._location(item)
                case _:
                    self._declaration(item)
        for equations in [i for i in self.items if i.data == "equations"]:
            self._equations(equations, None)
        for location in self.locations:
            for equations in children(location.tree, "equations"):
                self._equations(equations, location)

    def _declaration(self, item: Any) -> None:
        parts = item.children
        match str(item.data):
            case "events":
                controllable = _controllable(parts[0])
                for name in parts[2:]:
                    channel = parts[1] is not None
                    self.add(name, Event(self.absolute(self.plain(name)), controllable, channel))
            case "enums":
                for tree in parts:
                    literals = tuple(self.plain(c) for c in tree.children[1:])
                    enum = Enum(self.absolute(self.plain(tree.children[0])), literals)
                    self.add(tree.children[0], enum)
                    for token, literal in zip(tree.children[1:], literals, strict=True):
                        self.add(token, Literal(enum, literal))
            case "types":
                for tree in parts:
                    self.add(tree.children[0], TypeName(self, tree.children[1]))
            case "constants":
                for tree in parts[1:]:
                    name, value = tree.children
                    self.add(name, Const(self.absolute(self.plain(name)), self, value))
            case "algs":
                for tree in parts[1:]:
                    name, value = tree.children
                    self.add(name, Alg(self.absolute(self.plain(name)), self, value))
            case "inputs":
                for name in parts[1:]:
                    self.add(name, Variable(self.absolute(self.plain(name)), name, self, parts[0], None, True))
            case "discs":
                for tree in parts[1:]:
                    name, value = tree.children
                    self.add(name, Variable(self.absolute(self.plain(name)), name, self, parts[0], value, False))
            case _:
                self.items.append(item)

    def _group(self, item: Any) -> None:
        name, *body = item.children
        known = self.members.get(self.plain(name))
        inner = self._inner(name, "group", item)
        if isinstance(known, Scope) and known.kind == "group" and known.source != self.source:
            inner.members = known.members
            self.declared.append(inner)
        else:
            self.add(name, inner)
        inner.fill(body)

    def _location(self, item: Any) -> None:
        token = item.children[0]
        location = Location(self, "*" if token is None else self.plain(token), len(self.locations), item)
        self.locations.append(location)
        if token is not None:
            self.add(token, location)

    def _equations(self, tree: Any, location: Location | None) -> None:
        for equation in tree.children:
            name, value = equation.children
            alg = self.members.get(self.plain(name))
            if not isinstance(alg, Alg):
                self.fail(name, f"an equation for {str(name)!r}, which is no algebraic variable of this component")
            elif alg.value is not None or any(known is location for known, _ in alg.by_location):
                self.fail(name, f"algebraic variable {alg.name!r} has two values")
            elif location is None:
                alg.value = value
            else:
                alg.by_location.append((location, value))

    def _inner(self, name: Any, kind: str, at: Node) -> Scope:
        self.count_component(name)
        absolute = self.absolute(self.plain(name))
        inner = Scope(absolute, self, self.source, kind, at, chain=self.chain, depth=self.depth + 1, count=self.count)
        if inner.depth > MAX_NESTING:
            self.fail(name, f"components nested deeper than {MAX_NESTING}")
        return inner

    def count_component(self, name: Node) -> None:
        """Count one more component; a model that unfolds without end is stopped here."""
        self.count[0] += 1
        if self.count[0] > MAX_COMPONENTS:
            self.fail(name, f"more than {MAX_COMPONENTS:,} components; make the model smaller")

    # -- looking up ----------------------------------------------------------------------------------------

    def find(self, token: Token) -> Named:
        """Return what ``token`` names here; the parameters of definitions are followed to what is given for them."""
        plain = self.members.get(token)  # most names are plain and near
        if plain is not None and not isinstance(plain, Argument):
            return plain
        text = str(token).replace("$", "")
        first, *rest = text.lstrip(".^").split(".")
        candidates = [self.root] if text[0] in ".^" else self.enclosing()
        here = next((scope for scope in candidates if first in scope.members), None)
        if here is None:
            self._unknown(token, text, first)
        found = here.members[first]
        done = first
        for part in rest:
            owner = expand(self._followed(found, token))
            if not isinstance(owner, Scope):
                self.fail(token, f"{text!r}: {done!r} is no component")
            if part not in owner.members:
                near = did_you_mean(part, islice(owner.members, MAX_LOOKS))
                self.fail(token, f"{text!r}: component {done!r} declares no {part!r}{near}")
            found = owner.members[part]
            done = f"{done}.{part}"
        return self._followed(found, token)

    def _followed(self, found: Named, token: Token) -> Named:
        """Return what an argument that is a name stands for; an expression stays an argument."""
        if not isinstance(found, Argument) or found.kind == "alg":
            return found
        if found.busy:
            self.fail(token, f"{str(token)!r} is a parameter that is given itself")
        if not isinstance(found.value, Token) or found.value.type != "NAME":
            found.scope.fail(found.value, f"a {found.kind} parameter asks for a name, not for an expression")
        found.busy = True
        try:
            return found.scope.find(found.value)
        finally:
            found.busy = False

    def _unknown(self, token: Token, text: str, first: str) -> NoReturn:
        if text in words():
            self.fail(token, unsupported(text))
        known = (name for scope in self.enclosing() for name in scope.members)
        self.fail(token, f"unknown name {first!r}{did_you_mean(first, islice(known, MAX_LOOKS))}")

    def enclosing(self) -> Iterator[Scope]:
        """Yield this scope, the one around it, and so on."""
        here: Scope | None = self
        while here is not None:
            yield here
            here = here.outer

    @property
    def root(self) -> Scope:
        """The scope of the file."""
        *_, outermost = self.enclosing()
        return outermost


def expand(named: Named) -> Named:
    """Return the scope of a component, instantiating its definition if nobody looked into it before."""
    if not isinstance(named, Component):
        return named
    if named.scope is None:
        count = named.outer.count
        if named.busy or count[1] > MAX_NESTING:
            named.outer.fail(named.tree, f"{named.name!r} is an instance of what has to be looked up in itself")
        named.busy = True
        count[1] += 1
        try:
            scope = _instantiate(named)
            scope.fill(_body(scope.chain[-1].tree))
            named.scope = scope
        finally:
            count[1] -= 1
            named.busy = False
    return named.scope


def _instantiate(component: Component) -> Scope:
    outer = component.outer
    parts: list[Any] = component.tree.children
    name, definition_name, *given = parts
    arguments = [g for g in given if g is not None]
    definition = outer.find(definition_name)
    if not isinstance(definition, Definition):
        outer.fail(definition_name, f"{str(definition_name)!r} is no definition")
    if definition in outer.chain:
        outer.fail(name, f"definition {str(definition_name)!r} holds an instance of itself")
    kind = _automaton(definition.tree)[0] if definition.tree.data == "automaton_def" else "group"
    scope = Scope(
        component.name, definition.scope, definition.scope.source, kind, component.tree,
        chain=(*outer.chain, definition), depth=outer.depth + 1, count=outer.count,
    )  # fmt: skip
    if scope.depth > MAX_NESTING:
        outer.fail(component.tree, f"components nested deeper than {MAX_NESTING}")
    parameters = list(_parameters(definition.tree))
    if len(parameters) != len(arguments):
        outer.fail(
            component.tree, f"{len(arguments)} arguments for the {len(parameters)} parameters of {definition_name}"
        )
    for (parameter_kind, token), value in zip(parameters, arguments, strict=True):
        scope.members[scope.plain(token)] = Argument(parameter_kind, outer, value)
    return scope


def _automaton(tree: Tree[Token]) -> tuple[str, Any, list[Any]]:
    """Return the kind, the name and the rest of an automaton or of a definition of one."""
    heading = [c for c in tree.children if isinstance(c, Token)]
    kind = str(heading[0]) if heading[0].type == "KIND" else "automaton"
    return kind, heading[-1], [c for c in tree.children if not isinstance(c, Token)]


def _body(tree: Tree[Token]) -> list[Any]:
    return [c for c in tree.children if isinstance(c, Tree) and c.data != "parameters"]


def _parameters(tree: Any) -> Iterator[tuple[str, Any]]:
    definitions: Any = children(tree, "parameters")[0]
    for parameter in definitions.children:
        if parameter is None:
            continue
        kind = str(parameter.data).removesuffix("_parameter")
        for part in parameter.children:
            if isinstance(part, Tree) and part.data == "flagged":
                yield kind, part.children[0]
            elif isinstance(part, Token) and not (kind == "component" and part is parameter.children[0]):
                yield kind, part


def _controllable(kind: Tree[Token]) -> bool | None:
    first = str(kind.children[0])
    return None if first == "event" else first == "controllable"
