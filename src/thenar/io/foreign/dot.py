r"""Graphviz DOT: one automaton as a drawing, as most tools draw it.

* Nodes are states, called by their label, or by their ID where they have none or share it with another; those with a
  double line (``shape=doublecircle``, ``doubleoctagon``, ``peripheries=2``) are marked.
* An edge carries the events of its label, separated by commas or line ends; white space within a name becomes ``_``.
  ``!`` before or behind a name, on one edge at least, says that the event is uncontrollable.
* Initial is the state at the end of an edge without label that comes from a node which is no state: no edge enters it,
  all that leave it have no label, and it is not drawn as one (``shape=point``, ``none`` or ``plaintext``,
  ``style=invis``, an empty label) or is called start or init.
* The name of the graph is that of the automaton; its attribute ``comment`` is the meaning.
* Attributes of the layout, colours and ports are skipped; defaults (``node [...]``), subgraphs and edges between groups
  of nodes are read as ``dot`` reads them.
* Refused: undirected graphs, HTML labels, edges without a label, several graphs in a file.

Written in addition: ``alphabet="a, b!"``, an attribute of the graph that ``dot`` skips.  It lists the events in order,
also those that no edge carries, which the automaton blocks.  Edges whose events are all uncontrollable are dashed.

Source: "DOT Language", https://graphviz.org/doc/info/lang.html.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from html import unescape
from html.entities import html5
from pathlib import Path

from thenar.io.foreign.apart import BLOCK, Parts, apart, beside, by_pair, said
from thenar.io.foreign.assemble import assembled
from thenar.io.foreign.dot_graph import Graph, Html, read_graph
from thenar.io.foreign.words import Labels, Mistakes, decoded
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps", "loads"]

_DOUBLE = ("doublecircle", "doubleoctagon")
_NO_STATE = ("point", "none", "plaintext", "plain", "")
_ENTRY = re.compile(r"_*(start|init|initial|entry)(?![a-z])", re.IGNORECASE)
_ESCAPE = re.compile(r"\\(.)", re.DOTALL)
_ENTITY = re.compile(r"&(#[0-9]{1,7}|#[xX][0-9a-fA-F]{1,6}|\w{1,31});")


def loads(data: bytes, source: str) -> Automaton | ExtendedAutomaton:
    """Return the automaton in ``data``; ``source`` is what messages call the file, its stem a graph without a name.

    O(length of the file).  Raises ModelError with all mistakes, their lines and columns.

    >>> loads(b'''digraph LAMP { rankdir=LR; start [shape=point];
    ...   node [shape=doublecircle]; off; node [shape=circle]; start -> off;
    ...   off -> on [label="press"]; on -> off [label="press, burn out!"] }''', "lamp.dot")
    Automaton 'LAMP': 2 states (1 marked), 3 transitions, 2 events
    >>> loads(b"digraph { start -> a; a -> b }", "g.dot")
    Traceback (most recent call last):
    thenar.errors.ModelError: g.dot:1:23: the edge a -> b has no label, and a transition needs an event
    """
    mistakes = Mistakes(source)
    graph = read_graph(decoded(data, source), mistakes)
    entries = _entries(graph)
    states = [k for k in range(len(graph.nodes)) if k not in entries]
    number = {k: q for q, k in enumerate(states)}
    labels = Labels(_shown)
    labels.numbers(graph.text("alphabet"), 0)
    initial: list[int] = []
    columns: tuple[list[int], list[int], list[int]] = ([], [], [])
    for edge in graph.edges:
        if edge.source in entries:
            initial.append(number[edge.target])
        elif isinstance(edge.label, Html):
            mistakes.add(graph.place(edge.place), 'the label is HTML; write it in quotes, as in label="a, b"')
        else:
            carried = labels.numbers(edge.label, edge.place)
            if not carried:
                ends = " -> ".join(graph.nodes[k].id for k in (edge.source, edge.target))
                mistakes.add(graph.place(edge.place), f"the edge {ends} has no label, and a transition needs an event")
            for e in carried:
                columns[0].append(number[edge.source])
                columns[1].append(e)
                columns[2].append(number[edge.target])
    if states and not initial:
        mistakes.add("", "no initial state; draw an edge without label to it from a node with shape=point")
    sigma = labels.alphabet(graph.place, mistakes)
    return assembled(
        _shown(graph.name) or Path(source).stem,
        sigma,
        _state_names(graph, states, mistakes),
        initial,
        [_is_marked(graph.nodes[k].attributes) for k in states],
        *columns,
        meaning=_shown(graph.text("comment")),
        where=source,
    )


def _entries(graph: Graph) -> set[int]:
    """Return the nodes that are no states: they point at the initial ones, or stand alone."""
    entered = {edge.target for edge in graph.edges}
    labelled = {edge.source for edge in graph.edges if isinstance(edge.label, Html) or edge.label.strip()}
    leaves = {edge.source for edge in graph.edges}
    entries = set()
    for k, node in enumerate(graph.nodes):
        if k in entered or k in labelled:
            continue
        look = node.attributes
        label = look.get("label", "\\N")
        hidden = look.get("shape", "ellipse").lower() in _NO_STATE or "invis" in look.get("style", "")
        if hidden or (k in leaves and (not label.strip() or not node.id or _ENTRY.match(node.id))):
            entries.add(k)
    return entries


def _is_marked(attributes: dict[str, str]) -> bool:
    peripheries = attributes.get("peripheries", "")
    return attributes.get("shape", "").lower() in _DOUBLE or (peripheries.isdigit() and peripheries not in ("0", "1"))


def _state_names(graph: Graph, states: Sequence[int], mistakes: Mistakes) -> list[str]:
    """Return the name of each of ``states``: its label, or its ID."""
    names = []
    for k in states:
        node = graph.nodes[k]
        label = node.attributes.get("label", "\\N")
        if isinstance(label, Html):
            mistakes.add(graph.place(node.place), f"the label of {node.id} is HTML; write it in quotes")
        names.append(_shown(label.replace("\\N", node.id)).replace("\n", " ").strip())
    mistakes.check()
    often = Counter(names)
    return [name if name and often[name] == 1 else graph.nodes[k].id for k, name in zip(states, names, strict=True)]


def _shown(text: str) -> str:
    r"""Return what Graphviz shows of a label: ``\n`` and its like begin a line, entities are characters.

    >>> _shown(r"a\nb \\ &amp;&nothing;")
    'a\nb \\ &&nothing;'
    """
    if "\\" in text:
        text = _ESCAPE.sub(lambda m: "\n" if m[1] in "nlr" else m[1], text)
    return _ENTITY.sub(_character, text) if "&" in text else text


def _character(entity: re.Match[str]) -> str:
    return unescape(entity[0]) if entity[0][1] == "#" else html5.get(entity[0][1:], entity[0])


def dumps(automaton: Automaton | ExtendedAutomaton) -> Written:
    r"""Return ``automaton`` as a graph that ``dot`` draws.

    Said is everything but unobservable and forcible events, meanings of events, and names that cannot be printed or,
    if they are events', begin or end with ``!``; these are kept in :attr:`Written.names`.

    Raises InputError for guards and updates.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"],
    ...     uncontrollable=["off"], name="LAMP")
    >>> print("".join(dumps(lamp).chunks))
    digraph "LAMP" {
      rankdir=LR
      alphabet="on, off!"
      node [shape=circle]
      "off" [shape=doublecircle]
      "lit"
      init [shape=point]
      init -> "off"
      "off" -> "lit" [label="on"]
      "lit" -> "off" [label="off!" style=dashed]
    }
    <BLANKLINE>
    """
    parts = apart(automaton, "a drawing")
    states = said(parts.states, lambda q: q.isprintable() and q.strip() == q != "", "s")
    events = said(parts.alphabet.names, lambda e: e.isprintable() and e.strip("!") == e, "e")
    read = [Event(f, e.controllable) for f, e in zip(events, parts.alphabet, strict=True)]
    unsaid = not (parts.name + parts.meaning).isprintable()
    return Written(_text(parts, states, read), beside(parts, read, states, unsaid=unsaid))


def _text(parts: Parts, states: Sequence[str], events: Sequence[Event]) -> Iterator[str]:
    """Yield the statements of the file, some hundred at a time."""
    words = [_escaped(e.name) + "!" * (not e.controllable) for e in events]
    title = f' "{_escaped(parts.name)}"' if parts.name.isprintable() and parts.name else ""
    yield f'digraph{title} {{\n  rankdir=LR\n  alphabet="{", ".join(words)}"\n'
    if parts.meaning and parts.meaning.isprintable():
        yield f'  comment="{_escaped(parts.meaning)}"\n'
    yield "  node [shape=circle]\n"
    ids, taken = [], set(states)
    for start in range(0, len(states), BLOCK):
        statements = []
        for k, name in enumerate(states[start : start + BLOCK], start):
            look = ["shape=doublecircle"] * bool(parts.marked[k])
            called = name
            if '"' in name or "\\" in name or "&" in name:  # dot reads more into an ID than its label shows
                called = _fresh(f"s{k}", taken)
                look.insert(0, f'label="{_escaped(name)}"')
            ids.append(f'"{called}"')
            statements.append(f"  {ids[-1]} [{' '.join(look)}]\n" if look else f"  {ids[-1]}\n")
        yield "".join(statements)
    if parts.initial:
        entry = _fresh("init", taken)
        yield f"  {entry} [shape=point]\n" + "".join(f"  {entry} -> {ids[q]}\n" for q in parts.initial)
    free = [not e.controllable for e in events]
    for pairs in by_pair(parts):
        yield "".join(
            f'  {ids[s]} -> {ids[t]} [label="{", ".join([words[e] for e in carried])}"'
            f"{' style=dashed' * all(free[e] for e in carried)}]\n"
            for s, t, carried in pairs
        )
    yield "}\n"


def _fresh(name: str, taken: set[str]) -> str:
    """Return ``name``, lengthened until it is not ``taken``."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def _escaped(text: str) -> str:
    r"""Return ``text`` such that Graphviz shows it as it is.

    >>> _escaped('"a\\b" & c')
    '\\"a\\\\b\\" &amp; c'
    """
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("&", "&amp;")
