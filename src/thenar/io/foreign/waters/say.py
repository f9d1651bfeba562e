"""Expressions of thenar in the words of Waters: without ``if``, division rounded towards zero, truths as 0 and 1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

from thenar.errors import InputError
from thenar.io.foreign.labels import quoted
from thenar.model.expressions import FALSE, TRUE, At, Constant, Expression, Name, Operation, Value, shortened

__all__ = ["Sayer", "binary", "number", "simple"]

MAX_CASES = 256  # what the ifs of one expression are taken apart to
_LIMIT = 2**31  # Waters' numbers have 32 bits


def simple(name: str) -> str:
    """Return the element of a name."""
    return f"<SimpleIdentifier Name={quoted(name)}/>"


def number(n: int) -> str:
    """Return the element of a number."""
    if not -_LIMIT <= n < _LIMIT:
        raise InputError(f"the number {n} does not fit into the 32 bits of Waters' numbers")
    return f'<IntConstant Value="{n}"/>'


def binary(operator: str, *sides: str) -> str:
    """Return the element of ``operator`` on two sides, or more of ``&`` and ``|``: a balanced tree, not a deep one."""
    if len(sides) == 1:
        return sides[0]
    half = len(sides) // 2
    pair = sides if len(sides) == 2 else (binary(operator, *sides[:half]), binary(operator, *sides[half:]))
    return f"<BinaryExpression Operator={quoted(operator)}>{pair[0]}{pair[1]}</BinaryExpression>"


def unary(operator: str, inner: str) -> str:
    return f"<UnaryExpression Operator={quoted(operator)}>{inner}</UnaryExpression>"


class Sayer:
    """Writes expressions over variables with the values ``domains``; ``names`` is what the file calls variables.

    ``asked_where`` becomes true if an expression asks for the state of an automaton.
    """

    def __init__(self, domains: Mapping[str, Sequence[Value]], names: Mapping[str, str]) -> None:
        self.domains, self.names = domains, names
        self.asked_where = False

    # -- truths ----------------------------------------------------------------------------------------------

    def truth(self, expression: Expression) -> str:
        """Return the element of a condition."""
        match expression:
            case Constant(value=value):
                return number(int(value))
            case Name(name=name):
                return binary("==", simple(self.names[name]), number(1))
            case At(automaton=automaton, state=state):
                self.asked_where = True
                return binary("==", simple(automaton), simple(state))
            case Operation(operator="and" | "or" as operator, operands=operands):
                return binary("&" if operator == "and" else "|", *map(self.truth, operands))
            case Operation(operator="not", operands=(inner,)):
                return unary("!", self.truth(inner))
            case Operation(operator="if", operands=(test, yes, no)):
                return self.truth(_choice(test, yes, no))
            case Operation(operator=operator, operands=operands):
                found = [self._compared(operator, conditions, sides) for conditions, sides in self._apart(operands)]
                return binary("|", *found)
        raise AssertionError(expression)

    def _compared(self, operator: str, conditions: Sequence[Expression], sides: Sequence[Expression]) -> str:
        if self._is_truth(sides[0]):
            both = self._equal_truths(*sides)
            said = both if operator == "==" else unary("!", both)
        else:
            said = binary(operator, *(self.value(side) for side in sides))
        return binary("&", *map(self.truth, conditions), said)

    def _equal_truths(self, x: Expression, y: Expression) -> str:
        for one, other in ((x, y), (y, x)):
            if one in (TRUE, FALSE):
                return self.truth(other) if one == TRUE else unary("!", self.truth(other))
        if isinstance(x, Name) and isinstance(y, Name):
            return binary("==", simple(self.names[x.name]), simple(self.names[y.name]))
        a, b = self.truth(x), self.truth(y)
        return binary("|", binary("&", a, b), binary("&", unary("!", a), unary("!", b)))

    def _is_truth(self, expression: Expression) -> bool:
        match expression:
            case Constant(value=value):
                return isinstance(value, bool)
            case Name(name=name):
                return isinstance(self.domains[name][0], bool)
            case Operation(operator="if", operands=(_, yes, _)):
                return self._is_truth(yes)
            case Operation(operator=operator):
                return operator not in ("+", "-", "*", "//", "%", "neg")
        return True

    # -- ifs -------------------------------------------------------------------------------------------------

    def cases(self, expression: Expression) -> list[tuple[tuple[Expression, ...], Expression]]:
        """Return the conditions under which ``expression`` has which value; these have no ``if``, save in truths."""
        if self._is_truth(expression) or not isinstance(expression, Operation):
            return [((), expression)]
        if expression.operator == "if":
            test, yes, no = expression.operands
            found = [((test, *c), x) for c, x in self.cases(yes)]
            found += [((Operation("not", (test,)), *c), x) for c, x in self.cases(no)]
        else:
            apart = self._apart(expression.operands)
            found = [(conditions, Operation(expression.operator, tuple(sides))) for conditions, sides in apart]
        return self._bounded(found, expression)

    def _apart(self, operands: Sequence[Expression]) -> list[tuple[tuple[Expression, ...], tuple[Expression, ...]]]:
        each = [self.cases(x) for x in operands]
        if len(each[0]) * len(each[-1]) > MAX_CASES:
            self._bounded(each[0] * len(each[-1]), operands[0])
        return [(tuple(c for cs, _ in pick for c in cs), tuple(x for _, x in pick)) for pick in product(*each)]

    def _bounded(
        self, found: list[tuple[tuple[Expression, ...], Expression]], expression: Expression
    ) -> list[tuple[tuple[Expression, ...], Expression]]:
        if len(found) > MAX_CASES:
            what = f"the expression {shortened(str(expression))!r} has more than {MAX_CASES} cases"
            raise InputError(f"{what}; a .wmod file has no 'if' in expressions, write guards instead")
        return found

    # -- values ----------------------------------------------------------------------------------------------

    def value(self, expression: Expression) -> str:
        """Return the element of a value without ``if``."""
        if self._is_truth(expression):
            return simple(self.names[expression.name]) if isinstance(expression, Name) else self.truth(expression)
        if isinstance(expression, Constant) and isinstance(expression.value, str):
            return simple(expression.value)
        if isinstance(expression, Name):
            return simple(self.names[expression.name])
        return self._number(expression)[0]

    def _number(self, expression: Expression) -> tuple[str, int, int]:
        """Return the element of a number, and between which numbers it lies."""
        match expression:
            case Constant(value=value):
                return number(int(value)), int(value), int(value)
            case Name(name=name):
                values = [int(v) for v in self.domains[name]]
                return simple(self.names[name]), min(values), max(values)
            case Operation(operator="neg", operands=(inner,)):
                said, low, high = self._number(inner)
                return self._checked(unary("-", said), [-high, -low])
            case Operation(operator="//" | "%" as operator, operands=(x, Constant(value=divisor))):
                return self._divided(operator, x, int(divisor))
            case Operation(operator=operator, operands=operands):
                (x_said, a, b), (y_said, c, d) = (self._number(x) for x in operands)
                ends = {"+": [a + c, b + d], "-": [a - d, b - c], "*": [p * q for p in (a, b) for q in (c, d)]}
                return self._checked(binary(operator, x_said, y_said), ends[operator])
        raise AssertionError(expression)

    def _divided(self, operator: str, x: Expression, divisor: int) -> tuple[str, int, int]:
        """Round down as thenar does; Waters rounds towards zero, so a multiple of the divisor is added before."""
        if divisor < 0:
            said, low, high = self._divided(operator, Operation("neg", (x,)), -divisor)
            return (said, low, high) if operator == "//" else self._checked(unary("-", said), [-high, -low])
        said, low, high = self._number(x)
        turns = max(0, -(low // divisor))
        if turns:
            said, low, high = self._checked(binary("+", said, number(turns * divisor)), [low, high], turns * divisor)
        if operator == "%":
            return binary("%", said, number(divisor)), 0, min(high, divisor - 1)
        said = binary("/", said, number(divisor))
        return self._checked(
            binary("-", said, number(turns)) if turns else said, [low // divisor, high // divisor], -turns
        )

    def _checked(self, said: str, ends: Sequence[int], shift: int = 0) -> tuple[str, int, int]:
        low, high = min(ends) + shift, max(ends) + shift
        if low < -_LIMIT or high >= _LIMIT:
            raise InputError(f"a result between {low} and {high} does not fit into the 32 bits of Waters' numbers")
        return said, low, high


def _choice(test: Expression, yes: Expression, no: Expression) -> Expression:
    """Return the truth ``yes if test else no`` in other words."""
    return Operation("or", (Operation("and", (test, yes)), Operation("and", (Operation("not", (test,)), no))))
