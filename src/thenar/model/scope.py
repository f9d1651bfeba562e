"""What names mean in one problem, and which expressions make sense there: those whose evaluation cannot fail."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, TypeAlias

from thenar.errors import InputError, Mistake, ModelError, did_you_mean
from thenar.model.events import Alphabet
from thenar.model.expressions import (
    TRUE,
    At,
    Constant,
    Expression,
    Name,
    Operation,
    Value,
    is_writable,
    leaves,
    parse,
    resolve,
    shortened,
)

if TYPE_CHECKING:
    from thenar.model.extended import Condition, ExtendedAutomaton
    from thenar.model.variables import Variable

__all__ = ["Kind", "Scope", "about_specs", "name_clashes", "owner", "written_twice"]

Kind: TypeAlias = Literal["truth"] | tuple[int, int] | frozenset[str]
"""What an expression can be: a truth, a number (lowest, highest), or one of the literals of an enumeration."""

_WORD = 2**63  # numbers are evaluated in 64 bits
_OPERANDS = {"not": 1, "neg": 1, "if": 3, "and": None, "or": None}  # None: two or more; else two
_ORDER = ("<", "<=", ">", ">=")
_ARITHMETIC = ("+", "-", "*", "//", "%")


class Scope:
    """The variables and automata of a problem, by name; collects in ``mistakes`` what is wrong with expressions.

    ``values`` gives the values of each variable, ``states`` the states of each automaton.

    >>> scope = Scope({"n": (0, 1, 2), "lamp": ("red", "green")}, {"M1": ["idle", "busy"]})
    >>> from thenar.model.expressions import parse
    >>> print(scope.truth(parse("M1.idle and n + 1 < 3"), "here", "a guard"))
    M1.idle and n + 1 < 3
    >>> _ = scope.truth(parse("lamp == n or n // n > 0"), "here", "a guard")
    >>> print(*scope.mistakes, sep="\\n")
    here: in 'lamp == n': 'lamp' is green or red, 'n' is a number; they cannot be compared
    here: in 'n // n': the divisor must be written as a number other than 0
    """

    def __init__(self, values: Mapping[str, tuple[Value, ...]], states: Mapping[str, Collection[str]]) -> None:
        self.values, self.states = values, states
        self.mistakes: list[Mistake] = []
        self._kinds = {name: _kind_of(domain) for name, domain in values.items()}
        self._enumerations = {kind for kind in self._kinds.values() if isinstance(kind, frozenset)}

    def automaton(self, automaton: ExtendedAutomaton) -> ExtendedAutomaton:
        """Return ``automaton`` with all guards and updates resolved."""
        if all(e.guard == TRUE and not e.updates for e in automaton.edges):
            return automaton
        edges = []
        for k, edge in enumerate(automaton.edges):
            place = f"{owner(automaton.name)}, {automaton.place(k)}"
            new = tuple((v, self.new_value(v, x, place)) for v, x in edge.updates)
            edges.append(replace(edge, guard=self.truth(edge.guard, place, "a guard"), updates=new))
        return replace(automaton, edges=tuple(edges))

    def condition(self, condition: Condition, alphabet: Alphabet) -> Condition:
        """Return ``condition`` resolved; its event has to be in ``alphabet``."""
        where = _place(condition)
        if condition.event is not None and condition.event not in alphabet:
            self._note(where, f"unknown event {condition.event!r}{did_you_mean(str(condition.event), alphabet.names)}")
        return replace(condition, predicate=self.truth(condition.predicate, where, "a condition"))

    def truth(self, expression: str | int | Expression, where: str, what: str) -> Expression:
        """Return ``expression`` with its names resolved; note a mistake unless it is true or false wherever it stands.

        ``what`` says what it is for: "a guard", "a condition".
        """
        result, kind = self._read(expression, where)
        if kind not in (None, "truth"):
            self._note(where, f"{what} is true or false, but {_quoted(result)} is {_say(kind)}")
        return result

    def new_value(self, variable: str, expression: str | int | Expression, where: str) -> Expression:
        """Return ``expression`` with its names resolved; note a mistake unless ``variable`` can be updated with it.

        A number may still be out of the variable's range; then the update is not possible.
        """
        result, kind = self._read(expression, where)
        if variable not in self.values:
            self._note(where, f"updates {variable!r}, which is no variable{did_you_mean(variable, self.values)}")
        elif kind is not None:
            own = self._kinds[variable]
            fits = self._comparable(own, kind)
            if isinstance(own, frozenset) and isinstance(kind, frozenset):
                fits = fits and not own.isdisjoint(kind)
            if not fits:
                self._note(where, f"{variable!r} is {_say(own)}, but its new value {_quoted(result)} is {_say(kind)}")
        return result

    def _read(self, expression: str | int | Expression, where: str) -> tuple[Expression, Kind | None]:
        try:
            result = resolve(parse(expression), self.values, self.states)
            wrong: list[str] = []
            kind = self._kind(result, wrong)
        except ModelError as error:
            self.mistakes += [Mistake(where, m.what) for m in error.mistakes]
            return TRUE, None
        except InputError as error:
            self._note(where, str(error))
            return TRUE, None
        except RecursionError:
            self._note(where, "an expression is nested too deep")
            return TRUE, None
        for what in dict.fromkeys(wrong):
            self._note(where, what)
        return result, None if wrong else kind

    def _note(self, where: str, what: str) -> None:
        self.mistakes.append(Mistake(where, what))

    # -- kinds ---------------------------------------------------------------------------------------------

    def _kind(self, expression: Expression, wrong: list[str]) -> Kind | None:
        """Return what a resolved ``expression`` can be, None where a part of it in ``wrong`` makes that unclear."""
        match expression:
            case Constant(value=bool()) | At():
                return "truth"
            case Constant(value=int() as n):
                return _number([n], expression, wrong)
            case Constant(value=str() as literal):
                return frozenset([literal])
            case Name(name=name):
                return self._kinds[name]
            case Operation(operator=operator, operands=operands):
                kinds = [self._kind(x, wrong) for x in operands]
                return self._operation(operator, operands, kinds, expression, wrong)
        wrong.append(f"{_quoted(expression)} is no expression; write a text, or use parse")
        return None

    def _operation(
        self,
        operator: str,
        operands: Sequence[Expression],
        kinds: Sequence[Kind | None],
        expression: Expression,
        wrong: list[str],
    ) -> Kind | None:
        count = _OPERANDS.get(operator, 2)
        if operator not in {*_OPERANDS, "==", "!=", *_ORDER, *_ARITHMETIC}:
            wrong.append(f"{operator!r} is no operator")
            return None
        if len(operands) != count if count else len(operands) < 2:
            wrong.append(f"{operator!r} with {len(operands)} operands; it takes {count or 'two or more'}")
            return None

        def expect(positions: Sequence[int], number: bool) -> bool:
            """Note which operands are not what the operator works on."""
            fine = True
            for k in positions:
                kind = kinds[k]
                right = isinstance(kind, tuple) if number else kind == "truth"
                if kind is not None and not right:
                    needed = "a number" if number else "a truth"
                    wrong.append(
                        f"in {_quoted(expression)}: {_quoted(operands[k])} is {_say(kind)}, where {needed} is needed"
                    )
                fine = fine and right
            return fine

        if operator in ("and", "or", "not"):
            expect(range(len(operands)), number=False)
            return "truth"
        if operator in _ORDER:
            expect((0, 1), number=True)
            return "truth"
        if operator in ("==", "!="):
            self._alike(operands, kinds, expression, "be compared", wrong)
            return "truth"
        if operator == "if":
            expect((0,), number=False)
            if not self._alike(operands[1:], kinds[1:], expression, "be values of one thing", wrong):
                return None
            yes, no = kinds[1], kinds[2]
            if isinstance(yes, tuple) and isinstance(no, tuple):
                return min(yes[0], no[0]), max(yes[1], no[1])
            return yes | no if isinstance(yes, frozenset) and isinstance(no, frozenset) else yes
        if not expect(range(len(operands)), number=True):
            return None
        return _range(operator, operands, [k for k in kinds if isinstance(k, tuple)], expression, wrong)

    def _alike(
        self,
        sides: Sequence[Expression],
        kinds: Sequence[Kind | None],
        whole: Expression,
        purpose: str,
        wrong: list[str],
    ) -> bool:
        a, b = kinds
        if a is None or b is None:
            return False
        if self._comparable(a, b):
            return True
        first, second = (f"{_quoted(x)} is {_say(k)}" for x, k in zip(sides, (a, b), strict=True))
        wrong.append(f"in {_quoted(whole)}: {first}, {second}; they cannot {purpose}")
        return False

    def _comparable(self, a: Kind, b: Kind) -> bool:
        """Return whether a and b are both truths, both numbers, or literals of one enumeration."""
        if isinstance(a, frozenset) and isinstance(b, frozenset):
            return any(a | b <= enumeration for enumeration in self._enumerations)
        return type(a) is type(b)


def _kind_of(domain: Sequence[Value]) -> Kind:
    if isinstance(domain[0], str):
        return frozenset(str(v) for v in domain)
    if isinstance(domain[0], bool):
        return "truth"
    numbers = [int(v) for v in domain]
    return min(numbers), max(numbers)


def _range(
    operator: str,
    operands: Sequence[Expression],
    ranges: Sequence[tuple[int, int]],
    expression: Expression,
    wrong: list[str],
) -> Kind | None:
    """Return the lowest and highest result of arithmetic on numbers in ``ranges``."""
    if operator == "neg":
        return _number([-n for n in ranges[0]], expression, wrong)
    (a, b), (c, d) = ranges
    if operator == "+":
        return _number([a + c, b + d], expression, wrong)
    if operator == "-":
        return _number([a - d, b - c], expression, wrong)
    if operator == "*":
        return _number([x * y for x in (a, b) for y in (c, d)], expression, wrong)
    if not isinstance(operands[1], Constant) or c == 0:
        wrong.append(f"in {_quoted(expression)}: the divisor must be written as a number other than 0")
        return None
    if operator == "//":
        return _number([a // c, b // c], expression, wrong)
    return _number([0, c - 1 if c > 0 else c + 1], expression, wrong)


def _number(numbers: Sequence[int], expression: Expression, wrong: list[str]) -> Kind | None:
    lowest, highest = min(numbers), max(numbers)
    if -_WORD <= lowest and highest < _WORD:
        return lowest, highest
    wrong.append(f"{_quoted(expression)} may leave the 64 bits of a whole number")
    return None


def _say(kind: Kind | None) -> str:
    if not isinstance(kind, frozenset):
        return "true or false" if kind == "truth" else "a number"
    *others, last = sorted(kind)
    if len(others) > 5:
        return f"{', '.join(others[:5])} or another name"
    return f"{', '.join(others)} or {last}" if others else f"the name {last}"


def _quoted(expression: Expression) -> str:
    return repr(shortened(str(expression)))


# -- what is wrong with the parts of a problem together ------------------------------------------------------


def owner(name: str) -> str:
    """Return how messages call the automaton called ``name``."""
    return f"automaton {name!r}" if name else "an automaton without a name"


def name_clashes(automata: Sequence[ExtendedAutomaton], variables: Sequence[Variable], where: str) -> list[Mistake]:
    """Return the names that stand for two things."""
    counts = Counter(part.name for part in (*automata, *variables) if part.name)  # type: ignore[attr-defined]
    mistakes = [Mistake(where, f"two parts are called {n!r}") for n, count in counts.items() if count > 1]
    states = {a.name: frozenset(a.states) for a in automata}
    names = {v.name for v in variables}
    for v in variables:
        literals = [value for value in v.values if isinstance(value, str) and is_writable(value)]
        words = [(v.name, "it")] + [(value, f"its value {value!r}") for value in literals]
        for word, what in words:
            automaton, _, state = word.rpartition(".")
            if state in states.get(automaton, ()):
                other = f"the state {state!r} of automaton {automaton!r}"
            elif what != "it" and word in names:
                other = "a variable"
            else:
                continue
            mistakes.append(Mistake(f"variable {v.name!r}", f"{what} is called like {other}; rename one of them"))
    return mistakes


def written_twice(automata: Iterable[ExtendedAutomaton]) -> list[Mistake]:
    """Return the variables that two automata update: who would be right?"""
    writers: dict[str, str] = {}
    mistakes = []
    for a in automata:
        for v in dict.fromkeys(v for edge in a.edges for v, _ in edge.updates):
            if writers.setdefault(v, a.name) != a.name:
                what = f"updated by {owner(writers[v])} and by {owner(a.name)}; let one of them do it"
                mistakes.append(Mistake(f"variable {v!r}", what))
    return mistakes


def about_specs(plant_conditions: Iterable[Condition], specs: Iterable[ExtendedAutomaton]) -> list[Mistake]:
    """Return the invariants of the plants that speak of specifications: what can be does not depend on what may be."""
    updated = {v: a.name for a in specs for edge in a.edges for v, _ in edge.updates}
    names = {a.name for a in specs}
    mistakes = []
    for c in plant_conditions:
        for leaf in dict.fromkeys(leaves(c.predicate) if c.event is None else ()):
            if isinstance(leaf, At) and leaf.automaton in names:
                what = f"{str(leaf)!r}, a state of a specification"
            elif isinstance(leaf, Name) and leaf.name in updated:
                what = f"{leaf.name!r}, which specification {updated[leaf.name]!r} updates"
            else:
                continue
            mistakes.append(
                Mistake(_place(c), f"an invariant of the plants depends on {what}; make it one of the specs")
            )
    return mistakes


def _place(condition: Condition) -> str:
    return f"condition {shortened(condition.name or str(condition))!r}"
