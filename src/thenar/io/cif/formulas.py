"""Expressions as CIF writes them, and the ranges of their values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product

from thenar.model.expressions import TRUE, At, Constant, Expression, Name, Operation, Value, conjunction

__all__ = ["Formulas", "inside", "span"]

_WORDS = {"==": "=", "!=": "!="}
_STRENGTH = {"or": 1, "and": 2, "==": 4, "!=": 4, "<": 4, "<=": 4, ">": 4, ">=": 4, "+": 5, "-": 5, "*": 6}
_ATOM = 9
Domains = Mapping[str, Sequence[Value]]


class Formulas:
    """Writes expressions: ``variables``, states (``at``) and ``literals`` are what CIF calls them.

    >>> from thenar.model.expressions import parse
    >>> say = Formulas({"n": "CUP.n"}, lambda automaton, state: f"{automaton}.{state}", {}, {"n": range(-3, 4)})
    >>> print(say(parse("not n == 3 and n - 1 < 2 * n")), "|", say(Operation("//", (Name("n"), Constant(2)))))
    not (CUP.n = 3) and CUP.n - 1 < 2 * CUP.n | if CUP.n >= 0: CUP.n div 2 else -((-CUP.n + 1) div 2) end
    """

    def __init__(
        self,
        variables: Mapping[str, str],
        at: Callable[[str, str], str],
        literals: Mapping[Value, str],
        values: Domains,
    ) -> None:
        self.variables, self.at, self.literals, self.values = variables, at, literals, values

    def __call__(self, expression: Expression) -> str:
        """Return the text of ``expression``."""
        return self._written(expression)[0]

    def _written(self, x: Expression) -> tuple[str, int]:
        """Return the text, and how strongly it holds together."""
        if isinstance(x, Constant):
            if isinstance(x.value, str):
                return self.literals[x.value], _ATOM
            return str(x.value).lower(), _ATOM if isinstance(x.value, bool) or x.value >= 0 else 7
        if isinstance(x, Name):
            return self.variables[x.name], _ATOM
        if isinstance(x, At):
            return self.at(x.automaton, x.state), _ATOM
        if x.operator in ("//", "%"):
            return self._divided(x)
        if x.operator == "if":
            test, yes, no = map(self, x.operands)
            return f"if {test}: {yes} else {no} end", _ATOM
        if x.operator in ("not", "neg"):
            return f"{'not ' if x.operator == 'not' else '-'}{self._held(x.operands[0], _ATOM)}", 7
        mine = _STRENGTH[x.operator]
        grouped = x.operator in ("+", "-", "*")  # a - b - c is (a - b) - c
        parts = [self._held(y, mine + (k > 0 or not grouped)) for k, y in enumerate(x.operands)]
        return f" {_WORDS.get(x.operator, x.operator)} ".join(parts), mine

    def _held(self, x: Expression, strength: int) -> str:
        """Return the text, in brackets if it would fall apart among stronger operators."""
        text, mine = self._written(x)
        return text if mine >= strength else f"({text})"

    def _divided(self, x: Operation) -> tuple[str, int]:
        """Write a quotient that is rounded down, or the rest of it; CIF rounds towards zero."""
        over, divisor = x.operands
        by = divisor.value if isinstance(divisor, Constant) else 0
        assert isinstance(by, int)  # a problem divides by numbers other than 0 only
        if by < 0:  # a // b = -a // -b,  a % b = -(-a % -b)
            turned = Operation(x.operator, (Operation("neg", (over,)), Constant(-by)))
            return self._written(turned if x.operator == "//" else Operation("neg", (turned,)))
        low, _ = span(over, self.values)
        text = self._held(over, _ATOM)
        if low >= 0:
            return f"{text} {'div' if x.operator == '//' else 'mod'} {by}", 6
        down = f"-((-{text} + {by - 1}) div {by})"
        if x.operator == "//":
            return f"if {text} >= 0: {text} div {by} else {down} end", _ATOM
        return f"if {text} >= 0: {text} mod {by} else {text} + {by} * ((-{text} + {by - 1}) div {by}) end", _ATOM


def span(x: Expression, values: Domains) -> tuple[int, int]:
    """Return bounds of the whole number ``x``; of what is none, (0, 1).

    >>> from thenar.model.expressions import parse
    >>> span(parse("n * n - 1"), {"n": range(-2, 4)})
    (-7, 8)
    """
    if isinstance(x, Constant):
        return (x.value, x.value) if not isinstance(x.value, bool | str) else (0, 1)
    if isinstance(x, Name):
        numbers = [v for v in values[x.name] if not isinstance(v, str)]
        return (min(numbers), max(numbers)) if numbers else (0, 1)
    if isinstance(x, At) or x.operator not in ("+", "-", "*", "neg", "//", "%", "if"):
        return 0, 1
    bounds = [span(y, values) for y in x.operands]
    if x.operator == "neg":
        return -bounds[0][1], -bounds[0][0]
    if x.operator == "if":
        return min(bounds[1][0], bounds[2][0]), max(bounds[1][1], bounds[2][1])
    low, high = bounds[0]
    for other in bounds[1:]:
        low, high = _combined(x.operator, (low, high), other)
    return low, high


def _combined(operator: str, a: tuple[int, int], b: tuple[int, int]) -> tuple[int, int]:
    if operator == "+":
        return a[0] + b[0], a[1] + b[1]
    if operator == "-":
        return a[0] - b[1], a[1] - b[0]
    if operator == "*":
        corners = [p * q for p, q in product(a, b)]
        return min(corners), max(corners)
    most = max(abs(a[0]), abs(a[1])) + 1 if operator == "//" else max(abs(b[0]), abs(b[1]))
    return (0 if a[0] >= 0 and b[0] >= 0 else -most), most


def inside(x: Expression, domain: Sequence[Value], values: Domains) -> Expression:
    """Return the condition that the new value ``x`` is in ``domain``, or between its smallest and largest number.

    >>> from thenar.model.expressions import parse
    >>> print(inside(parse("n + 1"), range(4), {"n": range(4)}), inside(parse("0"), range(4), {}))
    n + 1 <= 3 true
    """
    if isinstance(domain[0], str):
        if _literals(x, values) <= set(domain):
            return TRUE
        return _either([Operation("==", (x, Constant(v))) for v in domain])
    if isinstance(domain[0], bool):
        return TRUE
    numbers = [v for v in domain if not isinstance(v, str)]
    low, high = span(x, values)
    tests = [Operation(">=", (x, Constant(min(numbers))))] if low < min(numbers) else []
    tests += [Operation("<=", (x, Constant(max(numbers))))] if high > max(numbers) else []
    return conjunction(tests)


def _literals(x: Expression, values: Domains) -> set[Value]:
    """Return the literals that ``x``, a value of an enumeration, may be."""
    if isinstance(x, Constant):
        return {x.value}
    if isinstance(x, Name):
        return set(values[x.name])
    assert isinstance(x, Operation)  # an if: there is no other operation with literals as its result
    return _literals(x.operands[1], values) | _literals(x.operands[2], values)


def _either(tests: list[Expression]) -> Expression:
    return tests[0] if len(tests) == 1 else Operation("or", tuple(tests))
