"""Expressions of CIF as terms: names looked up, algebraic variables and constants written out."""

from __future__ import annotations

from collections.abc import Sequence
from keyword import iskeyword
from typing import Any

from lark import Token, Tree

from thenar.io.cif import terms
from thenar.io.cif.names import Alg, Argument, Const, Enum, Literal, Location, TypeName, Variable
from thenar.io.cif.scopes import Scope
from thenar.io.cif.syntax import Node, unsupported
from thenar.io.cif.terms import BOOL, Range, Term, TermError, Type, Words
from thenar.model.variables import MAX_VALUES

__all__ = ["Reader"]

# CIF's binary operators, from the weakest to the strongest; those of one row are read from left to right
_STRENGTH = {
    operator: k
    for k, row in enumerate(
        [
            ("=>", "<=>"),
            ("or",),
            ("and",),
            ("=", "!=", "<", "<=", ">", ">=", "in"),
            ("+", "-"),
            ("*", "/", "div", "mod"),
        ]
    )
    for operator in row
}
_LONG = ("and", "or", "+")
FUNCTIONS = {"abs": 1, "sign": 1, "min": 2, "max": 2}
MAX_DEPTH = 100  # brackets in brackets, and algebraic variables that use one another


class Reader:
    """Turns the expressions of one model into terms; each algebraic variable and constant once."""

    def __init__(self) -> None:
        self.known: dict[int, Term] = {}  # by the identity of what has the value
        self.busy: set[int] = set()
        self.depth = 0
        self.names: dict[str, str] = {}  # of variables, and as the file writes them

    def term(self, node: Node, scope: Scope) -> Term:
        """Return the term of the expression ``node``, whose names mean what they mean in ``scope``."""
        self.depth += 1
        try:
            if self.depth > MAX_DEPTH:
                scope.fail(node, f"an expression nested deeper than {MAX_DEPTH}, its algebraic variables written out")
            return self._token(node, scope) if isinstance(node, Token) else self._tree(node, scope)
        except TermError as error:
            scope.fail(node, str(error))
        finally:
            self.depth -= 1

    def truth(self, nodes: Sequence[Node], scope: Scope) -> Term:
        """Return the conjunction of the predicates ``nodes``."""
        found = [self.term(node, scope) for node in nodes]
        for node, term in zip(nodes, found, strict=True):
            if term.type != BOOL:
                scope.fail(node, f"a condition is asked for here, and this is of type {term.type}")
        return self._made(nodes[0], scope, "and", *found)

    def type(self, tree: Tree[Token], scope: Scope) -> Type:
        """Return the type that ``tree`` writes; ``int`` without bounds is refused."""
        parts: list[Any] = [c for c in tree.children if c is not None]
        first, *bounds = parts
        if isinstance(first, Token) and first.type == "BOOL":
            return BOOL
        if isinstance(first, Token) and first.type == "INT":
            if not bounds:
                scope.fail(tree, "an int without bounds; write int[LOWEST..HIGHEST]")
            low, high = (self.number(b, scope) for b in bounds)
            if low > high:
                scope.fail(tree, f"int[{low}..{high}] has no value")
            return Range(low, high)
        found = scope.find(first)
        if isinstance(found, Enum):
            return Words(found.name, found.literals)
        if not isinstance(found, TypeName):
            scope.fail(first, f"{str(first)!r} is no type")
        if id(found) in self.busy:
            scope.fail(first, f"type {str(first)!r} is made of itself")
        self.busy.add(id(found))
        try:
            return self.type(found.type, found.scope)
        finally:
            self.busy.discard(id(found))

    def number(self, node: Node, scope: Scope) -> int:
        """Return the number that the constant expression ``node`` is."""
        term = self.term(node, scope)
        if not isinstance(term.type, Range) or not term.constant:
            scope.fail(node, "a number that is known from the text is asked for here")
        return int(terms.value_of(term))

    def variable(self, variable: Variable) -> Term:
        """Return the term of ``variable``."""
        key = id(variable)
        if key not in self.known:
            kind = self.type(variable.type, variable.scope)
            if isinstance(kind, Range) and kind.high - kind.low >= MAX_VALUES:
                variable.scope.fail(variable.type, f"{kind} has more than {MAX_VALUES:,} values")
            self.known[key] = terms.variable(self._writable(variable.name), kind)
        return self.known[key]

    def _writable(self, name: str) -> str:
        """Return ``name``, changed if thenar's expressions cannot write it: CELL.from becomes CELL.from_."""
        words = [f"{word}_" if iskeyword(word) else word for word in name.split(".")]
        changed = ".".join(words)
        while changed in self.names and self.names[changed] != name:
            changed += "_"
        self.names[changed] = name
        return changed

    # -- single words ----------------------------------------------------------------------------------------

    def _token(self, token: Token, scope: Scope) -> Term:
        match token.type:
            case "NUMBER":
                if len(token) > 10:
                    raise TermError(f"the number {token[:12]}... is too large; CIF's numbers have 32 bits")
                return terms.number(int(token))
            case "TRUE" | "FALSE":
                return terms.truth(token.type == "TRUE")
            case "NAME":
                return self._named(token, scope)
            case "STRING":
                raise TermError(unsupported("string"))
        raise TermError(unsupported("real"))

    def _named(self, token: Token, scope: Scope) -> Term:
        match found := scope.find(token):
            case Variable():
                return self.variable(found)
            case Literal():
                return terms.word(found.name, Words(found.enum.name, found.enum.literals))
            case Location():
                return terms.at(found.automaton.name, found.name)
            case Const() | Argument() | Alg():
                key = id(found)
                if key not in self.known:
                    if key in self.busy:
                        scope.fail(token, f"{str(token)!r} is defined by itself")
                    self.busy.add(key)
                    try:
                        self.known[key] = self._value(found, token, scope)
                    finally:
                        self.busy.discard(key)
                return self.known[key]
            case Scope() if found.locations:
                raise TermError(f"{str(token)!r} is an automaton; name one of its locations")
        raise TermError(f"{str(token)!r} has no value: it is no variable, no location, no constant and no literal")

    def _value(self, found: Const | Argument | Alg, token: Token, scope: Scope) -> Term:
        if isinstance(found, Alg):
            if found.by_location:
                if len(found.by_location) < len(found.scope.locations):
                    raise TermError(f"algebraic variable {found.name!r} has no value in some locations")
                owner = found.scope
                if len(owner.locations) == 1:
                    return self.term(found.by_location[0][1], owner)
                cases = [(terms.at(owner.name, at.name), self.term(value, owner)) for at, value in found.by_location]
                return terms.select(cases)
            if found.value is None:
                raise TermError(f"algebraic variable {found.name!r} has no value; give it an equation")
            return self.term(found.value, found.scope)
        term = self.term(found.value, found.scope)
        if isinstance(found, Const) and not term.constant:
            scope.fail(token, f"the value of constant {found.name!r} is not known from the text")
        return term

    # -- constructs ------------------------------------------------------------------------------------------

    def _tree(self, tree: Tree[Token], scope: Scope) -> Term:
        parts: list[Any] = tree.children
        match str(tree.data):
            case "expression":
                return self._chain(parts, scope)
            case "bracketed":
                return self.term(parts[0], scope)
            case "negated":
                if parts[0].type == "NOT":
                    return terms.negate(self.term(parts[1], scope))
                inner = self.term(parts[1], scope)
                return terms.apply("neg", inner) if parts[0] == "-" else terms.apply("+", inner, terms.number(0))
            case "call":
                name, *given = parts
                if str(name) not in FUNCTIONS:
                    scope.fail(name, f"function {str(name)!r} is not read; there are {', '.join(FUNCTIONS)}")
                arguments = [self.term(g, scope) for g in given if g is not None]
                if len(arguments) < FUNCTIONS[name] or (len(arguments) > 1 and FUNCTIONS[name] == 1):
                    scope.fail(tree, f"{len(arguments)} arguments for {name}")
                result = arguments[0] if len(arguments) > 1 else terms.apply(str(name), arguments[0])
                for other in arguments[1:]:
                    result = terms.apply(str(name), result, other)
                return result
            case "if_":
                *cases, otherwise = parts
                conditions = [
                    (self.truth(case.children[0].children, scope), self.term(case.children[1], scope)) for case in cases
                ]
                return terms.choose(conditions, self.term(otherwise, scope))
            case "switch":
                return self._switch(tree, scope)
            case _:
                raise TermError(unsupported("set"))

    def _chain(self, parts: Sequence[Any], scope: Scope) -> Term:
        """Read operands and operators that take turns, each operator as strong as it is."""
        operands: list[Term] = [self.term(parts[0], scope)]
        waiting: list[Token] = []

        def reduce() -> None:
            operator, count = waiting.pop(), 2
            while waiting and operator in _LONG and waiting[-1] == operator:
                waiting.pop()
                count += 1
            chosen = operands[-count:]
            del operands[-count:]
            operands.append(self._made(operator, scope, str(operator), *chosen))

        for operator, node in zip(parts[1::2], parts[2::2], strict=True):
            while waiting and _STRENGTH[waiting[-1]] >= _STRENGTH[operator]:
                if operator in _LONG and waiting[-1] == operator:
                    break  # one long sum or conjunction, made at once
                if _STRENGTH[waiting[-1]] == 0:
                    scope.fail(operator, f"{str(operator)!r} after another; put brackets around one of them")
                reduce()
            if operator in ("in", "/"):
                scope.fail(operator, unsupported("set" if operator == "in" else "real"))
            waiting.append(operator)
            operands.append(self.term(node, scope))
        while waiting:
            reduce()
        return operands[0]

    def _made(self, node: Node, scope: Scope, operator: str, *operands: Term) -> Term:
        try:
            return terms.apply(operator, *operands)
        except TermError as error:
            scope.fail(node, str(error))

    def _switch(self, tree: Any, scope: Scope) -> Term:
        control, *cases = tree.children
        otherwise = cases.pop()
        found = scope.find(control) if isinstance(control, Token) and control.type == "NAME" else None
        chosen: list[tuple[Term, Term]] = []
        keys: list[object] = []
        for case in cases:
            key, value = case.children
            if isinstance(found, Scope):
                location = found.members.get(str(key).replace("$", ""))
                if not isinstance(location, Location):
                    scope.fail(key, f"{str(key)!r} is no location of automaton {found.name!r}")
                condition = terms.at(found.name, location.name)
                keys.append(location)
            else:
                known = self.term(key, scope)
                condition = self._made(key, scope, "=", self.term(control, scope), known)
                keys.append(known.expression if known.constant else None)
            chosen.append((condition, self.term(value, scope)))
        if otherwise is not None:
            chosen.append((terms.negate(terms.either(*(c for c, _ in chosen))), self.term(otherwise, scope)))
        if not chosen:
            scope.fail(tree, "a switch without a case")
        if None not in keys and len(set(keys)) == len(keys):  # one case at most: not nested one in another
            return terms.select(chosen)
        return terms.choose(chosen[:-1], chosen[-1][1])  # the cases are complete, says CIF
