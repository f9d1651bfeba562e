"""Terms: expressions with their types, folded where they are constant, and bounded in size."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from thenar.model.expressions import FALSE, TRUE, At, Constant, Expression, Name, Operation, Value

__all__ = ["BOOL", "Range", "Term", "TermError", "Type", "Words", "apply", "both", "choose", "either", "negate"]

MAX_DEPTH = 150  # operations in operations: what walks through an expression later may be recursive
MAX_SIZE = 50_000  # names and operations in one expression: an equation used twice by another, which ..., doubles it
MAX_NUMBER = 2**31  # CIF's numbers are below


@dataclass(frozen=True, slots=True)
class Truth:
    """False or true."""

    def __str__(self) -> str:
        return "bool"


@dataclass(frozen=True, slots=True)
class Range:
    """The whole numbers from ``low`` to ``high``."""

    low: int
    high: int

    def __str__(self) -> str:
        return f"int[{self.low}..{self.high}]"


@dataclass(frozen=True, slots=True)
class Words:
    """The literals of the enumeration called ``name``."""

    name: str = field(compare=False)  # CIF: enumerations with the same literals are compatible
    literals: tuple[str, ...]

    def __str__(self) -> str:
        return self.name


Type: TypeAlias = Truth | Range | Words
BOOL = Truth()


class TermError(Exception):
    """A term that makes no sense; whoever knows its place says it."""


@dataclass(frozen=True, slots=True)
class Term:
    """An expression and the type of its value."""

    expression: Expression
    type: Type
    size: int = 1
    depth: int = 0

    @property
    def constant(self) -> bool:
        """Is it a value that is written down?"""
        return isinstance(self.expression, Constant)

    @property
    def never(self) -> bool:
        """Is it false everywhere?"""
        return self.expression == FALSE


def value_of(term: Term) -> Value:
    """Return the value of a constant term."""
    if not isinstance(term.expression, Constant):
        raise TermError("a value that is known from the text is asked for here")
    return term.expression.value


def number(value: int) -> Term:
    """Return the term of a number."""
    if abs(value) > MAX_NUMBER:
        raise TermError(f"the number {value} is too large; CIF's numbers have 32 bits")
    return Term(Constant(value), Range(value, value))


def truth(value: bool) -> Term:
    """Return the term of a truth."""
    return Term(TRUE if value else FALSE, BOOL)


def word(literal: str, type: Words) -> Term:
    """Return the term of a literal of an enumeration."""
    return Term(Constant(literal), type)


def at(automaton: str, state: str) -> Term:
    """Return the term that is true while ``automaton`` is in ``state``."""
    return Term(At(automaton, state), BOOL)


def variable(name: str, type: Type) -> Term:
    """Return the term of a variable."""
    return Term(Name(name), type)


# -- truths --------------------------------------------------------------------------------------------------


def both(*terms: Term) -> Term:
    """Return the term that is true where all ``terms`` are."""
    return _joined("and", terms, TRUE, FALSE)


def either(*terms: Term) -> Term:
    """Return the term that is true where one of ``terms`` is."""
    return _joined("or", terms, FALSE, TRUE)


def _joined(operator: str, terms: Sequence[Term], neutral: Constant, zero: Constant) -> Term:
    parts: list[Expression] = []
    kept: list[Term] = []
    for term in terms:
        _expect(BOOL, term)
        if term.expression == zero:
            return Term(zero, BOOL)
        if term.expression == neutral:
            continue
        kept.append(term)
        inner = term.expression
        parts += inner.operands if isinstance(inner, Operation) and inner.operator == operator else (inner,)
    if not kept:
        return Term(neutral, BOOL)
    return kept[0] if len(kept) == 1 else _operation(operator, parts, BOOL, kept)


def negate(term: Term) -> Term:
    """Return the term that is true where ``term`` is not."""
    _expect(BOOL, term)
    if isinstance(term.expression, Constant):
        return truth(not term.expression.value)
    if isinstance(term.expression, Operation) and term.expression.operator == "not":
        return Term(term.expression.operands[0], BOOL, term.size - 1, term.depth)
    return _operation("not", [term.expression], BOOL, [term])


# -- values --------------------------------------------------------------------------------------------------


def choose(cases: Sequence[tuple[Term, Term]], otherwise: Term) -> Term:
    """Return the value of the first of ``cases`` (condition, value) whose condition is true, else ``otherwise``."""
    result = otherwise
    for condition, value in reversed(cases):
        _expect(BOOL, condition)
        kind = hull(value.type, result.type)
        if isinstance(condition.expression, Constant):
            result = value if condition.expression.value else result
        elif value.expression != result.expression:
            if kind == BOOL and value.constant:
                result = either(condition, result) if value.expression == TRUE else both(negate(condition), result)
            elif kind == BOOL and result.constant:
                result = both(condition, value) if result.expression == FALSE else either(negate(condition), value)
            else:
                parts = [condition, value, result]
                result = _operation("if", [p.expression for p in parts], kind, parts)
        else:
            result = Term(result.expression, kind, result.size, result.depth)
    return result


def select(cases: Sequence[tuple[Term, Term]]) -> Term:
    """Return the value of that of ``cases`` whose condition is true: always exactly one of them is."""
    groups: dict[Expression, list[tuple[Term, Term]]] = {}
    for condition, value in cases:
        groups.setdefault(value.expression, []).append((condition, value))
    merged = [(either(*(c for c, _ in group)), group[0][1]) for group in groups.values()]
    if len(merged) > 2:  # a balanced tree: many locations do not nest deep
        half = len(merged) // 2
        first, second = select(merged[:half]), select(merged[half:])
        return choose([(either(*(c for c, _ in merged[:half])), first)], second)
    return choose(merged[:-1], merged[-1][1])


def apply(operator: str, *terms: Term) -> Term:
    """Return ``operator``, one of CIF's, applied to ``terms``."""
    match operator:
        case "and":
            return both(*terms)
        case "or":
            return either(*terms)
        case "=>":
            return either(negate(terms[0]), terms[1])
        case "<=>":
            for term in terms:
                _expect(BOOL, term)
            return _compared("==", *terms)
        case "=" | "!=":
            hull(terms[0].type, terms[1].type)
            return _compared("==" if operator == "=" else "!=", *terms)
        case "<" | "<=" | ">" | ">=":
            for term in terms:
                _range(term)
            return _compared(operator, *terms)
        case "div" | "mod":
            return _divided(operator, *terms)
        case "abs":
            (x,) = terms
            return choose([(apply("<", x, number(0)), apply("neg", x))], x) if _range(x).low < 0 else x
        case "sign":
            (x,) = terms
            _range(x)
            return choose([(apply("<", x, number(0)), number(-1)), (apply("=", x, number(0)), number(0))], number(1))
        case "min" | "max":
            x, y = terms
            result = choose([(apply("<=" if operator == "min" else ">=", x, y), x)], y)
            pick, a, b = (min if operator == "min" else max), _range(x), _range(y)
            return Term(result.expression, Range(pick(a.low, b.low), pick(a.high, b.high)), result.size, result.depth)
    if len(terms) > 2:  # a long sum, as a balanced tree
        half = len(terms) // 2
        terms = (_sum(terms[:half]), _sum(terms[half:]))
    ranges = [_range(term) for term in terms]
    return _computed(operator, terms, _bounds(operator, ranges))


