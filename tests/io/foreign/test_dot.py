"""Graphviz DOT: what drawings of automata look like, round trips, what ``dot`` says, and damaged files."""

import json
import shutil
import subprocess
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.io.foreign.drawn import assert_read_or_refused, damaged, facts, odd_automaton, text, with_names

from thenar.errors import InputError, ModelError
from thenar.io.foreign import dot
from thenar.io.foreign.dot_graph import GROUPED, read_graph
from thenar.io.foreign.words import Mistakes
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton

LAMP = """digraph "LAMP" {
    rankdir=LR; init [shape=point]
    node [shape=circle]; "on"
    node [shape=doublecircle]; off
    init -> off
    off -> on [label="press"]; on -> off [label="press, burn out!"]
}
"""


def read(content: str) -> Automaton | ExtendedAutomaton:
    return dot.loads(content.encode(), "g.dot")


def test_a_drawing() -> None:
    a = read(LAMP)
    assert (a.name, list(a.alphabet)) == ("LAMP", [Event("press"), Event("burn_out", False)])
    edges = {("off", "press", "on"), ("on", "press", "off"), ("on", "burn_out", "off")}
    assert facts(a)[1:] == (("on", "off"), edges, {"off"}, {"off"})


@pytest.mark.parametrize(
    "entry",
    [
        'i [shape=none, label=""]; i -> a;',  # libFAUDES
        'i [shape=point]; i -> "a"',
        'i [label="start" shape=plaintext]; i -> a',
        '{node [shape=plaintext, style=invis, label=""] __init_q0}; __init_q0 [height=0, width=0]; __init_q0 -> a',
        '__start0 [label="" shape="none"]; __start0 -> a;',
        "__start -> a",
        'start -> a [label=""]',
        '"" -> a',
        "I [style=invis, width=0]; I -> a",
        'x [label="", shape=None, height=.0]; x -> a:n',
    ],
)
def test_ways_to_draw_the_initial_state(entry: str) -> None:
    assert (
        facts(read(f'digraph {{ a -> b [label="x"]; b -> a [label="y"]; {entry} }}'))[1:]
        == facts(read('digraph { i [shape=point]; a -> b [label="x"]; i -> a; b -> a [label="y"] }'))[1:]
    )


def test_several_entries_and_choices_are_no_plain_automaton() -> None:
    a = read("digraph { i [shape=point] i -> {a b}; a -> {a b} [label=x] }")
    assert isinstance(a, ExtendedAutomaton)
    assert (a.initial, len(a.edges)) == ((True, True), 2)


def test_statements_are_read_as_dot_reads_them() -> None:
    a = read(r"""# a line of the preprocessor
        DiGraph G { // a comment
        graph [bgcolor="white";]; /* another
        */ node [shape = "double" + "circle"
        fontsize=10] [color=red]; edge [label="x\ny"]
        subgraph cluster_0 { label="inside" node [shape=box, peripheries=2]; -.5; "q\"1\
" }
        i [shape=point label=<<b>i</b>>]; i -> -.5 [label=""]
        -.5:p:ne -> "q\"1" -> q2 }""")
    edges = {(p, e, q) for p, q in (("-.5", 'q"1'), ('q"1', "q2")) for e in "xy"}
    assert facts(a)[1:] == (("-.5", 'q"1', "q2"), edges, {"-.5", 'q"1', "q2"}, {"-.5"})


