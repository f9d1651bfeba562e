"""From a Waters module to a problem."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from keyword import iskeyword

from thenar.errors import Mistake, ModelError
from thenar.io.cif import terms
from thenar.io.cif.terms import Range, Term, TermError
from thenar.io.foreign.assemble import assembled
from thenar.io.foreign.compose import Component, composed
from thenar.io.foreign.waters.expressions import ATOMS, Reader, in_waters
from thenar.io.foreign.waters.graphs import Part, nodes_of, read_graph
from thenar.io.foreign.waters.looks import asked_by, holding
from thenar.io.foreign.waters.module import FORBIDDEN, Bindings, Module, expressions, identifier
from thenar.io.foreign.waters.shared import share
from thenar.io.foreign.xml import Element, fail, parse
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.expressions import TRUE, Expression, Value, conjunction
from thenar.model.extended import Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem
from thenar.model.variables import Variable

__all__ = ["read"]

_KINDS = {"PLANT": True, "SPEC": False, "SUPERVISOR": False}
MAX_VALUES = 2_000_000  # values of all variables together
MAX_MISTAKES = 100  # more of them say nothing new


def read(data: bytes, source: str) -> Problem | ExtendedProblem:
    """Return the problem that the module ``data`` describes; ModelError with all that is wrong and where."""
    root = parse(data, source)
    if root.tag != "Module":
        raise ModelError([Mistake(root.where, f"no Waters module: it begins with <{root.tag}>")])
    try:
        return _Builder(root).problem()
    except TermError as error:  # of what several elements say together
        raise ModelError([Mistake(root.where, in_waters(error))]) from None


class _Builder:
    def __init__(self, root: Element) -> None:
        self.root = root
        self.mistakes: list[Mistake] = []
        self.module = Module(root)
        self.notes: list[str] = []
        self.known: dict[str, None] = {}  # names of components
        self.names: dict[str, str] = {}  # of variables in expressions, and in the file
        self.initial: list[Expression] = []
        self.marked: list[Expression] = []
        self.rules: list[Expression] = []
        self.graphs: list[tuple[str, str, Element, Bindings]] = []
        self.variables: list[tuple[str, Element, Bindings, tuple[Value, ...]]] = []

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """Go on after what is wrong, and remember it."""
        try:
            yield
        except ModelError as error:
            self.mistakes += error.mistakes
            if len(self.mistakes) >= MAX_MISTAKES:
                self.check()

    def check(self) -> None:
        """Raise ModelError if something was wrong."""
        if self.mistakes:
            raise ModelError(list(dict.fromkeys(self.mistakes))[:MAX_MISTAKES])

    def problem(self) -> Problem | ExtendedProblem:
        """Return the problem; raise ModelError with all that was found wrong on the way."""
        for group in self.root.all("ComponentList"):
            for component, bindings in self.module.walk(group):
                with self.collecting():
                    self._sort(component, bindings)
        self.check()
        reader = self._reader()
        made = []
        for name, element, bindings, domain in self.variables:
            with self.collecting():
                made.append(self._variable(name, element, bindings, domain, reader))
        parts: list[Part] = []
        for name, kind, element, bindings in self.graphs:
            with self.collecting():
                parts.append(read_graph(name, kind, element, bindings, self.module, reader))
        self.check()
        taken = {*self.names, *(p.name for p in parts)}

        def title(wanted: str) -> str:
            while wanted in taken:
                wanted += "_"
            taken.add(wanted)
            return wanted

        parts += share(parts, lambda p: _KINDS[p.kind], reader, title)
        components = [self._component(p, reader) for p in parts]
        comments = [c.text for c in self.root.all("Comment") if c.text]
        others = [p for p in self.module.propositions if p not in (self.module.marking, FORBIDDEN)]
        self.notes += [
            f"Not read: the proposition {p!r}; states are marked by {self.module.marking!r}." for p in others
        ]
        events = self.module.events.values()
        try:
            return composed(
                components,
                name=self.root.attributes.get("Name", ""),
                description="\n".join([*comments, *self.notes]),
                alphabet=Alphabet(events),
                variables=made,
                rules=self.rules,
                initial=conjunction(self.initial) if self.initial else None,
                marked=conjunction(self.marked) if self.marked else None,
            )
        except ModelError as error:  # what only the whole shows
            raise ModelError([Mistake(f"{self.root.where}: {m.where}", m.what) for m in error.mistakes]) from None

    # -- what there is ---------------------------------------------------------------------------------------

    def _sort(self, component: Element, bindings: Bindings) -> None:
        """Note the name of a component, or refuse it."""
        if component.tag == "Instance":
            what = f"an instance of module {component.attributes.get('ModuleName', '')!r}, which is a file of its own"
            fail(component, f"{what}; copy its components into this module")
        if component.tag not in ("SimpleComponent", "VariableComponent"):
            fail(component, f"<{component.tag}> is no component that is read here")
        named = identifier(component)
        name = component.attributes.get("Name") or (self.module.name(named, bindings) if named else "")
        if not name:
            fail(component, "a component without a name")
        if name in self.known:
            fail(component, f"two components are called {name!r}")
        self.known[name] = None
        if component.tag == "VariableComponent":
            self.variables.append((name, component, bindings, self._domain(name, component, bindings)))
            return
        kind = component.get("Kind").upper()
        if kind == "PROPERTY":
            self.notes.append(f"Not read: property {name!r}, a question about the system.")
        elif kind not in _KINDS:
            fail(component, f"a component of kind {kind!r}; there are PLANT, SPEC, SUPERVISOR and PROPERTY")
        else:
            self.graphs.append((name, kind, component, bindings))

    def _domain(self, name: str, component: Element, bindings: Bindings) -> tuple[Value, ...]:
        holder = component.first("VariableRange")
        given = expressions(holder) if holder is not None else []
        if not given:
            fail(component, f"variable {name!r} has no range")
        domain = self.module.range(given[0], bindings)
        if sum(len(v[3]) for v in self.variables) + len(domain) > MAX_VALUES:
            fail(given[0], f"the variables up to here have more than {MAX_VALUES:,} values")
        if len({type(v) for v in domain}) != 1:
            fail(given[0], f"the range of {name!r} has no value" if not domain else "a range of numbers and atoms")
        return tuple(domain)

    def _reader(self) -> Reader:
        automata = {name: dict.fromkeys(nodes_of(element)) for name, _, element, _ in self.graphs}
        taken = {*automata, *(v for _, _, _, domain in self.variables for v in domain if isinstance(v, str))}
        known: dict[str, Term] = {}
        for name, _, _, domain in self.variables:
            plain = writable(name)
            while plain in taken or plain in self.names or _is_state(plain, automata):
                plain += "_"
            self.names[plain] = name
            numbers = [v for v in domain if isinstance(v, int)]
            known[name] = terms.variable(plain, Range(min(numbers), max(numbers)) if numbers else ATOMS)
        return Reader(self.module, known, {name: domain for name, _, _, domain in self.variables}, automata)

    # -- variables -------------------------------------------------------------------------------------------

    def _variable(
        self, name: str, element: Element, bindings: Bindings, domain: tuple[Value, ...], reader: Reader
    ) -> Variable:
        first, last = list(domain), list(domain)
        for holder in element.all("VariableInitial"):
            for given in expressions(holder):
                first = self._values(name, first, reader.truth(given, bindings), reader, self.initial)
        accepted: list[Term] = []
        for holder in element.all("VariableMarking"):
            proposition, *predicates = expressions(holder)
            which = self.module.name(proposition, bindings)
            if not predicates:
                fail(holder, f"a marking of {name!r} without a predicate")
            predicate = reader.truth(predicates[0], bindings)
            if which == self.module.marking:
                accepted.append(predicate)
            elif which == FORBIDDEN:
                self.rules.append(terms.negate(predicate).expression)
        if accepted:
            last = self._values(name, last, terms.either(*accepted), reader, self.marked)
        if not first:
            fail(element, f"variable {name!r} has no initial value")
        return Variable(str(reader.variables[name].expression), domain, first, last)

    def _values(
        self, name: str, values: list[Value], predicate: Term, reader: Reader, others: list[Expression]
    ) -> list[Value]:
        """Return those of ``values`` of which ``predicate`` is true; one about other variables goes to ``others``."""
        if any(leaf != reader.variables[name].expression for leaf in asked_by(predicate.expression)):
            others.append(predicate.expression)
            return values
        return holding(values, predicate.expression)

    # -- automata --------------------------------------------------------------------------------------------

    def _component(self, part: Part, reader: Reader) -> Component:
        events = self.module.events
        order = {e: k for k, e in enumerate(events)}
        ranked = sorted(part.alphabet, key=order.__getitem__)
        number = {e: k for k, e in enumerate(ranked)}
        alphabet = Alphabet(events[e] for e in ranked)
        steps = [s for s in part.steps if not s.guard.never]
        built: Automaton | ExtendedAutomaton
        if all(s.guard.expression == TRUE and not s.updates for s in steps):
            columns = ([s.source for s in steps], [number[s.event] for s in steps], [s.target for s in steps])
            where = part.element.where
            built = assembled(part.name, alphabet, part.nodes, part.initial, part.marked, *columns, where=where)
        else:
            initial = tuple(q in part.initial for q in range(len(part.nodes)))
            edges = tuple(
                Edge(s.source, number[s.event], s.target, s.guard.expression, _updates(s.updates, reader))
                for s in steps
            )
            nodes, marked = tuple(part.nodes), tuple(part.marked)
            built = ExtendedAutomaton(part.name, alphabet, nodes, initial, marked, edges)
        return Component(built, _KINDS[part.kind], tuple(part.forbidden))


def _updates(updates: Sequence[tuple[str, Term]], reader: Reader) -> tuple[tuple[str, Expression], ...]:
    """Return the updates by the names of the problem; a variable that is given its own value is not updated."""
    named = ((reader.variables[v].expression, x.expression) for v, x in updates)
    return tuple((str(v), x) for v, x in named if v != x)


def _is_state(name: str, automata: dict[str, dict[str, None]]) -> bool:
    automaton, _, state = name.rpartition(".")
    return state in automata.get(automaton, {})


def writable(name: str) -> str:
    """Return ``name`` as expressions can write it: ``buf:count`` is ``buf.count``, ``R[1].x`` is ``R_1.x``.

    >>> writable("buf:count"), writable("R[1].x"), writable("in"), writable("2nd value")
    ('buf.count', 'R_1.x', 'in_', '_2nd_value')
    """
    words = []
    for given in re.split(r"[.:]", unicodedata.normalize("NFKC", name)):
        word = re.sub(r"\W", "_", given.replace("]", "")) if given else ""
        if word and not word.isidentifier():
            word = "_" + word
        if word:
            words.append(word + "_" if iskeyword(word) or word in ("true", "false") else word)
    return ".".join(words) or "_"