def _sum(terms: Sequence[Term]) -> Term:
    return terms[0] if len(terms) == 1 else apply("+", *terms)


def _bounds(operator: str, ranges: Sequence[Range]) -> Range:
    if operator == "neg":
        return Range(-ranges[0].high, -ranges[0].low)
    corners = [_ARITHMETIC[operator](a, b) for a in _ends(ranges[0]) for b in _ends(ranges[1])]
    return Range(min(corners), max(corners))


def _divided(operator: str, x: Term, y: Term) -> Term:
    """Round towards zero, as CIF does; ``//`` and ``%`` round down, so a negative sign is taken out first."""
    a, b = _range(x), _range(y)
    if not y.constant or b.low == 0:
        raise TermError(f"{operator} by {y.expression}; thenar divides by numbers other than 0 that the text gives")
    if b.low < 0:
        positive = _divided(operator, x, number(-b.low))
        return apply("neg", positive) if operator == "div" else positive
    n, symbol = b.low, "//" if operator == "div" else "%"

    def divided(dividend: Term, most: int) -> Term:
        """Return the term for a dividend from 0 to ``most``, at least where it is looked at."""
        return _computed(symbol, [dividend, y], Range(0, most // n if operator == "div" else min(most, n - 1)))

    if a.low >= 0:
        return divided(x, a.high)
    negative = apply("neg", divided(apply("neg", x), -a.low))
    if a.high <= 0:
        return negative
    return choose([(apply(">=", x, number(0)), divided(x, a.high))], negative)


def _compared(operator: str, x: Term, y: Term) -> Term:
    for one, other in ((x, y), (y, x)):
        if isinstance(one.type, Words) and isinstance(one.expression, Operation):
            # into the branches of an if: what is left compares a variable of the enumeration, or is known
            condition, *values = (Term(part, one.type, one.size - 2, one.depth - 1) for part in one.expression.operands)
            condition = Term(condition.expression, BOOL, condition.size, condition.depth)
            yes, no = (_compared(operator, value, other) for value in values)
            return choose([(condition, yes)], no)
    if isinstance(x.expression, Constant) and isinstance(y.expression, Constant):
        return truth(_COMPARE[operator](x.expression.value, y.expression.value))
    return _operation(operator, [x.expression, y.expression], BOOL, [x, y])


def _computed(operator: str, terms: Sequence[Term], bounds: Range) -> Term:
    if max(abs(bounds.low), abs(bounds.high)) > MAX_NUMBER:
        raise TermError(f"a result between {bounds.low} and {bounds.high}; CIF's numbers have 32 bits")
    values = [t.expression.value for t in terms if isinstance(t.expression, Constant)]
    if len(values) == len(terms):
        return number(_ARITHMETIC[operator](*values))
    return _operation(operator, [t.expression for t in terms], bounds, terms)


_ARITHMETIC: dict[str, Callable[..., int]] = {
    "neg": lambda x: -x,
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "//": lambda x, y: x // y,
    "%": lambda x, y: x % y,
}
_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "==": lambda x, y: x == y,
    "!=": lambda x, y: x != y,
    "<": lambda x, y: x < y,
    "<=": lambda x, y: x <= y,
    ">": lambda x, y: x > y,
    ">=": lambda x, y: x >= y,
}


def _operation(operator: str, parts: Sequence[Expression], type: Type, terms: Sequence[Term]) -> Term:
    size, depth = 1 + sum(t.size for t in terms), 1 + max(t.depth for t in terms)
    if size > MAX_SIZE or depth > MAX_DEPTH:
        limit = f"{MAX_SIZE:,} operations" if size > MAX_SIZE else f"{MAX_DEPTH} operations in one another"
        raise TermError(f"an expression of more than {limit}, its algebraic variables written out")
    return Term(Operation(operator, tuple(parts)), type, size, depth)


def _ends(bounds: Range) -> tuple[int, int]:
    return bounds.low, bounds.high


def _range(term: Term) -> Range:
    if not isinstance(term.type, Range):
        raise TermError(f"a number is asked for here, and this is of type {term.type}")
    return term.type


def _expect(type: Type, term: Term) -> None:
    if term.type != type:
        raise TermError(f"a {type} is asked for here, and this is of type {term.type}")


def hull(first: Type, second: Type) -> Type:
    if isinstance(first, Range) and isinstance(second, Range):
        return Range(min(first.low, second.low), max(first.high, second.high))
    if first != second:
        raise TermError(f"a value of type {first} and one of type {second}; they cannot be equal or take turns")
    return first
