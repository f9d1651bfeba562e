"""Hostile files of formats that hold one automaton as numbers, words or a drawing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from tests.fuzz.hostile_models import DEEP, HUGE, MANY

__all__ = ["OWN"]


def _tct() -> Iterator[tuple[str, bytes]]:
    narrow, wide = b"CTCT DES file. Version 1.0\x1aZ8^0L;1\x55\xaa\x00\xff", b"x\x1aZ8^0L;2\x55\xaa\x00\xff"
    for head, width in ((narrow, 4), (wide, 8)):
        for size in (10**9, 2**31 - 1, -1, -(2**31), *((10**18, 2**63 - 1, -(2**63)) if width == 8 else ())):
            body = size.to_bytes(width, "little", signed=True) + bytes(width) + b"\xff" * (3 * width)
            yield (
                f"{size} states, {8 * width} bits",
                head + bytes(4) + len(body).to_bytes(4, "little") + body + b"\xff" * 4,
            )
        body = (2).to_bytes(width, "little") + bytes(width) + b"\xff" * width + bytes(width) + b"\xff\xff" + bytes(8)
        yield f"65,535 transitions announced, {8 * width} bits", head + bytes(8) + body
        yield f"a block of 4 GB, {8 * width} bits", head + b"\1\0\0\0\xff\xff\xff\x7f" + body
        rows = (bytes(width) + b"\0\0") * 500_000 + b"\xff" * (2 * width)
        size = (2).to_bytes(width, "little") + bytes(width) + b"\xff" * width
        yield f"many rows of nothing, {8 * width} bits", head + bytes(8) + size + rows + b"\xff" * 8
    start = b"\x85\xa4name\xa6libtct\xa7version\xa32.0\xa4init\x00\xa4size"
    for size in (b"\xce\x3b\x9a\xca\x00", b"\xcf\x0d\xe0\xb6\xb3\xa7\x64\x00\x00", b"\xff", b"\xcf" + b"\xff" * 8):
        yield f"size {size.hex()}, msgpack", start + size + b"\xa6states\x80"
        yield f"size {size.hex()} and as many states, msgpack", start + size + b"\xa6states\xdf\xff\xff\xff\xff"
    for what, value in (
        ("a map", b"\xdf\xff\xff\xff\xff"), ("an array", b"\xdd\xff\xff\xff\xff"), ("a text", b"\xdb\xff\xff\xff\xff"),
        ("bytes", b"\xc6\xff\xff\xff\xff"), ("an extension", b"\xc9\xff\xff\xff\xff\x01"),
        ("arrays in arrays", b"\x91" * DEEP), ("maps in maps", b"\x81\x00" * DEEP), ("maps of maps", b"\x81" * DEEP),
        ("a number that is none", b"\xcb\x7f\xf8" + bytes(6)),
    ):  # fmt: skip
        yield f"{what} without end, msgpack", start + value
        yield f"{what} as the states, msgpack", start + b"\x01\xa6states" + value
        yield f"{what} as a key, msgpack", b"\x85" + value
        yield f"{what} as a state, msgpack", start + b"\x01\xa6states\x81\x00" + value
        yield f"{what} as next, msgpack", start + b"\x01\xa6states\x81\x00\x82\xa6marked\xc3\xa4next" + value
    large = b"\x91\x92\xcf" + b"\xff" * 8
    yield "numbers of 64 bits, msgpack", start + b"\x01\xa6states\x81\x00\x82\xa6marked\xc3\xa4next" + large + b"\x00"
    yield "a state of 64 bits, msgpack", start + b"\x01\xa6states\x81\xcf" + b"\xff" * 8 + b"\x81\xa4next\xc0"


def _ads() -> Iterator[tuple[str, str]]:
    text = "A\nState size:\n{}\nMarker states:\n{}\nVocal states:\n\nTransitions:\n{}\n"
    for huge in (*HUGE, "9" * 19, "1e9", "0x7fffffff", "2000001"):
        yield f"{huge} states", text.format(huge, "", "")
        yield f"marker state {huge}", text.format("2", huge, "")
        yield f"a transition of {huge}", text.format("2", "", f"0 1 {huge}")
        yield f"label {huge}", text.format("2", "", f"0 {huge} 1")
    yield "as many states as TCT takes", text.format("2000000", "*", "")
    yield "headings again and again", text.format("2", "", "") * 50_000
    yield "a transition that lacks a number", text.format("2", "", "0 1 1\n" * DEEP + "0 1")
    yield "signs alone", text.format("2", "", "0 1 1\n0 1 +\n1 1 0\n")
    yield "comments without number", text.format("2", "", "# a\n" * 1_000_000)


def _faudes() -> Iterator[tuple[str, str]]:
    text = "<Generator> g <Alphabet> a </Alphabet> <States> {} </States> <TransRel> {} </TransRel> {} </Generator>"
    for huge in HUGE:
        yield f"states up to {huge}", text.format(f"<Consecutive> 1 {huge} </Consecutive>", "", "<I> 1 </I>")
        yield f"index {huge}", text.format(huge, "", f"<I> {huge} </I>")
        yield f"initial states up to {huge}", text.format("1", "", f"<I> <Consecutive> 1 {huge} </Consecutive> </I>")
        old = f"<cGenerator> <Generator> g <States> {huge} </States> <T> </T> <I> 1 </I> </Generator> </cGenerator>"
        yield f"{huge} states in the old form", old
    span = "<Consecutive> 1 1999999 </Consecutive>"
    yield "as many states as can be", text.format(span, "", f"<I> 1 </I> <M> {span} </M>")
    yield "states that are all initial", text.format(span, "", f"<I> {span} </I>")
    yield "the same states again and again", text.format(span, "", f"<M> {span * 1_000} </M>")
    spans = "".join(f" <Consecutive> {k} {k} </Consecutive>" for k in range(1, 50_000))
    yield "many short ranges", text.format(spans, "", f"<I> 1 </I> <M> {spans} </M>")
    listed = "".join(f"s{k} <x/>" for k in range(200_000))
    yield "states with sections", text.format(listed, "", "<I> s0 </I>")
    rows = "".join(f"s{k} a{k} s{k + 1}\n" for k in range(100_000))
    yield "states and events of transitions", f"<Generator> g <T> {rows} </T> <I> s0 </I> </Generator>"
    yield "marked states of nowhere", f"<Generator> g <T> </T> <I> {rows} </I> </Generator>"
    unknown = "".join(f"s{k} b{k} s{k + 1}\n" for k in range(100_000))
    yield "unknown events without number", text.format(rows, unknown, "<I> s0 </I>")
    yield "flags without end", text.format("", "", "").replace(" a ", " a " + "+C+ " * 500_000)
    yield "an opening sign and a long word", "<Generator> <" + "a" * 500_000
    yield "a closing sign and a long word", "<Generator> </" + "a" * 500_000
    yield "a long attribute", f"<Generator {'a' * 500_000}> g </Generator>"
    yield "a long attribute without value", f"<Generator {'a' * 250_000}={' ' * 250_000}> g </Generator>"
    yield "a comment without end", "<Generator> " + "<!--" * 250_000
    yield "a CDATA section without end", "<Generator> " + "<![CDATA[" * 100_000
    yield "a percent sign", "%" * 1_000_000
    yield "quotes", '<Generator> g <Alphabet> "' + "a" * 1_000_000


def _desuma() -> Iterator[tuple[str, str]]:
    for huge in (*HUGE, "²", "٣"):
        yield f"{huge} states", f"{huge}\n\na\t1\t0\n"
        yield f"{huge} transitions", f"1\n\na\t1\t{huge}\ne\ta\n"
    unknown = "".join(f"s{k}\t0\t1\ne{k}\tt{k}\n" for k in range(MANY))
    yield "unknown states without number", f"{MANY}\n{unknown}"
    yield "states that announce what others have", f"{MANY}\n" + f"s\t0\t{MANY}\n" * MANY
    yield "a state again and again", f"{MANY}\n" + "s\t0\t0\n" * MANY


def _dot() -> Iterator[tuple[str, str]]:
    group = "{" + " ".join(f"n{k}" for k in range(2_000)) + "}"
    yield (
        "groups of nodes with edges between all",
        f'digraph {{ i [shape=point]; i -> n0; {group} -> {group} [label="a"] }}',
    )
    yield "edges between groups, again and again", "digraph {" + " -> ".join([group] * 50) + ' [label="a"] }'
    yield "a chain of groups", "digraph {" + " -> ".join(["{}"] * DEEP) + ' [label="a"] }'
    yield "groups in groups", "digraph {" + "{ a " * DEEP + "}" * DEEP + "}"
    nested = "{ a " * 3_000 + "} -> b " * 3_000
    yield "groups in groups with edges", f'digraph {{ edge [label="x"]; {nested} }}'
    defaults = "".join(f'{{ node [a{k}="{k}" label="{k}"] ' for k in range(5_000))
    yield "defaults in groups", "digraph {" + defaults + "}" * 5_001
    yield "a comment without end", "digraph { " + "/*" * 500_000
    yield "quotes without end", 'digraph { "' + "\\" * 1_000_000
    yield "quotes joined", "digraph { " + " + ".join(['"a"'] * DEEP) + " }"
    yield "HTML in HTML", "digraph { a -> b [label=" + "<" * DEEP + ">" * DEEP + "] }"
    yield "HTML without end, often", "digraph { " + "a [label=<b>] " * 50_000 + "<"
    yield "entities", 'digraph { a -> b [label="' + "&#x10ffff;&#99999999;&amp" * 20_000 + '"] }'
    yield (
        "many labels",
        'digraph { i [shape=point]; i -> a; a -> a [label="' + ",".join(f"e{k}" for k in range(50_000)) + '"] }',
    )
    yield "edges without labels", "digraph { " + "a -> b " * 50_000 + "}"
    yield "hash signs", "digraph {" + "\n#" * 500_000
    for huge in HUGE:
        yield (
            f"peripheries {huge}",
            f'digraph {{ i [shape=point]; i -> a; a [peripheries={huge}]; a -> a [label="e"] }}',
        )


def _mermaid() -> Iterator[tuple[str, str]]:
    head = "stateDiagram-v2\n[*] --> a\n"
    yield "codes that are none", head + "a --> b: #²; #٣; #1114112; #55296; #99999999; #x; #0;\n"
    yield "a title without end", '---\ntitle: "' + "\\" * 1_000_001 + "\n---\n" + head
    yield "front matter without end", "---\n" + "title: a\n" * DEEP
    yield "states in states", head + "state a {\n" * DEEP
    yield "notes without end", head + "note right of a\n" * DEEP
    yield "descriptions without end", head + "accDescr {\n" * DEEP
    yield "notes", head + "note right of a\nend note\n" * DEEP
    yield "arrows without end", head + "a" + " --> a" * DEEP
    yield "arrows with no spaces", head + "a" + "-->a" * DEEP
    yield "classes", head + "a" + ":::a" * DEEP
    yield "a class of many", head + "class " + ",".join(f"s{k}" for k in range(DEEP)) + " marked"
    yield "spaces", head + "state" + " " * 1_000_000 + "a" + " " * 1_000_000 + "b"
    yield "spaces before a sign", head + ("a" + " " * 10_000 + "<\n") * 100
    yield "dashes", head + "a" + "-" * 1_000_000 + ">"
    yield "quotes", head + 'state "' + '" as "' * DEEP
    yield "codes", head + "a --> b: " + "#" * 1_000_000 + ";"
    yield "breaks", head + "a --> b: " + "<br" + " " * 1_000_000
    yield "many labels", head + "a --> a: " + ",".join(f"e{k}" for k in range(50_000))
    yield "unknown lines", head + "?\n" * DEEP


OWN: Mapping[str, Callable[[], Iterator[tuple[str, str | bytes]]]] = {
    "tct": _tct,
    "ads": _ads,
    "faudes": _faudes,
    "desuma": _desuma,
    "dot": _dot,
    "mermaid": _mermaid,
}  # fmt: skip
