"""From the scopes of a CIF model to an ExtendedProblem."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from lark import Tree

from thenar.errors import Mistake, ModelError
from thenar.io.cif import terms
from thenar.io.cif.automata import Part, event_of, read_automaton
from thenar.io.cif.expressions import Reader
from thenar.io.cif.names import Component, Event, Location, Variable
from thenar.io.cif.scopes import Scope, expand
from thenar.io.cif.syntax import children, place
from thenar.io.cif.terms import Range, Term, TermError, Type, Words
from thenar.model import events, extended
from thenar.model.expressions import Constant, Operation, Value, conjunction
from thenar.model.extended import Condition, Edge, ExtendedAutomaton, ExtendedProblem

__all__ = ["build"]

MAX_VALUES = 2_000_000  # values of all variables together
MAX_INPUT = 10_000  # values of one input variable: there is an edge to each of them
MAX_MISTAKES = 100  # more of them say nothing new
_PLANT = ("plant", "automaton", "")  # what has no kind says what can happen


def build(roots: Sequence[Scope], name: str) -> ExtendedProblem:
    """Return the problem that the files with the scopes ``roots`` describe.

    Raises ModelError with every mistake that was found.
    """
    return _Builder(roots).problem(name)


class _Builder:
    def __init__(self, roots: Sequence[Scope]) -> None:
        self.reader = Reader()
        self.mistakes: list[Mistake] = []
        self.scopes: list[Scope] = []
        self.events: list[Event] = []
        self.variables: list[Variable] = []
        self.initial: list[Term] = []
        self.marked: list[Term] = []
        self.conditions: list[tuple[str, str, Term, Event | None]] = []  # kind, name, predicate, event
        self.values = 0
        for root in roots:
            self._walk(root)

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """Go on after what is wrong, and remember it."""
        try:
            yield
        except ModelError as error:
            self.mistakes += error.mistakes
            if len(self.mistakes) > MAX_MISTAKES:
                raise self.wrong() from None

    def wrong(self) -> ModelError:
        """Return the error with all mistakes so far, in the order of the text."""
        return ModelError(sorted(dict.fromkeys(self.mistakes), key=_in_order))

    def _walk(self, scope: Scope) -> None:
        self.scopes.append(scope)
        for named in scope.declared:
            if isinstance(named, Event):
                self.events.append(named)
            elif isinstance(named, Variable):
                self.variables.append(named)
            elif isinstance(named, Scope):
                self._walk(named)
            elif isinstance(named, Component):
                with self.collecting():
                    inner = expand(named)
                    if isinstance(inner, Scope):
                        self._walk(inner)

    def problem(self, name: str) -> ExtendedProblem:
        """Return the problem; raise ModelError with all that was found wrong on the way."""
        variables: list[extended.Variable] = []
        for variable in self.variables:
            with self.collecting():
                variables.append(self._variable(variable))
        parts: list[Part] = []
        for scope in self.scopes:
            if scope.kind != "group":
                with self.collecting():
                    parts.append(read_automaton(scope, self.reader, self.collecting))
            self._statements(scope, None, scope.items)
            for at in scope.locations:
                self._statements(scope, at, [c for c in at.tree.children if isinstance(c, Tree)])
        for part in parts:
            self._starts(part)
        if self.mistakes:
            raise self.wrong()
        used = {e for part in parts for e in part.alphabet}
        conditions = [c for c in self.conditions if c[3] is None or c[3] in used]
        for part in parts:
            if part.scope.kind in _PLANT:
                with self.collecting():
                    conditions += list(self._runtime_errors(part, parts, conditions))
        inputs = [_input(v.name, self.reader.variable(v)) for v in self.variables if v.input]
        if self.mistakes:
            raise self.wrong()
        order = {e: k for k, e in enumerate(self.events)}
        lone = all(p.scope.kind not in _PLANT for p in parts)  # a supervisor, or requirements, in a file of their own
        plants = [*(p.automaton(order, self.reader) for p in parts if lone or p.scope.kind in _PLANT), *inputs]
        specs = [p.automaton(order, self.reader) for p in parts if not (lone or p.scope.kind in _PLANT)]
        known = events.merge([a.alphabet for a in [*plants, *specs]])
        names = [*(e.name for e in self.events if e in used), *(a.alphabet[0].name for a in inputs)]
        try:
            return ExtendedProblem(
                [*plants, *(_condition(c) for c in conditions if c[0] in _PLANT)],
                [*specs, *(_condition(c) for c in conditions if c[0] not in _PLANT)],
                variables=variables,
                initial=conjunction(t.expression for t in self.initial),
                marked=conjunction(t.expression for t in self.marked),
                name=name,
                alphabet=events.Alphabet(known[known.index(e)] for e in names),
            )
        except ModelError as error:  # what only the whole shows
            where = self.scopes[-1].root.source if self.scopes else ""
            raise ModelError([Mistake(f"{where}: {m.where}", m.what) for m in error.mistakes]) from None

    # -- variables -------------------------------------------------------------------------------------------

    def _variable(self, variable: Variable) -> extended.Variable:
        term = self.reader.variable(variable)
        values = _values(term.type)
        if variable.input and len(values) > MAX_INPUT:
            variable.scope.fail(variable.at, f"an input variable with more than {MAX_INPUT:,} values")
        known, self.values = self.values, self.values + len(values)
        if known > MAX_VALUES:  # said already
            values = values[:1]
        elif self.values > MAX_VALUES:
            variable.scope.fail(variable.at, f"the variables up to here have more than {MAX_VALUES:,} values")
        name, domain = str(term.expression), list(values)
        return extended.Variable(name, domain, domain if variable.input else self._initial(variable, term, domain))

    def _initial(self, variable: Variable, term: Term, domain: Sequence[Value]) -> Sequence[Value]:
        """Return the values that ``variable`` may have at first; what depends on others goes to the problem."""
        scope, node = variable.scope, variable.initial
        if node is None:
            return [0 if isinstance(term.type, Range) and 0 in domain else _nearest(term.type, domain)]
        if isinstance(node, Tree) and node.data == "any_value":
            return domain
        nodes: list[Any] = node.children if isinstance(node, Tree) and node.data == "one_of" else [node]
        given = [self.reader.term(n, scope) for n in nodes]
        equal = []
        for n, value in zip(nodes, given, strict=True):
            try:
                equal.append(terms.apply("=", term, value))
            except TermError:
                scope.fail(
                    n, f"variable {variable.name!r} of type {term.type} begins with a value of type {value.type}"
                )
            if value.constant and terms.value_of(value) not in domain:
                scope.fail(n, f"variable {variable.name!r} of type {term.type} cannot begin with {value.expression}")
        if all(value.constant for value in given):
            first = {terms.value_of(value) for value in given}
            return [v for v in domain if v in first]
        self.initial.append(terms.either(*equal))
        return domain

    # -- predicates ------------------------------------------------------------------------------------------

    def _starts(self, part: Part) -> None:
        """Add what a location asks for, to begin or to be marked there, to the predicates of the problem."""
        for predicates, wanted in ((part.initial, self.initial), (part.marked, self.marked)):
            for k, predicate in enumerate(predicates):
                if not predicate.constant:
                    wanted.append(terms.either(terms.negate(part.here(k)), predicate))

    def _statements(self, scope: Scope, at: Location | None, items: Sequence[Any]) -> None:
        here = terms.truth(True)
        if at is not None and len(scope.locations) > 1:
            here = terms.at(scope.name, at.name)
        for item in items:
            match str(item.data):
                case "initial" | "marked" if at is None:
                    with self.collecting():
                        wanted = self.initial if item.data == "initial" else self.marked
                        nodes = [c for c in item.children if c is not None]
                        if not nodes:
                            scope.fail(
                                item, f"'{item.data}' asks for a condition here; only in a location it needs none"
                            )
                        wanted.append(self.reader.truth(nodes, scope))
                case "invariants":
                    first = item.children[0]
                    kind = "" if first is None or first.type != "KIND" else str(first)
                    for tree in children(item, "invariant"):
                        with self.collecting():
                            self._invariant(kind, tree, scope, here)

    def _invariant(self, kind: str, tree: Any, scope: Scope, here: Term) -> None:
        label, what = tree.children
        name = "" if label is None else scope.absolute(scope.plain(label))
        if not (isinstance(what, Tree) and what.data in ("needs", "disables")):
            predicate = self.reader.truth([what], scope)
            self.conditions.append((kind, name, terms.either(terms.negate(here), predicate), None))
            return
        who, condition = what.children if what.data == "needs" else reversed(what.children)
        predicate = self.reader.truth([condition], scope)
        if what.data == "disables":
            predicate = terms.negate(predicate)
        named = who.children if isinstance(who, Tree) and who.data == "set_" else [who]
        for token in named:
            if token is None or isinstance(token, Tree) or token.type != "NAME":
                scope.fail(token or who, f"the name of an event is asked for beside '{what.data}'")
            event = event_of(token, scope)
            self.conditions.append((kind, name, terms.either(terms.negate(here), predicate), event))

    def _runtime_errors(
        self, part: Part, parts: Sequence[Part], conditions: Sequence[tuple[str, str, Term, Event | None]]
    ) -> Iterator[tuple[str, str, Term, Event | None]]:
        """Yield requirements to stay out of states where an uncontrollable event would leave a variable's range.

        Such an assignment is an error of the model that a supervisor has to prevent, says CIF; a controllable
        event is prevented by not letting it happen.
        """
        for step in part.steps:
            if step.event.controllable:
                continue
            wrong = [w for v, x in step.updates if (w := _outside(x, self.reader.variable(v).type)) is not None]
            if not wrong:
                continue
            others = [p.enabled(step.event) for p in parts if p is not part and step.event in p.alphabet]
            needed = [c[2] for c in conditions if c[0] in _PLANT and c[3] is step.event]
            try:
                bad = terms.both(part.here(step.source), step.guard, terms.either(*wrong), *others, *needed)
                name = f"{part.scope.name}: no value out of range by {step.event.name}"
                yield "requirement", name, terms.negate(bad), None
            except TermError as error:
                raise ModelError([Mistake(place(step.node, part.scope.source), str(error))]) from None


def _in_order(mistake: Mistake) -> tuple[str, list[int]]:
    file, *numbers = mistake.where.rsplit(":", 2)
    return file, [int(n) for n in numbers if n.isdigit()]


def _outside(value: Term, kind: Type) -> Term | None:
    """Return the term that is true where ``value`` is no value of ``kind``; None if it always is one."""
    if not isinstance(kind, Range) or not isinstance(value.type, Range):
        return None
    wrong = []
    if value.type.low < kind.low:
        wrong.append(terms.apply("<", value, terms.number(kind.low)))
    if value.type.high > kind.high:
        wrong.append(terms.apply(">", value, terms.number(kind.high)))
    return terms.either(*wrong) if wrong else None


def _condition(condition: tuple[str, str, Term, Event | None]) -> Condition:
    _, name, predicate, event = condition
    return Condition(predicate.expression, None if event is None else event.name, name)


def _values(kind: Type) -> Sequence[Value]:
    match kind:
        case Range(low, high):
            return range(low, high + 1)
        case Words(literals=literals):
            return literals
    return (False, True)


def _nearest(kind: Type, domain: Sequence[Value]) -> Value:
    """Return the value that a variable begins with when the file says nothing: the one nearest to 0, or the first."""
    return domain[-1] if isinstance(kind, Range) and kind.high < 0 else domain[0]


def _input(name: str, variable: Term) -> ExtendedAutomaton:
    """Return the automaton that changes an input variable: any time, to any other value, by an event of its name."""
    sigma = events.Alphabet([events.Event(name, controllable=False)])
    value = variable.expression
    if isinstance(variable.type, (Range, Words)):
        constants = [Constant(v) for v in _values(variable.type)]
        edges = tuple(Edge(0, 0, 0, Operation("!=", (value, c)), ((str(value), c),)) for c in constants)
    else:
        edges = (Edge(0, 0, 0, updates=((str(value), Operation("not", (value,))),)),)
    return ExtendedAutomaton(f"{name}.input", sigma, ("*",), (True,), (True,), edges)
