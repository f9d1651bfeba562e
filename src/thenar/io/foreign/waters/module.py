"""What the names of a Waters module stand for: constants, events, arrays and lists of events; and its loops."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from typing import TypeAlias

from thenar.errors import Mistake, ModelError, did_you_mean
from thenar.io.foreign.labels import written_name
from thenar.io.foreign.xml import Element, fail
from thenar.model.events import Event

__all__ = ["ACCEPTING", "FORBIDDEN", "Bindings", "Module", "Static", "expressions", "identifier"]

Static: TypeAlias = int | str | range | tuple[int | str, ...]
"""What is known from the text: a number, an atom of an enumeration, or a range or set of them."""
Bindings: TypeAlias = Mapping[str, Static]

ACCEPTING, FORBIDDEN = ":accepting", ":forbidden"
MAX_STEPS = 2_000_000  # edges, labels and components, all loops unfolded
MAX_TURNS = 250_000  # of all loops
MAX_OPEN = 50_000  # next values that all guards leave open
MAX_RANGE = 1_000_000  # values of a range
MAX_EVENTS = 100_000  # events of all arrays
MAX_DEPTH = 100  # loops, lists and operators in one another
_IDENTIFIERS = ("SimpleIdentifier", "IndexedIdentifier", "QualifiedIdentifier")
_EXPRESSIONS = (
    *_IDENTIFIERS, "IntConstant", "BinaryExpression", "UnaryExpression", "EnumSetExpression", "FunctionCallExpression",
)  # fmt: skip
_LOOK = ("ColorGeometry", "LabelGeometry", "PointGeometry", "SplineGeometry", "BoxGeometry", "InitialArrowGeometry",
         "StartPointGeometry", "EndPointGeometry", "IconGeometry", "AttributeMap", "Attributes", "Comment")  # fmt: skip


def expressions(element: Element) -> list[Element]:
    """Return the children of ``element`` that are expressions."""
    return list(element.all(*_EXPRESSIONS))


def identifier(element: Element) -> Element | None:
    """Return the identifier among the children of ``element`` that names it."""
    return next(element.all(*_IDENTIFIERS), None)


class Module:
    """The declarations of a module.

    ``events`` are all events by their names in the file, arrays unfolded (``e[1][2]``); ``propositions`` are what
    marks states.
    """

    def __init__(self, root: Element) -> None:
        self.root = root
        self.events: dict[str, Event] = {}
        self.propositions: dict[str, None] = {}
        self._arrays: dict[str, list[str]] = {}  # of a name that is not fully indexed, the events that it stands for
        self._aliases: dict[str, list[str]] = {}
        self._taken: dict[str, str] = {}
        self._constants: dict[str, Static] = {}
        self._waiting: dict[str, Element] = {}
        self._busy: list[str] = []
        self._steps = self._turns = self._open = 0
        for tag in ("ConstantAliasList", "ParameterList"):
            for group in root.all(tag):
                for alias in group.all("ConstantAlias", "SimpleParameter", "IntParameter", "RangeParameter"):
                    self._waiting[alias.get("Name")] = alias
        for name in self._waiting:
            self.constant(name)
        for group in root.all("EventDeclList"):
            for declaration in group.all("EventDecl"):
                self._declare(declaration)
        for group in root.all("EventAliasList"):
            self._alias_list(group, {}, 0)

    def step(self, element: Element, n: int = 1) -> None:
        """Count ``n`` things that the module unfolds to; fail beyond two million."""
        self._steps += n
        if self._steps > MAX_STEPS:
            fail(element, f"the module unfolds to more than {MAX_STEPS:,} edges, labels and components")

    def open(self, element: Element, n: int) -> None:
        """Count ``n`` next values that a guard leaves open; fail beyond 50,000."""
        self._open += n
        if self._open > MAX_OPEN:
            fail(element, f"the guards up to here leave more than {MAX_OPEN:,} next values open; write actions")

    @property
    def marking(self) -> str:
        """The proposition that marks: ``:accepting``, or the only one there is if it is called otherwise."""
        others = [p for p in self.propositions if p != FORBIDDEN]
        return others[0] if len(others) == 1 else ACCEPTING

    # -- constants -------------------------------------------------------------------------------------------

    def constant(self, name: str, depth: int = 0) -> Static | None:
        """Return the value of the constant called ``name``, None if there is none."""
        if name in self._constants or name not in self._waiting:
            return self._constants.get(name)
        alias = self._waiting[name]
        if name in self._busy:
            fail(alias, f"constant {name!r} is defined by itself")
        self._busy.append(name)
        holder = alias.first("ConstantAliasExpression") or alias
        values = expressions(holder)
        if not values:
            fail(alias, f"parameter {name!r} has no value; write a constant, the module is read for itself")
        self._constants[name] = self.value(values[-1], {}, depth)
        self._busy.pop()
        return self._constants[name]

    def value(self, element: Element, bindings: Bindings, depth: int = 0) -> Static:
        """Return what a constant expression is; ``bindings`` are the values of the loops' variables."""
        if depth > MAX_DEPTH:
            fail(element, f"an expression nested deeper than {MAX_DEPTH}")
        parts = expressions(element)
        match element.tag:
            case "IntConstant":
                return whole(element)
            case "SimpleIdentifier":
                name = element.get("Name")
                known = bindings[name] if name in bindings else self.constant(name, depth + 1)
                return name if known is None else known
            case "IndexedIdentifier" | "QualifiedIdentifier":
                return self.name(element, bindings, depth)
            case "EnumSetExpression":
                return tuple(self.name(p, bindings, depth + 1) for p in parts)
            case "UnaryExpression" if len(parts) == 1:
                n = self.number(parts[0], bindings, depth + 1)
                if element.get("Operator") in ("-", "!"):
                    return -n if element.get("Operator") == "-" else int(not n)
            case "BinaryExpression" if len(parts) == 2:
                operator = element.get("Operator")
                a, b = (self.value(p, bindings, depth + 1) for p in parts)
                if operator in ("==", "!="):
                    return int((a == b) == (operator == "=="))
                a, b = (self._number(v, p) for v, p in zip((a, b), parts, strict=True))
                if operator == "..":
                    if b - a >= MAX_RANGE:
                        fail(element, f"the range {a}..{b} has more than {MAX_RANGE:,} values")
                    return range(a, b + 1)
                if operator not in _STATIC or (operator in "/%" and not b):
                    fail(element, f"cannot be worked out: {a} {operator} {b}")
                result = _STATIC[operator](a, b)
                if abs(result) >= 2**31:
                    fail(element, f"the number {result} is too large; Waters' numbers have 32 bits")
                return result
        raise _wrong(element, "a constant is asked for here")

    def number(self, element: Element, bindings: Bindings, depth: int = 0) -> int:
        """Return the number that a constant expression is."""
        return self._number(self.value(element, bindings, depth), element)

    def _number(self, value: Static, element: Element) -> int:
        if not isinstance(value, int):
            fail(element, f"a number is asked for here, and {value!r} is none; is a constant missing?")
        return value

    def range(self, element: Element, bindings: Bindings) -> Sequence[int | str]:
        """Return the values of a range or set, in order, each once."""
        value = self.value(element, bindings)
        if not isinstance(value, range | tuple):
            fail(element, f"a range is asked for here, and {value!r} is none; is a constant missing?")
        return value if isinstance(value, range) else tuple(dict.fromkeys(value))

    def name(self, element: Element, bindings: Bindings, depth: int = 0) -> str:
        """Return what an identifier is called, its indexes worked out: ``R[1].x``."""
        match element.tag:
            case "SimpleIdentifier":
                return element.get("Name")
            case "IndexedIdentifier":
                indexes = [self.value(p, bindings, depth + 1) for p in expressions(element)]
                for i in indexes:
                    if isinstance(i, range | tuple):
                        fail(element, "an index is a number or an atom, and this one is a range")
                return element.get("Name") + "".join(f"[{i}]" for i in indexes)
            case "QualifiedIdentifier" if depth < MAX_DEPTH:
                return ".".join(self.name(p, bindings, depth + 1) for p in expressions(element))
        raise _wrong(element, "a name is asked for here")

    # -- loops -----------------------------------------------------------------------------------------------

    def unfold(
        self, element: Element, bindings: Bindings, depth: int, inner: Callable[[Element, Bindings, int], None]
    ) -> bool:
        """Call ``inner`` for what is in a loop or a condition; return whether ``element`` is one."""
        is_loop = element.tag.startswith("Foreach")
        if not is_loop and not element.tag.startswith("Conditional"):
            return False
        if depth > MAX_DEPTH:
            fail(element, f"loops nested deeper than {MAX_DEPTH}")
        heads = expressions(element)
        guards = [g for holder in element.all("Guard", "Guards") for g in expressions(holder)]
        if is_loop:
            if not heads:
                fail(element, "a loop without a range")
            values = self.range(heads[0], bindings)
            turns: list[Bindings] = [{**bindings, element.get("Name"): v} for v in values[: MAX_TURNS + 1]]
        else:
            turns, guards = [bindings], [*guards, *([] if guards else heads[:1])]
        self._turns += len(turns)
        if self._turns > MAX_TURNS:
            fail(element, f"the loops up to here take more than {MAX_TURNS:,} turns")
        for turn in turns:
            if all(self.number(g, turn) for g in guards):
                for child in element.children:
                    if child not in heads[:1] and child.tag not in ("Guard", "Guards") and child.tag not in _LOOK:
                        inner(child, turn, depth + 1)
        return True

    # -- events ----------------------------------------------------------------------------------------------

    def _declare(self, element: Element) -> None:
        name, kind = element.get("Name"), element.get("Kind").upper()
        if name in self.events or name in self._arrays or name in self.propositions:
            fail(element, f"event {name!r} is declared twice")
        if kind == "PROPOSITION":
            self.propositions[name] = None
            return
        if kind not in ("CONTROLLABLE", "UNCONTROLLABLE"):
            fail(element, f"an event of kind {kind!r}; there are CONTROLLABLE, UNCONTROLLABLE and PROPOSITION")
        observable = element.attributes.get("Observable", "true").lower() != "false"
        ranges = [self.range(r, {}) for group in element.all("RangeList") for r in expressions(group)]
        count = 1
        for r in ranges:
            count *= len(r)
        if len(self.events) + count > MAX_EVENTS:
            fail(element, f"the events up to here are more than {MAX_EVENTS:,}")
        if ranges:
            self._arrays[name] = []
        for indexes in product(*ranges) if count else ():  # it would list all ranges first
            full = name
            for i in indexes:
                self._arrays.setdefault(full, [])
                full += f"[{i}]"
            self.events[full] = Event(written_name(full, self._taken), kind == "CONTROLLABLE", observable)
            prefix = name
            for i in indexes:
                self._arrays[prefix].append(full)
                prefix += f"[{i}]"

    def _alias_list(self, group: Element, bindings: Bindings, depth: int) -> None:
        for child in group.children:
            self._alias(child, bindings, depth)

    def _alias(self, element: Element, bindings: Bindings, depth: int) -> None:
        if element.tag == "EventAliasList":
            self._alias_list(element, bindings, depth)
        elif element.tag == "EventAlias":
            named = identifier(element)
            name = element.attributes.get("Name") or (self.name(named, bindings) if named else element.get("Name"))
            holder = element.first("EventAliasExpression") or element
            content = [c for c in holder.children if c is not named]
            self._aliases[name] = list(dict.fromkeys(e for c in content for e in self.labels(c, bindings)))
        elif not self.unfold(element, bindings, depth, self._alias) and element.tag not in _LOOK:
            fail(element, f"<{element.tag}> is not read here")

    def labels(self, element: Element, bindings: Bindings) -> list[str]:
        """Return the events and propositions that ``element``, a name or a list with loops, stands for."""
        found: list[str] = []

        def collect(item: Element, turn: Bindings, depth: int) -> None:
            if item.tag in _IDENTIFIERS:
                found.extend(self._named(item, turn))
            elif not self.unfold(item, turn, depth, collect) and item.tag not in _LOOK:
                if not item.tag.endswith(("List", "Block")) or depth > MAX_DEPTH:
                    fail(item, f"<{item.tag}> is not read here; the names of events are asked for")
                for child in item.children:
                    collect(child, turn, depth + 1)

        collect(element, bindings, 0)
        return found

    def _named(self, element: Element, bindings: Bindings) -> Sequence[str]:
        name = self.name(element, bindings)
        for known in (self._aliases, self._arrays):
            if name in known:
                self.step(element, len(known[name]))
                return known[name]
        self.step(element)
        if name not in self.events and name not in self.propositions and name not in (ACCEPTING, FORBIDDEN):
            fail(element, f"unknown event {name!r}{did_you_mean(name, [*self.events, *self._aliases][:1000])}")
        return (name,)

    def walk(self, group: Element) -> Iterator[tuple[Element, Bindings]]:
        """Yield the components in ``group``, loops unfolded, each with the values of the loops around it."""
        found: list[tuple[Element, Bindings]] = []

        def collect(item: Element, turn: Bindings, depth: int) -> None:
            if item.tag == "ComponentList":
                for child in item.children:
                    collect(child, turn, depth)
            elif not self.unfold(item, turn, depth, collect) and item.tag not in _LOOK:
                self.step(item)
                found.append((item, turn))

        collect(group, {}, 0)
        yield from found


_STATIC: Mapping[str, Callable[[int, int], int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: (abs(a) // abs(b)) * (1 if (a < 0) == (b < 0) else -1),  # towards zero, as Java does
    "%": lambda a, b: abs(a) % abs(b) * (-1 if a < 0 else 1),
    "<": lambda a, b: int(a < b),
    "<=": lambda a, b: int(a <= b),
    ">": lambda a, b: int(a > b),
    ">=": lambda a, b: int(a >= b),
    "&": lambda a, b: int(bool(a and b)),
    "|": lambda a, b: int(bool(a or b)),
}


def _wrong(element: Element, what: str) -> ModelError:
    return ModelError([Mistake(element.where, what)])


def whole(element: Element) -> int:
    """Return the number of an ``IntConstant``."""
    text = element.get("Value").strip()
    if not text.lstrip("-").isdecimal() or not text.isascii() or len(text) > 11 or abs(int(text)) > 2**31:
        fail(element, f"{text[:20]!r} is no number of 32 bits")
    return int(text)
