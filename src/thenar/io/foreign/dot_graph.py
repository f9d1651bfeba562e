r"""The DOT language: from text to nodes and edges with their attributes; what they mean is left to others.

Read without recursion, in one pass; groups nest as deep as memory allows.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NoReturn, TypeAlias

from thenar.io.foreign.words import Mistakes

__all__ = ["Edge", "Graph", "Html", "Node", "read_graph"]

GROUPED = 1_000_000  # edges that ``{a b} -> {c d}`` may stand for in a file
_HEEDED = frozenset(("label", "shape", "style", "peripheries"))  # attributes of nodes and edges that are kept

_TOKEN = re.compile(
    r"""(?:\s+|//[^\n]*|/\*.*?\*/|^\#[^\n]*)*+   # a line that begins with # is one of the C preprocessor
    (?:"(?P<quoted>[^"\\]*(?:\\.[^"\\]*)*)"
    |(?P<word>(?i:strict|graph|digraph|subgraph|node|edge)(?![\w\u0080-\U0010ffff]))
    |(?P<id>[A-Za-z_\u0080-\U0010ffff][\w\u0080-\U0010ffff]*|-?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?))
    |(?P<sign>->|--|[][{};,=:+])
    |(?P<html><)
    |(?P<bad>.)
    |(?P<end>\Z))""",
    re.DOTALL | re.MULTILINE | re.VERBOSE,
)
# an edge as programs write it, and the beginning of what follows
_EDGE = re.compile(r'"([^"\\]*)"\s*->\s*"([^"\\]*)"\s*\[label="([^"\\]*)"(?:[ ,]\s*style=\w+)?\][ \t]*;?\s*(?=["}])')
_ANGLE = re.compile("[<>]")


class Html(str):
    """The text of an HTML label."""

    __slots__ = ()


@dataclass(slots=True)
class Node:
    """A node: its ID, those of its attributes that are heeded, and where it is mentioned first."""

    id: str
    attributes: dict[str, str]
    place: int


@dataclass(slots=True)
class Edge:
    """An edge between two nodes, given by their numbers."""

    source: int
    target: int
    label: str
    place: int


@dataclass(slots=True)
class Graph:
    """A directed graph; places are offsets in ``source``."""

    source: str
    name: str = ""
    attributes: dict[str, str] = field(default_factory=dict)
    nodes: list[Node] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)

    def place(self, offset: int) -> str:
        """Return the line and column of ``offset``."""
        before = self.source.rfind("\n", 0, offset)
        return f"{self.source.count(chr(10), 0, offset) + 1}:{offset - before}"

    def text(self, attribute: str) -> str:
        """Return an attribute of the graph, empty if it is not given or HTML."""
        value = self.attributes.get(attribute, "")
        return "" if isinstance(value, Html) else value


def read_graph(text: str, mistakes: Mistakes) -> Graph:
    r"""Return the only graph in ``text``.  O(len(text)).

    >>> graph = read_graph('digraph G { node [shape=box]; a; {b c} -> "d\\"" [label=<x>] }', Mistakes("g.dot"))
    >>> [node.id for node in graph.nodes], [(e.source, e.target) for e in graph.edges]
    (['a', 'b', 'c', 'd"'], [(1, 3), (2, 3)])
    """
    return _Parser(text, mistakes).graph()


Group: TypeAlias = "list[int | Group]"  # the nodes and groups that stand in a subgraph


@dataclass(slots=True)
class _Scope:
    """A graph or subgraph that is being read: its defaults, its nodes, and the chain of nodes that it stands in."""

    node: dict[str, str]
    edge: dict[str, str]
    members: Group
    chain: list[int | Group]
    opened: int


class _Parser:
    """Reads token after token.

    Of the next one, ``kind`` is the group of the pattern, ``value`` its text and ``at`` its place; ``sign`` and
    ``word`` are the text of signs and, in small letters, of keywords, and empty else.
    """

    def __init__(self, text: str, mistakes: Mistakes) -> None:
        self.text = text
        self.mistakes = mistakes
        self.result = Graph(text)
        self.numbers: dict[str, int] = {}
        self.grouped = 0
        self.strict = False
        self.restart(0)

    # -- tokens

    def restart(self, offset: int) -> None:
        """Go on at ``offset``."""
        self.matches: Iterator[re.Match[str]] = _TOKEN.finditer(self.text, offset)
        self.advance()

    def advance(self) -> None:
        """Step to the next token."""
        match = next(self.matches)  # there is always one: the end, and nobody steps beyond it
        self.kind = match.lastgroup or "bad"
        self.value, self.at = match[self.kind], match.start(self.kind) - (self.kind == "quoted")
        self.sign = self.value if self.kind == "sign" else ""
        self.word = self.value.lower() if self.kind == "word" else ""
        if self.kind == "bad":
            self.fail(_UNFINISHED.get(self.value, f"{self.value!r} has no meaning here"))

    def fail(self, what: str, at: int | None = None) -> NoReturn:
        self.mistakes.fail(self.result.place(self.at if at is None else at), what)

    def expect(self, sign: str) -> None:
        if self.sign != sign:
            self.fail(f"{sign!r} belongs here, not {self.found()}")
        self.advance()

    def found(self) -> str:
        return "the end of the file" if self.kind == "end" else repr(self.value)

    def name(self) -> str:
        """Return the ID that is next, and step over it."""
        kind, value = self.kind, self.value
        if kind == "id":
            self.advance()
            return value
        if kind == "quoted":
            self.advance()
            while self.sign == "+":
                self.advance()
                if self.kind != "quoted":
                    self.fail(f"'+' joins texts in quotes, not {self.found()}")
                value += self.value
                self.advance()
            return _unquoted(value)
        if kind != "html":
            self.fail(f"a name belongs here, not {self.found()}")
        return self.html()

    def html(self) -> Html:
        """Return the HTML that begins here, and step over it."""
        depth, start = 0, self.at
        for match in _ANGLE.finditer(self.text, start):
            depth += 1 if match[0] == "<" else -1
            if depth == 0:
                break
        else:
            self.fail("this '<' has no '>'")
        self.restart(match.end())
        return Html(self.text[start + 1 : match.start()])

    # -- statements

    def graph(self) -> Graph:
        """Read the file."""
        if self.word == "strict":
            self.strict = True
            self.advance()
        if self.word == "graph":
            self.fail("this graph is not directed; an automaton is a digraph, with edges ->")
        if self.word != "digraph":
            self.fail(f"a file of DOT begins with digraph, not {self.found()}")
        self.advance()
        if self.sign != "{":
            self.result.name = self.name()
        self.expect("{")
        self.statements()
        if self.kind != "end":
            self.fail("a second graph, or a brace too many; write one graph a file")
        if self.strict:
            self.once_each()
        return self.result

    def statements(self) -> None:
        """Read what stands in the braces of the graph, and the last brace."""
        scope = _Scope({}, {}, [], [], self.at)
        outer: list[_Scope] = []
        chain: list[int | Group] = []
        start = self.at
        while True:
            if not chain:
                if self.kind == "quoted":
                    self.plain_edges(scope)
                start = self.at
            if self.sign == "}":
                if chain:
                    self.fail("a node belongs here, at the end of the edge")
                self.advance()
                if not outer:
                    return
                inner, scope = scope, outer.pop()
                chain, start = inner.chain, inner.opened
                chain.append(inner.members)
                scope.members.append(inner.members)
            elif self.sign == "{" or self.word == "subgraph":
                if self.word:
                    self.advance()
                    if self.sign != "{":
                        self.name()
                self.expect("{")
                outer.append(scope)
                scope = _Scope(scope.node.copy(), scope.edge.copy(), [], chain, start)
                chain = []
                continue
            elif self.sign == ";" and not chain:
                self.advance()
                continue
            elif self.word in ("graph", "node", "edge") and not chain:
                word = self.word
                self.advance()
                given = self.attributes(word == "graph")
                if word != "graph":
                    (scope.node if word == "node" else scope.edge).update(given)
                elif not outer:
                    self.result.attributes.update(given)
                continue
            else:
                if self.kind == "end":
                    self.fail("the file ends within the graph; a brace is missing")
                at = self.at
                node = self.name()
                if self.sign == "=" and not chain:
                    self.advance()
                    value = self.name()
                    if not outer:
                        self.result.attributes[node] = value
                    continue
                if isinstance(node, Html):
                    self.fail("a node is called by HTML here; write its name in quotes", at)
                while self.sign == ":":  # a port, where the edge touches the node
                    self.advance()
                    self.name()
                chain.append(self.node(node, scope, at))
            if self.sign == "--":
                self.fail("'--' is for graphs without direction; write '->'")
            if self.sign == "->":
                self.advance()
                continue
            given = self.attributes(False)
            if len(chain) > 1:
                self.join(chain, scope.edge | given, start)
            elif isinstance(chain[0], int):
                self.result.nodes[chain[0]].attributes.update(given)
            chain = []

    def plain_edges(self, scope: _Scope) -> None:
        """Read the edges that stand here one after the other in the plainest way: it is much quicker."""
        at, edges = self.at, self.result.edges
        while match := _EDGE.match(self.text, at):
            tail, head, label = match.groups()
            edges.append(Edge(self.node(tail, scope, at), self.node(head, scope, at), label, at))
            at = match.end()
        if at != self.at:
            self.restart(at)

    def node(self, name: str, scope: _Scope, place: int) -> int:
        """Return the number of the node ``name``, which is made if it is new."""
        k = self.numbers.setdefault(name, len(self.numbers))
        if k == len(self.result.nodes):
            self.result.nodes.append(Node(name, scope.node.copy(), place))
        scope.members.append(k)
        return k

    def attributes(self, every: bool) -> dict[str, str]:
        """Read ``[a=b c=d][...]``; return those heeded, or all of them."""
        given: dict[str, str] = {}
        while self.sign == "[":
            self.advance()
            while self.sign != "]":
                key, value = self.name(), "true"
                if self.sign == "=":
                    self.advance()
                    value = self.name()
                if every or key in _HEEDED:
                    given[key] = value
                if self.sign in (",", ";"):
                    self.advance()
            self.advance()
        return given

    def join(self, chain: list[int | Group], attributes: dict[str, str], start: int) -> None:
        """Make the edges of ``chain``."""
        label, edges = attributes.get("label", ""), self.result.edges
        for a, b in pairwise(chain):
            if isinstance(a, int) and isinstance(b, int):
                edges.append(Edge(a, b, label, start))
                continue
            tails, heads = self.flat(a, start), self.flat(b, start)
            self.count(len(tails) * len(heads), start)
            edges += [Edge(s, t, label, start) for s in tails for t in heads]

    def flat(self, group: int | Group, start: int) -> list[int]:
        """Return the numbers of the nodes in ``group``, in order."""
        found: set[int] = set()
        rest: list[int | Group] = [group]
        while rest:
            part = rest.pop()
            if isinstance(part, int):
                found.add(part)
            else:
                self.count(len(part), start)
                rest += part
        return sorted(found)

    def count(self, edges: int, start: int) -> None:
        """Count ``edges`` towards those that groups may stand for."""
        self.grouped += edges
        if self.grouped > GROUPED:
            self.fail(f"edges between groups of nodes stand for more than {GROUPED:,} edges", start)

    def once_each(self) -> None:
        """Refuse edges that a strict graph has twice: ``dot`` would keep one of them."""
        seen: set[tuple[int, int]] = set()
        for edge in self.result.edges:
            if (edge.source, edge.target) in seen:
                self.fail("a second edge between these nodes, and a strict graph keeps one; drop strict", edge.place)
            seen.add((edge.source, edge.target))


_UNFINISHED = {'"': "this quote is not closed", "/": "this comment is not closed, or '/' has no meaning here"}


def _unquoted(text: str) -> str:
    r"""Return what a text in quotes says: only ``\"`` and a backslash at the end of a line are special.

    >>> _unquoted('say \\"no\\" \\n')
    'say "no" \\n'
    """
    if "\\" not in text:
        return text
    return re.sub(r'\\(\r?\n|["\\])', lambda m: {'"': '"', "\\": "\\\\"}.get(m[1], ""), text)
