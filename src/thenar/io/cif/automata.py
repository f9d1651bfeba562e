"""One automaton of a CIF model: its alphabet, its locations, its edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any

from lark import Token, Tree

from thenar.io.cif import terms
from thenar.io.cif.expressions import Reader
from thenar.io.cif.names import Event, Location, Variable
from thenar.io.cif.scopes import Scope
from thenar.io.cif.syntax import Node, children, unsupported
from thenar.io.cif.terms import Range, Term
from thenar.model import events
from thenar.model.extended import Edge, ExtendedAutomaton

__all__ = ["Part", "Step", "read_automaton"]

Updates = dict[Variable, Term]
MAX_NESTING = 50  # ifs in ifs
MAX_EDGES = 250_000  # edges of one automaton: an edge with a thousand events counts a thousand times


@dataclass(frozen=True, slots=True)
class Step:
    """An edge: from location ``source`` with ``event`` to ``target``, where ``guard`` is true, doing ``updates``."""

    source: int
    event: Event
    target: int
    guard: Term
    updates: tuple[tuple[Variable, Term], ...]
    node: Node


@dataclass(slots=True)
class Part:
    """An automaton as it is read; ``initial`` and ``marked`` hold the predicate of each location."""

    scope: Scope
    alphabet: dict[Event, None] = field(default_factory=dict)
    initial: list[Term] = field(default_factory=list)
    marked: list[Term] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)

    def here(self, location: int) -> Term:
        """Return the term that is true in ``location``."""
        if len(self.scope.locations) == 1:
            return terms.truth(True)
        return terms.at(self.scope.name, self.scope.locations[location].name)

    def enabled(self, event: Event) -> Term:
        """Return the term that is true where the automaton has an edge with ``event``."""
        return terms.either(*(terms.both(self.here(s.source), s.guard) for s in self.steps if s.event is event))

    def automaton(self, order: dict[Event, int], reader: Reader) -> ExtendedAutomaton:
        """Return the automaton, its events in ``order``."""
        ranked = sorted(self.alphabet, key=order.__getitem__)
        number = {e: k for k, e in enumerate(ranked)}
        edges = (
            Edge(
                s.source, number[s.event], s.target, s.guard.expression,
                tuple((str(reader.variable(v).expression), x.expression) for v, x in s.updates),
            )
            for s in self.steps
        )  # fmt: skip
        return ExtendedAutomaton(
            self.scope.name,
            events.Alphabet(events.Event(e.name, controllable=bool(e.controllable)) for e in ranked),
            tuple(at.name for at in self.scope.locations),
            tuple(not t.never for t in self.initial),
            tuple(not t.never for t in self.marked),
            tuple(edges),
        )


def read_automaton(scope: Scope, reader: Reader, collecting: Callable[[], AbstractContextManager[None]]) -> Part:
    """Return the automaton of ``scope``; ``collecting`` keeps what is wrong with one edge and lets the next be read."""
    part = Part(scope)
    listed, monitored = _named_events(scope, "alphabet"), _named_events(scope, "monitor")
    if any(at.name == "*" for at in scope.locations) and len(scope.locations) > 1:
        scope.fail(scope.at, f"automaton {scope.name!r} has several locations; give each a name")
    for k, at in enumerate(scope.locations):
        part.initial.append(_predicate(at, "initial", reader))
        part.marked.append(_predicate(at, "marked", reader))
        for tree in children(at.tree, "edge"):
            with collecting():
                part.steps += _steps(k, at, tree, reader)
        if len(part.steps) > MAX_EDGES:
            scope.fail(scope.at, f"automaton {scope.name!r} has more than {MAX_EDGES:,} edges")
    if all(t.never for t in part.initial):
        scope.fail(scope.at, f"automaton {scope.name!r} has no initial location; write 'initial;' where it begins")
    used = dict.fromkeys(s.event for s in part.steps)
    if listed is not None:
        for step in part.steps:
            if step.event not in listed:
                scope.fail(step.node, f"event {step.event.name!r} is not in the alphabet of {scope.name!r}")
    part.alphabet = used if listed is None else dict.fromkeys(listed)
    if monitored is not None:
        free = monitored or list(part.alphabet)
        part.alphabet |= dict.fromkeys(free)
        part.steps += _loops(part, free)
    part.steps = [s for s in part.steps if not s.guard.never]
    return part


def event_of(token: Any, scope: Scope) -> Event:
    """Return the event that ``token`` names in ``scope``."""
    found = scope.find(token)
    if not isinstance(found, Event):
        scope.fail(token, f"{str(token)!r} is no event")
    if found.channel:
        scope.fail(token, unsupported("channel"))
    if found.controllable is None:
        scope.fail(token, f"event {found.name!r} is neither controllable nor uncontrollable; declare it as one of them")
    return found


def _named_events(scope: Scope, what: str) -> list[Event] | None:
    """Return the events of the declarations ``what``; None without such a declaration."""
    trees = [i for i in scope.items if i.data == what]
    if not trees:
        return None
    return [event_of(c, scope) for tree in trees for c in tree.children if c is not None]


def _predicate(at: Location, what: str, reader: Reader) -> Term:
    """Return what the declarations ``what`` of a location ask for; false without one."""
    trees = children(at.tree, what)
    if not trees:
        return terms.truth(False)
    nodes = [c for tree in trees for c in tree.children if c is not None]
    return reader.truth(nodes, at.automaton) if nodes else terms.truth(True)


def _loops(part: Part, free: Sequence[Event]) -> list[Step]:
    """Return the self-loops that let a monitor follow its events where it has no edge for them."""
    loops = []
    guards: dict[tuple[int, Event], list[Term]] = {}
    for step in part.steps:
        guards.setdefault((step.source, step.event), []).append(step.guard)
    for k, at in enumerate(part.scope.locations):
        for event in dict.fromkeys(free):
            rest = terms.negate(terms.either(*guards.get((k, event), [])))
            loops.append(Step(k, event, k, rest, (), at.tree))
    return loops


# -- edges -----------------------------------------------------------------------------------------------------


def _steps(source: int, at: Location, tree: Tree[Token], reader: Reader) -> list[Step]:
    scope = at.automaton
    parts: dict[str, Any] = {str(c.data if isinstance(c, Tree) else c.type): c for c in tree.children if c is not None}
    if "NOW" in parts:
        scope.fail(parts["NOW"], unsupported("now"))
    if "edge_events" not in parts:
        scope.fail(tree, unsupported("tau"))
    happening = []
    for event in parts["edge_events"].children:
        token, *more = event.children
        if token.type == "TAU":
            scope.fail(token, unsupported("tau"))
        if more:
            scope.fail(token, unsupported("channel"))
        happening.append(event_of(token, scope))
    guard = reader.truth(parts["when"].children, scope) if "when" in parts else terms.truth(True)
    updates = _updates(parts["do"].children, scope, reader) if "do" in parts else {}
    target = source
    if "goto" in parts:
        token = parts["goto"].children[0]
        found = scope.members.get(str(token).replace("$", ""))
        if not isinstance(found, Location):
            scope.fail(token, f"automaton {scope.name!r} has no location {str(token)!r}")
        else:
            target = found.position
    changed = tuple((v, x) for v, x in updates.items() if x.expression != reader.variable(v).expression)
    return [Step(source, event, target, guard, changed, tree) for event in happening]


def _updates(nodes: Sequence[Any], scope: Scope, reader: Reader, depth: int = 0) -> Updates:
    """Return the new value of each variable that ``nodes`` assign; an if is one value or another."""
    if depth > MAX_NESTING:
        scope.fail(nodes[0], f"ifs nested deeper than {MAX_NESTING}")
    result: Updates = {}
    for node in nodes:
        if node.data == "assignment":
            target, value = node.children
            if isinstance(target, Tree):
                scope.fail(target, unsupported("tuple"))
            new = {_assigned(target, scope): reader.term(value, scope)}
            _check(new, node, scope, reader)
        else:
            new = _chosen(node, scope, reader, depth + 1)
        for variable, term in new.items():
            if variable in result:
                scope.fail(node, f"variable {variable.name!r} is assigned twice on one edge")
            result[variable] = term
    return result


def _chosen(tree: Any, scope: Scope, reader: Reader, depth: int) -> Updates:
    cases = []
    otherwise: Updates = {}
    for case in tree.children:
        if case is None:
            continue
        if case.data == "else_updates":
            otherwise = _updates(case.children, scope, reader, depth)
        else:
            condition, *nodes = case.children
            cases.append((reader.truth(condition.children, scope), _updates(nodes, scope, reader, depth)))
    variables = dict.fromkeys(v for new in [*(new for _, new in cases), otherwise] for v in new)
    result = {}
    for v in variables:
        unchanged = reader.variable(v)
        result[v] = terms.choose([(c, new.get(v, unchanged)) for c, new in cases], otherwise.get(v, unchanged))
    return result


def _assigned(target: Token, scope: Scope) -> Variable:
    found = scope.find(target)
    if not isinstance(found, Variable) or found.input:
        scope.fail(target, f"{str(target)!r} is no variable that can be assigned")
    if found.scope is not scope:
        scope.fail(target, f"variable {found.name!r} is assigned outside its own automaton")
    return found


def _check(new: Updates, node: Node, scope: Scope, reader: Reader) -> None:
    for variable, term in new.items():
        kind = reader.variable(variable).type
        if isinstance(kind, Range) and isinstance(term.type, Range):
            if term.type.high < kind.low or term.type.low > kind.high:
                scope.fail(node, f"variable {variable.name!r} of type {kind} is given a value of type {term.type}")
        elif kind != term.type:
            scope.fail(node, f"variable {variable.name!r} of type {kind} is given a value of type {term.type}")