def test_names_are_what_is_shown() -> None:
    labels = r'0 [label="at\nrest"]; 1 [label="a &amp; b \\ \"c\""]; 2 [label=x]; 3 [label=x]'
    a = read(f"digraph {{ i [shape=point]; i -> 0; {labels} }}")
    assert facts(a)[1] == ("at rest", 'a & b \\ "c"', "2", "3")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "g.dot:1:1: a file of DOT begins with digraph, not the end of the file"),
        ("graph { a -- b }", "g.dot:1:1: this graph is not directed; an automaton is a digraph"),
        ("digraph { a -- b }", "g.dot:1:13: '--' is for graphs without direction"),
        ("digraph { a -> b [label=<x>]; a [shape=doublecircle] }", "g.dot:1:11: the label is HTML"),
        ("digraph { i [shape=point]; i -> a; a [label=<x>] }", "g.dot:1:33: the label of a is HTML"),
        ("digraph { <b> }", "g.dot:1:11: a node is called by HTML here"),
        ("digraph { i -> a; a -> b; i [shape=point] }", "g.dot:1:19: the edge a -> b has no label"),
        ('digraph { a -> b [label="x"] }', "g.dot: no initial state"),
        ('digraph { i [shape=point]; i -> a; a -> a [label="ε"] }', "g.dot:1:36: event name 'ε'"),
        ("digraph { a", "g.dot:1:12: the file ends within the graph; a brace is missing"),
        ("digraph { a -> }", "g.dot:1:16: a node belongs here, at the end of the edge"),
        ("digraph { a -> ; b }", "g.dot:1:16: a name belongs here, not ';'"),
        ("digraph { a [label=] }", "g.dot:1:20: a name belongs here, not ']'"),
        ("digraph { a [label=x }", "g.dot:1:22: a name belongs here, not '}'"),
        ('digraph { "a }', "g.dot:1:11: this quote is not closed"),
        ("digraph { a /* b }", "g.dot:1:13: this comment is not closed"),
        ("digraph { a [label=<b }", "g.dot:1:20: this '<' has no '>'"),
        ("digraph { a } digraph { b }", "g.dot:1:15: a second graph"),
        ('strict digraph { i -> a; a -> a [label="x"]; a -> a [label="y"]; i [shape=point] }', "g.dot:1:46: a second"),
        ("digraph { é \x01 }", "g.dot:1:13: '\\x01' has no meaning here"),
    ],
)
def test_mistakes_name_the_place(content: str, message: str) -> None:
    with pytest.raises(ModelError) as error:
        read(content)
    assert str(error.value).startswith(message)


def test_dumps_then_loads_is_the_identity() -> None:
    rng = Random(3)
    for _ in range(1000):
        original = odd_automaton(rng)
        written = dot.dumps(original)
        again = dot.loads(text(written), f"{original.name}.dot")
        assert (again.name, again.meaning) == (original.name or ".dot", original.meaning)
        assert facts(with_names(again, written.names)) == facts(original)


def test_edges_in_the_plainest_way_are_read_like_others() -> None:
    rng = Random(8)
    for _ in range(100):
        content = text(dot.dumps(odd_automaton(rng))).decode()
        assert facts(read(content.replace("]\n", "] /* quickly? */\n"))) == facts(read(content))


def test_guards_are_refused() -> None:
    with pytest.raises(InputError, match=r"edge 1 .* no guards and updates"):
        dot.dumps(ExtendedAutomaton.from_edges("A", [("p", "a", "q", "n < 2")], initial="p"))


# -- hostile files


@settings(max_examples=400, deadline=None)
@given(
    st.one_of(
        damaged(
            [LAMP.encode(), b"digraph { i -> {a b} -> {c d}; subgraph s { x [label=<b>] } }"],
            [b'"', b"{", b"}", b"[", b"<", b"->", b"/*", b"subgraph", b"\\", b"\xff", b"+"],
        ),
        st.binary(max_size=60),
    )
)
def test_damaged_files_are_read_or_refused(data: bytes) -> None:
    assert_read_or_refused(dot.loads, data)


@pytest.mark.parametrize(
    "piece",
    ["{", "{a ", "}", "->", "a->", "[", "a[", '"', '"a"+', "<", "/*", "//", "\\", "a:", "a=", "subgraph ", "\n#", "&a"],
)
def test_what_repeats_a_hundred_thousand_times_takes_no_time(piece: str) -> None:
    for start in ("digraph { ", 'digraph { a [label="'):
        assert_read_or_refused(dot.loads, (start + piece * 100_000).encode())
    assert_read_or_refused(dot.loads, ("digraph { " + piece * 50_000 + "}" * 50_000 + "}").encode())


