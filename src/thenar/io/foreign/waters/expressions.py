"""Expressions of Waters as terms: names looked up, 0 and 1 taken for truths where truths are asked for."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from thenar.errors import did_you_mean
from thenar.io.cif import terms
from thenar.io.cif.terms import BOOL, Range, Term, TermError, Words
from thenar.io.foreign.waters.module import Bindings, Module, expressions, whole
from thenar.io.foreign.xml import Element, fail
from thenar.model.expressions import Constant, Value

__all__ = ["ATOMS", "Reader", "chain", "in_waters", "primed_names"]

ATOMS = Words("atom", ())  # all enumerations are of one type: atoms are equal if they are called the same
MAX_DEPTH = 100  # operators in one another, long sums and conjunctions aside
MAX_DIVISORS = 64  # values of a divisor that is no constant
_IDENTIFIERS = ("SimpleIdentifier", "IndexedIdentifier", "QualifiedIdentifier")
_OPERATORS = ("&", "|", "<", "<=", ">", ">=", "+", "-", "*", "/", "%")
_FUNCTIONS = {"min": 2, "max": 2, "ite": 3, "abs": 1}


class Reader:
    """Turns the expressions of one module into terms.

    ``variables`` gives the term of each variable, ``domains`` its values, ``automata`` the states of each
    automaton, all by their names in the file; ``written`` gives the values by the names in expressions.
    """

    def __init__(
        self,
        module: Module,
        variables: Mapping[str, Term],
        domains: Mapping[str, Sequence[Value]],
        automata: Mapping[str, Collection[str]],
    ) -> None:
        self.module, self.variables, self.domains, self.automata = module, variables, domains, automata
        self.atoms = {v for domain in domains.values() for v in domain if isinstance(v, str)}
        self.written = {str(t.expression): domains[name] for name, t in variables.items()}
        self._of_name = {t.expression: domains[name] for name, t in variables.items()}
        self._depth = 0

    def truth(self, element: Element, bindings: Bindings, primed: Mapping[str, Term] | None = None) -> Term:
        """Return the term of a condition; ``primed`` gives the next values of variables, if they may be asked for."""
        term = self.term(element, bindings, primed)
        try:
            return as_truth(term)
        except TermError as error:
            fail(element, in_waters(error))

    def new_value(self, variable: str, element: Element, bindings: Bindings) -> Term:
        """Return the term of a value that is given to ``variable``."""
        return self.fitted(variable, self.term(element, bindings), element)

    def fitted(self, variable: str, term: Term, element: Element) -> Term:
        """Return ``term`` as a value of ``variable``."""
        kind = self.variables[variable].type
        if isinstance(kind, Range) and not isinstance(term.type, Words):
            return as_number(term)
        if kind != term.type:
            fail(element, f"variable {variable!r} is given {term.expression}, which is no value of it")
        return term

    def term(self, element: Element, bindings: Bindings, primed: Mapping[str, Term] | None = None) -> Term:
        """Return the term of an expression."""
        self._depth += 1
        try:
            if self._depth > MAX_DEPTH:
                fail(element, f"an expression nested deeper than {MAX_DEPTH}")
            return self._term(element, bindings, primed)
        except TermError as error:
            fail(element, in_waters(error))
        finally:
            self._depth -= 1

    def _term(self, element: Element, bindings: Bindings, primed: Mapping[str, Term] | None) -> Term:
        if element.tag == "IntConstant":
            return terms.number(whole(element))
        if element.tag in _IDENTIFIERS:
            return self._named(element, bindings)
        parts = expressions(element)
        if element.tag == "FunctionCallExpression":
            return self._call(element, parts, bindings, primed)
        operator = element.attributes.get("Operator", "")
        if element.tag == "UnaryExpression" and len(parts) == 1:
            if operator == "'":
                name = self._variable(parts[0], bindings)
                if primed is None or name not in primed:
                    fail(element, f"the next value {name}' can be asked for in guards only")
                return primed[name]
            if operator == "!":
                return terms.negate(self.truth(parts[0], bindings, primed))
            if operator == "-":
                return terms.apply("neg", as_number(self.term(parts[0], bindings, primed)))
        elif element.tag == "BinaryExpression" and len(parts) == 2:
            if operator in ("==", "!="):
                return self._equality(operator, parts, bindings, primed)
            if operator in ("&", "|", "+"):
                parts = chain(element)
            if operator in _OPERATORS:
                return self.combined(operator, *(self.term(p, bindings, primed) for p in parts))
        known = "! ' & | == != < <= > >= + - * / %"
        raise TermError(f"operator {operator!r} of <{element.tag}> is not read here; there are {known}")

    def combined(self, operator: str, *operands: Term) -> Term:
        """Return the term of ``operator``, which is none of the comparisons for equality, on ``operands``."""
        if operator in ("&", "|"):
            join = terms.both if operator == "&" else terms.either
            return join(*map(as_truth, operands))
        numbers = list(map(as_number, operands))
        if operator in ("/", "%"):
            return divided("div" if operator == "/" else "mod", *numbers)
        return terms.apply(operator, *numbers)

    # -- names -----------------------------------------------------------------------------------------------

    def _variable(self, element: Element, bindings: Bindings) -> str:
        name = self.module.name(element, bindings)
        if name not in self.variables:
            fail(element, f"unknown variable {name!r}{did_you_mean(name, list(self.variables)[:1000])}")
        return name

    def assigned(self, element: Element, bindings: Bindings) -> str:
        """Return the name of the variable that an action assigns to."""
        return self._variable(element, bindings)

    def _named(self, element: Element, bindings: Bindings) -> Term:
        value = self.module.value(element, bindings)
        if isinstance(value, int):
            return terms.number(value)
        if isinstance(value, range | tuple):
            raise TermError("a value is asked for here, and this is a range")
        if value in self.variables:
            return self.variables[value]
        if value in self.atoms:
            return terms.word(value, ATOMS)
        if value in self.automata:
            raise TermError(f"{value!r} is an automaton; compare it with one of its states, {value} == STATE")
        known = [*self.variables, *sorted(self.atoms)][:1000]
        raise TermError(f"unknown name {value!r}{did_you_mean(value, known)}")

    def _automaton(self, element: Element, bindings: Bindings) -> str | None:
        """Return the automaton that ``element`` names, if it names one and nothing else."""
        if element.tag not in _IDENTIFIERS:
            return None
        value = self.module.value(element, bindings)
        known = value in self.variables or value in self.atoms
        return value if isinstance(value, str) and value in self.automata and not known else None

    # -- constructs ------------------------------------------------------------------------------------------

    def _equality(
        self, operator: str, parts: list[Element], bindings: Bindings, primed: Mapping[str, Term] | None
    ) -> Term:
        for one, other in (parts, parts[::-1]):
            if (automaton := self._automaton(one, bindings)) is not None:
                state = self.module.name(other, bindings)
                if state not in self.automata[automaton]:
                    near = did_you_mean(state, list(self.automata[automaton])[:1000])
                    fail(other, f"automaton {automaton!r} has no state {state!r}{near}")
                at = terms.at(automaton, state)
                return at if operator == "==" else terms.negate(at)
        equal = self.equal(*(self.term(p, bindings, primed) for p in parts))
        return equal if operator == "==" else terms.negate(equal)

    def equal(self, x: Term, y: Term) -> Term:
        """Return the term that is true where ``x`` and ``y`` have the same value."""
        if BOOL in (x.type, y.type) and not isinstance(x.type, Words) and not isinstance(y.type, Words):
            if not (_is_bit(x) and _is_bit(y)):
                x, y = as_number(x), as_number(y)
            else:
                x, y = as_truth(x), as_truth(y)
                for one, other in ((x, y), (y, x)):
                    if isinstance(one.expression, Constant):
                        return other if one.expression.value else terms.negate(other)
        for one, other in ((x, y), (y, x)):
            value, name = one.expression, other.expression
            known = self._of_name.get(name) if one.type == ATOMS and isinstance(value, Constant) else None
            if known is not None and terms.value_of(one) not in known:
                return terms.truth(False)
        if x.expression == y.expression:
            return terms.truth(True)
        common = self._common(x, y)
        if common is None:
            return terms.apply("=", x, y)
        return terms.either(*(terms.both(*(terms.apply("=", z, v) for z in (x, y))) for v in common))

    def _common(self, x: Term, y: Term) -> list[Term] | None:
        """Return the atoms that two variables share; None unless they are variables of different atoms."""
        a, b = (self._of_name.get(z.expression) if z.type == ATOMS else None for z in (x, y))
        if a is None or b is None or set(a) == set(b):
            return None
        return [terms.word(str(v), ATOMS) for v in a if v in b]

    def narrowed(self, variable: str, value: Term) -> tuple[Term, Term]:
        """Return where a new value is one that ``variable`` can have, as far as atoms go, and it in its own atoms."""
        common = self._common(self.variables[variable], value)
        if common is None:
            own = value.type != ATOMS or not value.constant or terms.value_of(value) in self.domains[variable]
            return terms.truth(own), value
        cases = [(terms.apply("=", value, v), v) for v in common]
        return terms.either(*(c for c, _ in cases)), terms.choose(cases[:-1], cases[-1][1]) if cases else value

    def _call(
        self, element: Element, parts: list[Element], bindings: Bindings, primed: Mapping[str, Term] | None
    ) -> Term:
        given = element.attributes.get("FunctionName", element.attributes.get("Name", ""))
        name = given.lstrip("\\").lower()
        if _FUNCTIONS.get(name) != len(parts):
            fail(element, f"function {given!r} of {len(parts)} is not read; there are min, max, abs and ite")
        if name == "ite":
            condition = self.truth(parts[0], bindings, primed)
            yes, no = (self.term(p, bindings, primed) for p in parts[1:])
            if yes.type != no.type and not isinstance(yes.type, Words) and not isinstance(no.type, Words):
                yes, no = as_number(yes), as_number(no)
            return terms.choose([(condition, yes)], no)
        return terms.apply(name, *(as_number(self.term(p, bindings, primed)) for p in parts))


def in_waters(error: TermError) -> str:
    """Return what is wrong with a term, of which the numbers have 32 bits here too."""
    return str(error).replace("CIF's numbers", "Waters' numbers")


def chain(element: Element) -> list[Element]:
    """Return the operands of a long sum or conjunction, however it is put in brackets."""
    operator, waiting, operands = element.attributes.get("Operator"), [element], []
    while waiting:
        part = waiting.pop()
        inner = expressions(part)
        if part.tag == "BinaryExpression" and part.attributes.get("Operator") == operator and len(inner) == 2:
            waiting += reversed(inner)
        else:
            operands.append(part)
    return operands


def primed_names(element: Element, bindings: Bindings, module: Module) -> list[str]:
    """Return the variables whose next values stand in ``element``, each once."""
    waiting, found = [element], []
    while waiting:
        part = waiting.pop()
        inner = expressions(part)
        if part.tag == "UnaryExpression" and part.attributes.get("Operator") == "'" and inner:
            found.append(module.name(inner[0], bindings))
        else:
            waiting += reversed(inner)
    return list(dict.fromkeys(found))


def _is_bit(term: Term) -> bool:
    return not isinstance(term.type, Range) or (term.type.low >= 0 and term.type.high <= 1)


def as_truth(term: Term) -> Term:
    """Return ``term``, which is a truth, or 0 or 1, as a truth."""
    if term.type == BOOL:
        return term
    if isinstance(term.type, Words) or not _is_bit(term):
        raise TermError(f"a condition is asked for here, and {term.expression} is none")
    if isinstance(term.expression, Constant):
        return terms.truth(bool(term.expression.value))
    return terms.apply("=", term, terms.number(1))


def as_number(term: Term) -> Term:
    """Return ``term``, which is a number or a truth, as a number."""
    if isinstance(term.type, Range):
        return term
    if isinstance(term.type, Words):
        raise TermError(f"a number is asked for here, and {term.expression} is an atom")
    if isinstance(term.expression, Constant):
        return terms.number(int(bool(term.expression.value)))
    return terms.choose([(term, terms.number(1))], terms.number(0))


def divided(operator: str, x: Term, y: Term) -> Term:
    """Return ``x`` divided by ``y``, rounded towards zero; the values of ``y`` are told apart if it is no constant."""
    if isinstance(y.expression, Constant):
        return terms.apply(operator, x, y)
    assert isinstance(y.type, Range)
    low, high = y.type.low, y.type.high
    if low <= 0 <= high:
        raise TermError(f"a division by {y.expression}, which may be 0; thenar cannot say where that is an error")
    if high - low >= MAX_DIVISORS:
        raise TermError(f"a division by {y.expression}, which has more than {MAX_DIVISORS} values")
    cases = [
        (terms.apply("=", y, terms.number(v)), terms.apply(operator, x, terms.number(v))) for v in range(low, high)
    ]
    return terms.choose(cases, terms.apply(operator, x, terms.number(high)))
