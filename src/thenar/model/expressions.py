"""Expressions over variables and automata states: what guards, updates and invariants are made of."""

from __future__ import annotations

import ast
import re
import unicodedata
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice, pairwise
from keyword import iskeyword
from typing import Any, TypeAlias

import numpy as np

from thenar.errors import InputError, Mistake, ModelError, did_you_mean

__all__ = [
    "FALSE",
    "TRUE",
    "At",
    "Constant",
    "Expression",
    "Name",
    "Operation",
    "Value",
    "conjunction",
    "evaluate",
    "is_writable",
    "leaves",
    "parse",
    "resolve",
    "shortened",
]

Value: TypeAlias = int | str
"""A whole number, True or False, or the literal of an enumeration."""


@dataclass(frozen=True, slots=True, eq=False)
class Constant:
    """A value that is written down.

    >>> Constant(True) == Constant(1), str(Constant(True)), str(Constant("dark red"))
    (False, 'true', "'dark red'")
    """

    value: Value

    def __eq__(self, other: object) -> bool:
        # to Python True is 1; to a model it is not
        return isinstance(other, Constant) and (type(self.value), self.value) == (type(other.value), other.value)

    def __hash__(self) -> int:
        return hash((type(self.value), self.value))

    def __str__(self) -> str:
        if isinstance(self.value, str):
            return self.value if is_writable(self.value) else repr(self.value)
        return str(self.value).lower()