def test_edges_between_large_groups_are_refused() -> None:
    group = "{" + " ".join(f"n{k}" for k in range(2000)) + "}"
    nested = "{" * 5000 + group + "} -> x" * 5000
    for content in (f"{group} -> {group}", nested):
        with pytest.raises(ModelError, match=f"more than {GROUPED:,} edges"):
            read(f"digraph {{ {content} }}")


# -- Graphviz itself

needs_dot = pytest.mark.skipif(shutil.which("dot") is None, reason="dot is not installed")


def graphviz(data: bytes) -> dict[str, Any]:
    """Return what ``dot`` finds in ``data``."""
    answer = subprocess.run(["dot", "-Tdot_json"], input=data, capture_output=True, check=True, timeout=30)
    assert not answer.stderr
    found = json.loads(answer.stdout)
    assert isinstance(found, dict)
    return found


@needs_dot
def test_dot_reads_what_is_written() -> None:
    rng = Random(4)
    for _ in range(25):
        original = odd_automaton(rng)
        written = dot.dumps(original)
        data = text(written)
        found = graphviz(data)
        again = with_names(dot.loads(data, "file.dot"), written.names)
        labels = [e["label"] for e in found.get("edges", []) if e.get("label")]
        assert sum(label.count(", ") + 1 for label in labels) == len(facts(again)[2])  # type: ignore[arg-type]
        nodes = [o for o in found.get("objects", []) if "nodes" not in o]
        assert len(nodes) == len(again.marked) + 1
        assert sum(o.get("shape") == "doublecircle" for o in nodes) == sum(again.marked)


@needs_dot
def test_our_reader_finds_what_dot_finds() -> None:
    rng = Random(5)
    for _ in range(40):
        content = f"digraph {{ {_statements(rng, 3)} }}"
        found = graphviz(content.encode())
        objects = [o for o in found.get("objects", []) if "nodes" not in o and "subgraphs" not in o]
        names = {o["_gvid"]: o["name"] for o in objects}
        theirs = {o["name"]: (o.get("shape", ""), o.get("label", "\\N")) for o in objects if not _is_group(o)}
        graph = read_graph(content, Mistakes("g.dot"))
        ours = {n.id: (n.attributes.get("shape", ""), n.attributes.get("label", "\\N")) for n in graph.nodes}
        assert ours == theirs
        edges = sorted((names[e["tail"]], names[e["head"]], e.get("label", "")) for e in found.get("edges", []))
        assert sorted((graph.nodes[e.source].id, graph.nodes[e.target].id, e.label) for e in graph.edges) == edges


def _is_group(found: dict[str, Any]) -> bool:
    return str(found["name"]).startswith(("%", "cluster"))


def _statements(rng: Random, depth: int) -> str:
    return " ".join(_statement(rng, depth) for _ in range(rng.randint(1, 4)))


def _statement(rng: Random, depth: int) -> str:
    attributes = rng.choice(["", '[shape=box label="x"]', "[shape=circle,color=red]", '[label="a" "b"=c][shape=none;]'])
    kind = rng.randrange(4 if depth else 3)
    if kind == 0:
        return f"{rng.choice(['node', 'edge'])} {attributes or '[shape=point]'};"
    if kind == 1:
        return f"{rng.choice('abcdef')} {attributes}"
    if kind == 2:
        ends = [rng.choice("abcdef") if rng.random() < 0.7 or not depth else f"{{{_statements(rng, depth - 1)}}}"] * 2
        return " -> ".join([*ends, rng.choice("abcdef")]) + f" {attributes};"
    return f"{rng.choice(['', 'subgraph '])} {{ {_statements(rng, depth - 1)} }}"
