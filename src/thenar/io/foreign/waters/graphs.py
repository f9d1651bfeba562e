"""The graph of a component: its nodes, groups of nodes, edges, and what it blocks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from thenar.errors import Mistake, ModelError, did_you_mean
from thenar.io.cif import terms
from thenar.io.cif.terms import Term
from thenar.io.foreign.waters.expressions import Reader
from thenar.io.foreign.waters.guards import ALWAYS, cases
from thenar.io.foreign.waters.module import FORBIDDEN, Bindings, Module
from thenar.io.foreign.xml import Element, fail

__all__ = ["Part", "Step", "nodes_of", "read_graph"]

MAX_MISTAKES = 100  # more of them say nothing new
MAX_MEMBERS = 2_000_000  # of all groups of nodes: each has those of the groups in it too


@dataclass(frozen=True, slots=True)
class Step:
    """A transition from node ``source`` with ``event`` to ``target``, where ``guard`` is true, doing ``updates``."""

    source: int
    event: str
    target: int
    guard: Term
    updates: tuple[tuple[str, Term], ...]
    element: Element


@dataclass(slots=True)
class Part:
    """An automaton of the module; events and variables by their names in the file."""

    name: str
    kind: str
    element: Element
    nodes: list[str] = field(default_factory=list)
    initial: list[int] = field(default_factory=list)
    marked: list[bool] = field(default_factory=list)
    forbidden: list[int] = field(default_factory=list)
    alphabet: dict[str, None] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)

    def here(self, node: int) -> Term:
        """Return the term that is true in ``node``."""
        return terms.truth(True) if len(self.nodes) == 1 else terms.at(self.name, self.nodes[node])


def nodes_of(component: Element) -> list[str]:
    """Return the names of the nodes of a component, groups left out."""
    return [
        n.get("Name") for g in component.all("Graph") for group in g.all("NodeList") for n in group.all("SimpleNode")
    ]


def read_graph(name: str, kind: str, component: Element, bindings: Bindings, module: Module, reader: Reader) -> Part:
    """Return the automaton that ``component`` draws.

    An automaton whose nodes never have the marking proposition marks all of them, unless its list of blocked
    events has it.  An edge from a group leaves each node in it; a node's own edge for the same event, or that of a
    group within the group, takes its place.  An edge from a group to itself leaves each node where it is.
    """
    part = Part(name, kind, component)
    graph = component.first("Graph")
    if graph is None:
        fail(component, f"component {name!r} has no graph")
    groups: dict[str, list[str]] = {}
    number: dict[str, int] = {}
    marks = False
    for node in (n for group in graph.all("NodeList") for n in group.all("SimpleNode", "GroupNode")):
        title = node.get("Name")
        if title in number or title in groups:
            fail(node, f"node {title!r} is there twice")
        propositions = {p for group in node.all("EventList") for p in module.labels(group, bindings)}
        if node.tag == "GroupNode":
            if propositions:
                fail(node, "a group of nodes with propositions is not read; give them to its nodes")
            groups[title] = list(_members(node))
            continue
        number[title] = len(part.nodes)
        part.nodes.append(title)
        part.marked.append(module.marking in propositions)
        marks |= module.marking in propositions
        if FORBIDDEN in propositions:
            part.forbidden.append(number[title])
        if node.attributes.get("Initial", "false").strip().lower() == "true":
            part.initial.append(number[title])
    if part.nodes and not part.initial:
        fail(component, f"automaton {name!r} has no initial node")
    blocked = [e for block in graph.all("LabelBlock") for e in module.labels(block, bindings)]
    if not marks and module.marking not in blocked:
        part.marked = [True] * len(part.nodes)
    edges = [e for group in graph.all("EdgeList") for e in group.all("Edge")]
    inside = _inside(groups, number, component)
    _read_edges(part, edges, inside, number, bindings, module, reader)
    part.alphabet.update(dict.fromkeys(e for e in blocked if e in module.events))
    return part


def _read_edges(
    part: Part,
    edges: Iterable[Element],
    inside: dict[str, frozenset[int]],
    number: dict[str, int],
    bindings: Bindings,
    module: Module,
    reader: Reader,
) -> None:
    mistakes: list[Mistake] = []
    of_groups: list[tuple[str, list[Step]]] = []
    for edge in edges:
        try:
            source, steps = _steps(part, edge, inside, number, bindings, module, reader)
        except ModelError as error:
            mistakes += error.mistakes
            if len(mistakes) > MAX_MISTAKES:
                break
            continue
        if source in inside:
            of_groups.append((source, steps))
        else:
            part.steps += steps
    if mistakes:
        raise ModelError(mistakes)
    # from the smallest group to the largest: what is further inside takes the place of what is outside
    taken: dict[tuple[int, str], list[tuple[frozenset[int] | None, Step]]] = {}
    for step in part.steps if of_groups else ():
        taken.setdefault((step.source, step.event), []).append((None, step))
    for source, steps in sorted(of_groups, key=lambda item: len(inside[item[0]])):
        for step in steps:
            there = taken.setdefault((step.source, step.event), [])
            within = [s for group, s in there if group is None or group < inside[source]]
            if not within:
                there.append((inside[source], step))
                part.steps.append(step)
            elif not step.guard.constant or not all(s.guard.constant for s in within):
                what = f"an edge of group {source!r} and one within it have guards for the same event {step.event!r}"
                fail(step.element, f"{what}; give the nodes their own edges")


def _steps(
    part: Part,
    edge: Element,
    inside: dict[str, frozenset[int]],
    number: dict[str, int],
    bindings: Bindings,
    module: Module,
    reader: Reader,
) -> tuple[str, list[Step]]:
    """Return the node or group that an edge leaves, and its steps; note its events in the alphabet."""
    source, target = edge.get("Source"), edge.get("Target")
    for end in (source, target):
        if end not in number and end not in inside:
            fail(edge, f"unknown node {end!r}{did_you_mean(end, list(number)[:1000])}")
    if target in inside and source != target:
        fail(edge, f"an edge that leads into group {target!r}; let it lead to one of its nodes")
    events = [e for block in edge.all("LabelBlock") for e in module.labels(block, bindings)]
    for event in events:
        if event not in module.events:
            fail(edge, f"{event!r} is a proposition, not an event")
    part.alphabet.update(dict.fromkeys(events))
    blocks = list(edge.all("GuardActionBlock"))
    found = cases(blocks, bindings, reader) if blocks else ALWAYS
    steps = []
    for q in sorted(inside[source]) if source in inside else [number[source]]:
        to = q if target in inside else number[target]
        module.step(edge, len(events) * len(found))
        steps += [Step(q, event, to, c.guard, c.updates, edge) for event in events for c in found]
    return source, steps


def _members(group: Element) -> Iterator[str]:
    """Yield the names of the nodes and groups that a group lists."""
    waiting = list(reversed(group.children))
    while waiting:
        element = waiting.pop()
        if element.tag in ("EventList", "BoxGeometry", "AttributeMap", "Attributes"):
            continue
        if "Name" in element.attributes:
            yield element.attributes["Name"]
        waiting += reversed(element.children)


def _inside(groups: dict[str, list[str]], number: dict[str, int], component: Element) -> dict[str, frozenset[int]]:
    """Return the nodes in each group, those of the groups in it included."""
    inside: dict[str, frozenset[int]] = {}
    looks = 0
    for title, members in groups.items():
        found: set[int] = set()
        met = {title}
        waiting = list(members)
        while waiting:
            member = waiting.pop()
            looks += 1
            if looks > MAX_MEMBERS:
                fail(component, f"the groups of nodes in one another have more than {MAX_MEMBERS:,} members")
            if member in number:
                found.add(number[member])
            elif member not in groups:
                fail(component, f"group {title!r} has an unknown node {member!r}")
            elif member not in met:
                met.add(member)
                waiting += groups[member]
        inside[title] = frozenset(found)
    return inside