@dataclass(frozen=True, slots=True)
class Name:
    """The value of the variable called ``name``; before :func:`resolve`, any name at all."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class At:
    """True while the automaton called ``automaton`` is in its state ``state``."""

    automaton: str
    state: str

    def __str__(self) -> str:
        automaton = self.automaton if is_writable(self.automaton) else repr(self.automaton)
        if automaton == self.automaton and "." not in self.state and is_writable(self.state):
            return f"{automaton}.{self.state}"
        return f"{automaton}[{self.state!r}]"


@dataclass(frozen=True, slots=True)
class Operation:
    """``operator`` applied to ``operands``.

    The operators are those of Python: ``and or`` (two operands or more), ``not``, ``== != < <= > >=``,
    ``+ - * // %``, ``neg`` (unary minus) and ``if`` (condition, value if it is true, value if not).
    """

    operator: str
    operands: tuple[Expression, ...]

    def __str__(self) -> str:
        inner = [_bracketed(x, self.operator, first=k == 0) for k, x in enumerate(self.operands)]
        if self.operator == "not":
            return f"not {inner[0]}"
        if self.operator == "neg":
            return f"-{inner[0]}"
        if self.operator == "if":
            return f"{inner[1]} if {inner[0]} else {inner[2]}"
        return f" {self.operator} ".join(inner)


Expression: TypeAlias = Constant | Name | At | Operation
TRUE, FALSE = Constant(True), Constant(False)

_STRENGTH = {"if": 0, "or": 1, "and": 2, "not": 3, "+": 5, "-": 5, "*": 6, "//": 6, "%": 6, "neg": 7}
_COMPARISON = 4
_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "not": np.logical_not,
    "==": np.equal,
    "!=": np.not_equal,
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "//": np.floor_divide,
    "%": np.remainder,
    "neg": np.negative,
    "if": lambda test, yes, no: np.asarray(np.where(test, yes, no))[()],  # [()]: a scalar, not an array without axes
}
_OPERATORS: Mapping[type, str] = {
    ast.And: "and",
    ast.Or: "or",
    ast.Not: "not",
    ast.USub: "neg",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.FloorDiv: "//",
    ast.Mod: "%",
}
_ONE_LINE = str.maketrans("\n\r", "  ")  # a long condition may be written on several lines
_ELSEWHERE = {  # how other languages write an operator, and how Python does
    r"(?<![=!<>])=(?!=)": "==",
    r"<>": "!=",
    r"&&?": "and",
    r"\|\|?": "or",
    r"!(?!=)|~": "not",
    r"(?<!/)/(?!/)": "//",
}
_LOOKS = 100_000  # at known names for the one nearest to an unknown one; about half a second
MAX_DEPTH = 200  # nested brackets and operators; Python's own parser gives up not far beyond


def parse(text: str | int | Expression) -> Expression:
    """Return the expression that ``text`` writes in Python's syntax; what is no text is returned as it is.

    Names may have dots; ``M1.idle`` and ``M1["idle"]`` say that automaton M1 is in its state idle, the second
    for any name of a state, ``"M 1"["idle"]`` for any name of an automaton.  A value of an enumeration that
    is no name stands in quotes.  ``true`` and ``false`` may be written small.  What a name means is found out
    by the problem that the expression becomes part of.

    Raises InputError with the place of what cannot be read.

    >>> print(parse("not (M1.idle and n + 1 < 3) or lamp == red"))
    not (M1.idle and n + 1 < 3) or lamp == red
    >>> parse("n = 3")
    Traceback (most recent call last):
    thenar.errors.InputError: expression 'n = 3', column 3: not understood; for '=' write '=='
    """
    if isinstance(text, int):
        return Constant(text)
    if not isinstance(text, str):
        return text
    line = text.translate(_ONE_LINE)
    body = line.lstrip()
    before = len(line) - len(body)
    if not body:
        raise InputError("an expression is empty; write 'true' for one that always holds")
    try:
        return _read(ast.parse(body.rstrip(), mode="eval").body, body, before, 0)
    except SyntaxError as error:
        raise _not_understood(line, before + (error.offset or 1), shortened(error.msg)) from None
    except (RecursionError, MemoryError, ValueError) as error:
        why = str(error) if isinstance(error, ValueError) else "nested too deep"
        raise InputError(f"expression {shortened(text)!r}: cannot be read, {why}") from None


def _read(node: ast.AST, text: str, before: int, depth: int) -> Expression:
    if depth > MAX_DEPTH:
        raise InputError(f"expression {shortened(text)!r}: nested deeper than {MAX_DEPTH}")

    def read(inner: ast.AST) -> Expression:
        return _read(inner, text, before, depth + 1)

    match node:
        case ast.Constant(value=bool() | int() | str() as value):
            return Constant(value)
        case ast.Name(id="true" | "false" as word):
            return Constant(word == "true")
        case ast.Name() | ast.Attribute() if (dotted := _dotted(node)) is not None:
            return Name(dotted)
        case ast.Subscript(value=ast.Constant(value=str() as automaton), slice=ast.Constant(value=str() | int() as q)):
            return At(automaton, str(q))
        case ast.Subscript(value=value, slice=ast.Constant(value=str() | int() as q)):
            if (name := _dotted(value)) is not None:
                return At(name, str(q))
        case ast.BoolOp(op=op, values=values):
            return Operation(_OPERATORS[type(op)], tuple(read(v) for v in values))
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = read(operand)
            negative = isinstance(inner, Constant) and type(inner.value) is int
            return Constant(-inner.value) if negative else Operation("neg", (inner,))  # type: ignore[union-attr,operator]
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return Operation("not", (read(operand),))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            return Operation(_OPERATORS[type(op)], (read(left), read(right)))
        case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in _OPERATORS for op in ops):
            sides = [read(side) for side in (left, *others)]
            parts = [Operation(_OPERATORS[type(op)], pair) for op, pair in zip(ops, pairwise(sides), strict=True)]
            return parts[0] if len(parts) == 1 else Operation("and", tuple(parts))
        case ast.IfExp(test=test, body=body, orelse=orelse):
            return Operation("if", (read(test), read(body), read(orelse)))
    # Python counts columns in bytes
    column = before + len(text.encode()[: getattr(node, "col_offset", 0)].decode(errors="replace")) + 1
    known = "and or not == != < <= > >= + - * // % if-else"
    raise _not_understood(
        " " * before + text, column, f"there are names, states, whole numbers and the operators {known}"
    )


def _not_understood(line: str, column: int, why: str) -> InputError:
    for pattern, operator in _ELSEWHERE.items():
        if match := re.search(pattern, line):
            column, why = match.start() + 1, f"for {match[0]!r} write {operator!r}"
            break
    return InputError(f"expression {shortened(line)!r}, column {column}: not understood; {why}")


def _dotted(node: ast.AST) -> str | None:
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        before = _dotted(node.value)
        return None if before is None else f"{before}.{node.attr}"
    return None


def is_writable(name: str) -> bool:
    """Return whether an expression can write ``name`` as it is, without quotes.

    >>> is_writable("CELL.n1"), is_writable("n 1"), is_writable("if"), is_writable("true")
    (True, False, False, False)
    """
    plain = unicodedata.normalize("NFKC", name) == name  # as Python reads names
    words = name.split(".")
    return plain and name not in ("true", "false") and all(w.isidentifier() and not iskeyword(w) for w in words)


def shortened(text: str) -> str:
    """Return ``text``, or its beginning if it is too long for a message."""
    return text if len(text) <= 60 else f"{text[:57]}..."


def leaves(expression: Expression) -> Iterator[Constant | Name | At]:
    """Yield the constants, names and states in ``expression``, from left to right, repetitions included."""
    if isinstance(expression, Operation):
        for operand in expression.operands:
            yield from leaves(operand)
    else:
        yield expression


def resolve(
    expression: Expression, variables: Mapping[str, Collection[Value]], automata: Mapping[str, Collection[str]]
) -> Expression:
    """Return ``expression`` with every name found out: a variable, a state ``AUTOMATON.STATE``, or a literal.

    ``variables`` gives the values of each variable, ``automata`` the states of each automaton.
    Raises ModelError naming all that is unknown.

    >>> resolve(parse("n > 0 and M1.idle"), {"n": range(3)}, {"M1": ["idle"]}).operands[1]
    At(automaton='M1', state='idle')
    """
    unknown: list[str] = []
    literals = {v for values in variables.values() for v in values if isinstance(v, str)}

    def found(leaf: Constant | Name | At) -> Expression:
        if isinstance(leaf, Name) and leaf.name not in variables:
            automaton, _, state = leaf.name.rpartition(".")
            if automaton in automata:
                return found(At(automaton, state))
            if leaf.name in literals:
                return Constant(leaf.name)
            states = (f"{a}.{s}" for a in automata for s in automata[a])
            hint = did_you_mean(leaf.name, [*variables, *sorted(literals), *islice(states, _LOOKS)])
            unknown.append(f"{leaf.name!r} is no variable, no state of an automaton and no value{hint}")
        elif isinstance(leaf, At) and leaf.automaton not in automata:
            hint = did_you_mean(leaf.automaton, automata)
            unknown.append(f"unknown automaton {leaf.automaton!r}{hint}")
        elif isinstance(leaf, At) and leaf.state not in automata[leaf.automaton]:
            hint = did_you_mean(leaf.state, islice(automata[leaf.automaton], _LOOKS))
            unknown.append(f"automaton {leaf.automaton!r} has no state {leaf.state!r}{hint}")
        elif isinstance(leaf, Constant) and isinstance(leaf.value, str) and leaf.value not in literals:
            unknown.append(f"{leaf.value!r} is a value of no variable{did_you_mean(leaf.value, sorted(literals))}")
        return leaf

    def rebuild(inner: Expression) -> Expression:
        if isinstance(inner, Operation):
            return Operation(inner.operator, tuple(rebuild(x) for x in inner.operands))
        return found(inner)

    result = rebuild(expression)
    if unknown:
        raise ModelError([Mistake("", what) for what in dict.fromkeys(unknown)])
    return result


def evaluate(expression: Expression, value: Callable[[Constant | Name | At], Any]) -> Any:
    """Return the value of ``expression`` where ``value`` gives that of each leaf: scalars, or arrays of one shape.

    Who gives numbers for the literals of enumerations numbers them alike in all variables, as they are compared.

    >>> print(evaluate(parse("x + 1 < 3"), lambda leaf: leaf.value if isinstance(leaf, Constant) else np.arange(4)))
    [ True  True False False]
    """
    if not isinstance(expression, Operation):
        return value(expression)
    operands = [evaluate(x, value) for x in expression.operands]
    if expression.operator in ("and", "or"):
        join = np.logical_and if expression.operator == "and" else np.logical_or
        result = operands[0]
        for other in operands[1:]:
            result = join(result, other)
        return result
    return _FUNCTIONS[expression.operator](*operands)


def conjunction(parts: Iterable[Expression]) -> Expression:
    """Return the expression that is true where all of ``parts`` are.

    >>> print(conjunction([parse("a and b"), TRUE, parse("c or d")]))
    a and b and (c or d)
    """
    kept: list[Expression] = []
    for part in parts:
        kept += part.operands if isinstance(part, Operation) and part.operator == "and" else [part]
    kept = [part for part in kept if part != TRUE]
    return TRUE if not kept else kept[0] if len(kept) == 1 else Operation("and", tuple(kept))


def _strength(expression: Expression) -> int:
    if not isinstance(expression, Operation):
        return 9
    return _STRENGTH.get(expression.operator, _COMPARISON)


def _bracketed(operand: Expression, outer: str, *, first: bool) -> str:
    """Write ``operand`` so that it stays one operand of ``outer``."""
    mine, theirs = _strength(operand), _STRENGTH.get(outer, _COMPARISON)
    # a - b - c is (a - b) - c; but a < b < c would be two comparisons, and a and b and c one operation
    groups_left = first and outer in ("+", "-", "*", "//", "%")
    loose = mine < theirs or (mine == theirs and outer != "not" and not groups_left)
    return f"({operand})" if loose else str(operand)
