"""Files that want to take all memory, all time, or another file; each format's are read in a process of its own.

``python -m tests.fuzz.hostile FORMAT`` reads those of one format, with little memory, and prints what became of each.
"""

from __future__ import annotations

import json
import resource
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from random import Random
from time import perf_counter
from traceback import extract_tb

from tests.fuzz.harness import check, read
from tests.fuzz.seeds import small_seeds

from thenar.io.formats import Format, format_named

__all__ = ["MEMORY", "SECONDS", "cases", "main"]

MEMORY = 1_500 * 2**20  # bytes of address space, some 500 MiB of which are the interpreter's and NumPy's
SECONDS = 20.0  # for one file, on a busy machine
XML = ("wmod", "supremica", "faudes-xml", "ides")
Cases = Iterator[tuple[str, bytes]]
_HUGE = ("1000000000", "1000000000000000000", "9" * 30, "-1")
_MANY = 5_000
_DEEP = 100_000


def cases(format: Format) -> Cases:
    """Yield the names of hostile files of ``format``, and the files."""
    yield from _encodings(format)
    yield from _long(format)
    yield from _deep(format)
    if format.name in XML:
        yield from _entities(_ROOTS[format.name])
    for name, text in _OWN[format.name]():
        yield name, text.encode() if isinstance(text, str) else text


# -- what every format may meet ----------------------------------------------------------------------------------


def _encodings(format: Format) -> Cases:
    seed = next(iter(small_seeds(format)))
    yield "nothing", b""
    yield "white space", b" \n\t\r\n" * 1_000
    yield "NUL bytes", b"\0" * 100_000
    yield "NUL bytes behind", seed + b"\0" * 100
    yield "NUL bytes within", seed[: len(seed) // 2] + b"\0\0" + seed[len(seed) // 2 :]
    yield "a byte order mark alone", b"\xef\xbb\xbf"
    yield "a byte order mark", b"\xef\xbb\xbf" + seed
    yield "two byte order marks", b"\xef\xbb\xbf\xef\xbb\xbf" + seed
    yield "half a character", seed + "ä".encode()[:1]
    yield "half a UTF-16 surrogate", seed.replace(b"LAMP", b"\xed\xa0\x80")
    text = seed.decode("latin-1").replace("LAMP", "LÄMP")
    for encoding in ("latin-1", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-7", "cp037"):
        yield encoding, text.encode(encoding)
    yield "every byte", bytes(range(256)) * 100


def _long(format: Format) -> Cases:
    seed = next(iter(small_seeds(format)))
    yield "10 MB of a letter", b"a" * 10_000_000
    yield "10 MB of a digit", b"1" * 10_000_000
    yield "10 MB of spaces and a letter", b" " * 10_000_000 + b"a"
    for name in (b"LAMP", b"dark", b"on", b"lit"):
        if name in seed:
            yield f"a name of 500 kB for {name.decode()}", seed.replace(name, b"y" * 500_000)
            yield f"{name.decode()} with a name of 500 kB behind it", seed.replace(name, name + b" " + b"z" * 500_000)
            yield f"{name.decode()} once with a name of 200 kB", seed.replace(name, _WORDS, 1)
            yield f"{name.decode()} twice with a name of 200 kB", seed.replace(name, _WORDS).replace(_WORDS, _OTHER, 1)
    line = max(seed.splitlines(), key=len)
    for sign in b"<>[]{}()\"'#/%&;:,=!-+*\\.|~@\t":
        yield f"a line and 300 kB of {chr(sign)}", seed.replace(line, line + bytes([sign]) * 300_000)
        yield f"a line and 100 kB of {chr(sign)}a", seed.replace(line, line + (bytes([sign]) + b"a") * 50_000)


# of 211 letters, none of them rare or frequent: to find similar names among these takes very long
_WORDS = "".join(chr(0x4E00 + k * k % 211) for k in range(70_000)).encode()
_OTHER = "".join(Random(5).sample(_WORDS.decode(), 70_000)).encode()  # the same letters


def _deep(format: Format) -> Cases:
    seed = next(iter(small_seeds(format)))
    half = len(seed) // 2
    for opening, closing in ("()", "[]", "{}", "<>"):
        nested = (opening * _DEEP + closing * _DEEP).encode()
        yield f"nothing but {opening}{closing}, deep", nested
        yield f"{opening} without an end", opening.encode() * _DEEP
        yield f"{opening}{closing} within", seed[:half] + nested + seed[half:]
    yield "elements in one another", b"<a>" * _DEEP + b"</a>" * _DEEP
    for tag in _NESTED.get(format.name, ()):
        opening, closing = f"<{tag}>", f"</{tag.split()[0]}>"
        at = seed.rfind(b"</")
        nested = (opening * _DEEP + closing * _DEEP).encode()
        yield f"{opening} in one another, in the last", seed[:at] + nested + seed[at:]
        shallow = (opening * 400 + closing * 400).encode()
        yield f"400 of {opening} in one another", seed[:at] + shallow + seed[at:]


_NESTED = {
    "wmod": ("ComponentList", "EventAliasList", 'ForeachComponent Name="i"', "ConditionalComponent"),
    "supremica": ("Automaton", "States", "Layout"),
    "ides": ("state", "meta", "data"),
    "faudes": ("Generator", "Alphabet", "x"),
    "faudes-xml": ("Generator", "State", "x"),
}


# -- XML -----------------------------------------------------------------------------------------------------------

_ROOTS = {
    "wmod": 'Module xmlns="http://waters.sourceforge.net/xsd/module" Name="m"',
    "supremica": 'SupremicaProject name="m"',
    "faudes-xml": 'Generator name="m"',
    "ides": 'model version="2.1" type="FSA" id="m"',
}


def _entities(root: str) -> Cases:
    tag = root.split(maxsplit=1)[0]
    laughs = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 10))
    large = f'<!ENTITY l9 "{"x" * 100_000}">'
    for name, internal, inner in (
        ("a billion laughs", f'<!ENTITY l0 "ha">{laughs}', "&l9;"),
        ("a quadratic blow-up", large, "&l9;" * 100_000),
        ("an entity that holds itself", '<!ENTITY l9 "&l9;">', "&l9;"),
        ("a file as an entity", '<!ENTITY l9 SYSTEM "file:///etc/passwd">', "&l9;"),
        ("an address as an entity", '<!ENTITY l9 SYSTEM "http://127.0.0.1:9/a">', "&l9;"),
        ("a parameter entity", '<!ENTITY % p SYSTEM "file:///etc/passwd"> %p;', ""),
        ("a notation", '<!NOTATION n SYSTEM "n"><!ENTITY l9 SYSTEM "a" NDATA n>', ""),
    ):
        yield name, f"<!DOCTYPE {tag} [{internal}]><{root}>{inner}</{tag}>".encode()
        yield f"{name} in an attribute", f'<!DOCTYPE {tag} [{internal}]><{root} x="{inner}"></{tag}>'.encode()
    default = f'<!DOCTYPE {tag} [<!ATTLIST a x CDATA "{"x" * 100_000}">]>'
    yield "an attribute by default", f"{default}<{root}>{'<a/>' * 100_000}</{tag}>".encode()
    many = "".join(f'<!ATTLIST a x{k} CDATA "">' for k in range(1_000))
    yield "attributes by default", f"<!DOCTYPE {tag} [{many}]><{root}>{'<a/>' * 50_000}</{tag}>".encode()
    yield "an external document type", f'<!DOCTYPE {tag} SYSTEM "file:///etc/passwd"><{root}></{tag}>'.encode()
    yield "a tag without end", f"<{root}><{'a' * 500_000}".encode()
    yield "a tag with words and no end", f"<{root}><a {'a ' * 250_000}".encode()
    yield "a closing tag without end", f"<{root}></{'a' * 500_000}".encode()
    yield "an attribute that is one long word", f"<{root}><a {'a' * 500_000}/></{tag}>".encode()
    attributes = " ".join(f"a{k}='1'" for k in range(200_000))
    yield "many attributes", f"<{root} {attributes}></{tag}>".encode()
    yield "two million comments", f"<{root}>{'<!---->' * 1_000_000}</{tag}>".encode()
    for encoding in ("utf-7", "idna", "punycode", "unicode_escape", "undefined", "rot13", "zlib", "utf-16", "nonsense"):
        yield f"declared {encoding}", f'<?xml version="1.0" encoding="{encoding}"?><{root}></{tag}>'.encode()


# -- each format's own ---------------------------------------------------------------------------------------------


def _toml() -> Iterator[tuple[str, str]]:
    yield "a key of many parts", "a" + ".a" * _DEEP + " = 1"
    yield "a table of many parts", f"[a{'.a' * _DEEP}]"
    yield "many keys of many parts", "".join(f"k{k}{'.a' * 900} = 1\n" for k in range(1_000))
    yield "many keys of some parts", "".join(f"k{k}{'.a' * 90} = 1\n" for k in range(10_000))
    yield "quoted keys of many parts", '"a"' + ' . "a"' * _DEEP + " = 1"
    yield "lists in lists", f"a = {'[' * _DEEP}{']' * _DEEP}"
    yield "tables in tables", f"a = {'{a=' * _DEEP}1{'}' * _DEEP}"
    yield "many tables", "".join(f"[[a]]\nb.c = {k}\n" for k in range(_MANY))
    yield "one table twice", "[a]\n" * _DEEP
    yield "a number of many digits", "a = " + "9" * 1_000_000
    yield "a date that is none", "a = 9999-99-99T99:99:99"
    for huge in _HUGE:
        yield f"a variable of {huge}", f'[variables]\nv = {{ values = "0..{huge}" }}'
    yield (
        "variables of many values",
        "[variables]\n" + "".join(f'v{k} = {{ values = "0..999999" }}\n' for k in range(3)),
    )
    yield "events without number", "[events]\n" + "".join(f"e{k} = {{}}\n" for k in range(_MANY))
    unknown = "\n".join(f"q{k} -e{k}-> q{k}" for k in range(_MANY))
    yield "unknown events without number", _AUTOMATON.format(f'"""\n{unknown}\n"""')
    listed = ", ".join(f'"q{k} -e{k}-> q{k}"' for k in range(_MANY))
    yield "unknown events in a list", _AUTOMATON.format(f"[{listed}]")
    automaton = _AUTOMATON.format("[]")
    for name, expression in _expressions():
        condition = f'[[conditions]]\nkind = "spec"\ninvariant = "{expression}"'
        yield name, f'[variables]\nn = {{ values = "0..9" }}\n{automaton}\n{condition}'


_AUTOMATON = '[events]\nf = {{}}\n[automata.A]\nkind = "plant"\ninitial = "q0"\ntransitions = {}\n'


def _expressions() -> Iterator[tuple[str, str]]:
    yield "brackets in an expression", "(" * 40_000 + "true" + ")" * 40_000
    yield "signs in an expression", "-" * 90_000 + "n == 0"
    yield "not, often", "not " * 20_000 + "true"
    yield "a long sum", "n == " + " + ".join(["n"] * 20_000)
    yield "a long conjunction", " and ".join(["n < 3"] * 10_000)
    yield "a tower of powers", "n == 9 ** 9 ** 9 ** 9"
    yield "numbers that grow", "n == " + " * ".join(["999999999"] * 5_000)
    yield "ifs in ifs", "n == " + "1 if n == 1 else " * 5_000 + "0"


def _json() -> Iterator[tuple[str, str]]:
    yield "lists in lists", '{"a":' + "[" * _DEEP + "]" * _DEEP + "}"
    yield "tables in tables", '{"a":' * _DEEP + "1" + "}" * _DEEP
    yield "a number of many digits", '{"a": ' + "9" * 1_000_000 + "}"
    yield "numbers that are none", '{"a": NaN, "b": -Infinity, "c": 1e999}'
    yield "half a character", '{"name": "\\ud800"}'
    yield "a key twice, and another mistake", '{"a": {"b": 1, "b": 2}, "\n": 1}'
    yield "a key twice, of numbers that are none", '{"a": NaN, "a": Infinity}'
    yield "a key very often", "{" + ", ".join(['"a": 1'] * _DEEP) + "}"
    for huge in _HUGE:
        yield f"a variable of {huge}", json.dumps({"variables": {"v": {"values": f"0..{huge}"}}})
    unknown = [f"q{k} -e{k}-> q{k}" for k in range(_MANY)]
    automaton = {"kind": "plant", "initial": "q0", "transitions": unknown}
    yield "unknown events without number", json.dumps({"events": {}, "automata": {"A": automaton}})
    for name, expression in _expressions():
        condition = {"kind": "spec", "invariant": expression}
        model = {"variables": {"n": {"values": "0..9"}}, "automata": {"A": {"kind": "plant", "initial": "q"}}}
        yield name, json.dumps(model | {"conditions": [condition]})


def _cif() -> Iterator[tuple[str, str]]:
    plant = "plant p: {} location: initial; marked; end"
    for huge in _HUGE:
        yield f"a variable up to {huge}", plant.format(f"disc int[0..{huge}] n;")
        yield f"an input up to {huge}", f"input int[0..{huge}] n; " + plant.format("")
    yield "variables of many values", plant.format("".join(f"disc int[0..999999] v{k};" for k in range(3)))
    for path in ("../a.cif", "/etc/passwd", "a.cif", "", "a\\b.cif", "x" * 5_000):
        yield f"an import of {path[:20]!r}", f'import "{path}"; {plant.format("")}'
    yield "constants in a circle", "const int a = b; const int b = a; " + plant.format("disc int[0..a] n;")
    chain = "".join(f"const int c{k} = c{k + 1};" for k in range(_MANY)) + f"const int c{_MANY} = 1;"
    yield "constants in a long chain", chain + plant.format("disc int[0..c0] n;")
    yield (
        "expressions that double",
        "".join(f"alg int a{k} = a{k + 1} + a{k + 1};" for k in range(60))
        + ("alg int a60 = 1;" + plant.format("invariant a0 < 3;")),
    )
    groups = "".join(f"group def G{k}(): a: G{k + 1}(); b: G{k + 1}(); end " for k in range(60))
    yield "definitions that double", groups + "group def G60(): end x: G0();"
    yield "a definition that holds itself", "group def G(): a: G(); end x: G();"
    yield "groups in groups", "group g: " * 20_000 + "end " * 20_000
    yield "some groups in groups", "group g: " * 5_000 + "end " * 5_000
    yield "types in a circle", "type a = b; type b = a; " + plant.format("disc a n;")
    for name, inner in (
        ("brackets", "(" * _DEEP + "true" + ")" * _DEEP),
        ("some brackets", "(" * 2_000 + "true" + ")" * 2_000),
        ("not, often", "not " * 20_000 + "true"),
        ("a long conjunction", " and ".join(["true"] * 20_000)),
        ("a long sum", "1 < " + " + ".join(["1"] * 20_000)),
        ("a large number", "1 < " + "9" * 5_000),
        ("ifs", "if true: true else " * 5_000 + "true" + " end" * 5_000),
        ("brackets without an end", "(" * _DEEP),
    ):
        yield f"{name} in an expression", f"plant invariant {inner};" + plant.format("")
    yield "an enumeration of many", f"enum E = {', '.join(f'e{k}' for k in range(20_000))};" + plant.format("disc E e;")
    yield "a comment without end", plant.format("") + "/*" * 500_000
    yield "comments", "/* a */" * 200_000 + plant.format("")
    yield "unknown names without number", plant.format("".join(f"invariant a{k};" for k in range(_MANY)))
    yield "many automata", "".join(f"plant p{k}: location: initial; end " for k in range(_MANY))
    edges = "".join(f"location l{k}: edge e goto l{k};" for k in range(_MANY))
    yield "many locations", f"event e; plant p: {edges} end"


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
        ("arrays in arrays", b"\x91" * _DEEP), ("maps in maps", b"\x81\x00" * _DEEP), ("maps of maps", b"\x81" * _DEEP),
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
    for huge in (*_HUGE, "9" * 19, "1e9", "0x7fffffff", "2000001"):
        yield f"{huge} states", text.format(huge, "", "")
        yield f"marker state {huge}", text.format("2", huge, "")
        yield f"a transition of {huge}", text.format("2", "", f"0 1 {huge}")
        yield f"label {huge}", text.format("2", "", f"0 {huge} 1")
    yield "as many states as TCT takes", text.format("2000000", "*", "")
    yield "headings again and again", text.format("2", "", "") * 50_000
    yield "a transition that lacks a number", text.format("2", "", "0 1 1\n" * _DEEP + "0 1")
    yield "signs alone", text.format("2", "", "0 1 1\n0 1 +\n1 1 0\n")
    yield "comments without number", text.format("2", "", "# a\n" * 1_000_000)


def _wmod() -> Iterator[tuple[str, str]]:
    def module(constants: str = "", events: str = "", aliases: str = "", components: str = "") -> str:
        return (
            f'<Module xmlns="http://waters.sourceforge.net/xsd/module" Name="m"><ConstantAliasList>{constants}'
            f"</ConstantAliasList><EventDeclList>{events}</EventDeclList><EventAliasList>{aliases}</EventAliasList>"
            f"<ComponentList>{components}</ComponentList></Module>"
        )

    def constant(name: str, value: str) -> str:
        return (
            f'<ConstantAlias Name="{name}"><ConstantAliasExpression>{value}</ConstantAliasExpression></ConstantAlias>'
        )

    def number(value: object) -> str:
        return f'<IntConstant Value="{value}"/>'

    def binary(operator: str, a: str, b: str) -> str:
        return f'<BinaryExpression Operator="{operator}">{a}{b}</BinaryExpression>'

    def span(last: object) -> str:
        return binary("..", number(0), number(last))

    def variable(name: str, span: str, initial: str = number(0)) -> str:
        first = binary("==", f'<SimpleIdentifier Name="{name}"/>', initial)
        return (
            f'<VariableComponent Name="{name}"><VariableRange>{span}</VariableRange>'
            f"<VariableInitial>{first}</VariableInitial></VariableComponent>"
        )

    def automaton(name: str, nodes: str, edges: str) -> str:
        return (
            f'<SimpleComponent Kind="PLANT" Name="{name}"><Graph><NodeList><SimpleNode Name="q" Initial="true"/>{nodes}'
            f"</NodeList><EdgeList>{edges}</EdgeList></Graph></SimpleComponent>"
        )

    def edge(source: str, guard: str = "") -> str:
        guards = f"<GuardActionBlock><Guards>{guard}</Guards></GuardActionBlock>" if guard else ""
        return f'<Edge Source="{source}" Target="{source}"><LabelBlock>{name("e")}</LabelBlock>{guards}</Edge>'

    def name(text: str) -> str:
        return f'<SimpleIdentifier Name="{text}"/>'

    event = '<EventDecl Kind="CONTROLLABLE" Name="{}"><RangeList>{}</RangeList></EventDecl>'
    one = event.format("e", "")
    loop = '<ForeachComponent Name="i{}">{}{}</ForeachComponent>'
    for huge in _HUGE:
        yield f"a range up to {huge}", module(components=variable("v", span(huge)))
        yield f"a constant range up to {huge}", module(constant("c", span(huge)))
        yield f"events up to {huge}", module(events=event.format("e", span(huge)))
        yield f"a loop up to {huge}", module(components=loop.format(0, span(huge), automaton("A", "", "")))
    million = span(999_999)
    yield "many constant ranges", module("".join(constant(f"c{k}", million) for k in range(300)))
    yield "variables of many values", module(components="".join(variable(f"v{k}", million) for k in range(300)))
    yield "events by many ranges", module(events=event.format("e", million * 100))
    yield "events of many indexes", module(events=event.format("e", span(0) * 400 + span(9_999)))
    yield "billions of events", module(events=event.format("e", span(99_999) * 2))
    yield "no events by many ranges", module(events=event.format("e", million * 100 + span(-1)))
    nested = ""
    for k in range(99):
        nested = loop.format(k, million, nested)
    yield "loops in loops", module(components=nested)
    nested = automaton("A", "", "")
    for k in range(99):
        nested = loop.format(k, million if k % 2 else span(0), nested)
    yield "loops in loops around an automaton", module(components=nested)
    yield "constants in a circle", module(constant("a", name("b")) + constant("b", name("a")))
    yield "a constant of itself", module(constant("a", binary("+", name("a"), number(1))))
    chain = "".join(constant(f"c{k}", name(f"c{k + 1}")) for k in range(_MANY))
    yield "constants in a long chain", module(chain + constant(f"c{_MANY}", number(1)))
    doubled = "".join(constant(f"c{k}", binary("*", name(f"c{k - 1}"), name(f"c{k - 1}"))) for k in range(1, 60))
    yield "numbers that grow", module(constant("c0", number(2)) + doubled)
    aliases = "".join(
        f'<EventAlias Name="a{k}"><EventAliasExpression><List>{name(f"a{k - 1}") * 10}</List></EventAliasExpression>'
        "</EventAlias>"
        for k in range(1, 60)
    )
    first = f'<EventAlias Name="a0"><EventAliasExpression>{name("e")}</EventAliasExpression></EventAlias>'
    yield "lists of lists of events", module(events=one, aliases=first + aliases)
    many = event.format("e", span(49_999))
    listed = f"<EventAliasExpression><List>{name('e') * _MANY}</List></EventAliasExpression>"
    again = f'<EventAlias Name="a">{listed}</EventAlias>'
    yield "a list of many arrays", module(events=many, aliases=again)
    arrays = f'<Edge Source="q" Target="q"><LabelBlock>{name("e") * 1_000}</LabelBlock></Edge>'
    yield "an edge of many arrays", module(events=many, components=automaton("A", "", arrays))
    deep = number(1)
    for _ in range(450):
        deep = f'<UnaryExpression Operator="-">{deep}</UnaryExpression>'
    yield "signs in one another", module(constant("c", deep))
    yield "a guard in brackets", module(events=one, components=automaton("A", "", edge("q", deep)))
    indexed = number(1)
    for _ in range(450):
        indexed = f'<IndexedIdentifier Name="e">{indexed}</IndexedIdentifier>'
    yield "indexes in indexes", module(constant("c", indexed))
    groups = "".join(
        f'<SimpleNode Name="n{k}"/><GroupNode Name="g{k}"><NodeRef Name="n{k}"/><NodeRef Name="g{k - 1}"/></GroupNode>'
        for k in range(1, 10_000)
    )
    yield (
        "groups in groups",
        module(events=one, components=automaton("A", '<GroupNode Name="g0"/>' + groups, edge("g9999"))),
    )
    circle = '<GroupNode Name="g"><NodeRef Name="h"/></GroupNode><GroupNode Name="h"><NodeRef Name="g"/></GroupNode>'
    yield "groups in a circle", module(events=one, components=automaton("A", circle, edge("g")))
    next_ = '<UnaryExpression Operator="\'">{}</UnaryExpression>'
    guard = binary("&lt;", next_.format(name("v")), next_.format(name("w")))
    wide = variable("v", span(9_999)) + variable("w", span(9_999))
    yield "next values without number", module(events=one, components=wide + automaton("A", "", edge("q", guard)))
    guard = binary("==", next_.format(name("v")), binary("/", name("v"), name("w")))
    yield "a division by 0", module(events=one, components=wide + automaton("A", "", edge("q", guard)))
    parts = "".join(
        automaton(f"A{k}", "", edge("q", binary("==", next_.format(name("v")), number(1)))) for k in range(99)
    )
    yield "a variable of many", module(events=one, components=variable("v", span(9)) + parts)
    many = name("w0")
    for k in range(1, 70):
        many = binary("+", many, name(f"w{k}"))
    chosen = [edge("q", binary("==", many, number(0))), edge("q", binary("&gt;", many, number(0)))]
    for k, text in enumerate(chosen):
        action = binary("=", name("v"), number(k))
        chosen[k] = text.replace("</GuardActionBlock>", f"<Actions>{action}</Actions></GuardActionBlock>")
    single = "".join(variable(f"w{k}", span(0)) for k in range(70)) + variable("v", span(3))
    both = automaton("A", "", "".join(chosen)) + automaton("B", "", "".join(chosen))
    yield "guards about seventy variables", module(events=one, components=single + both)
    yield "many groups of nothing", module(components=automaton("A", '<GroupNode Name="g"/>' * _MANY, ""))
    yield (
        "an initial value to search for",
        module(
            components="".join(variable(f"v{k}", span(99_999), name(f"v{k + 1}")) for k in range(15))
            + variable("v15", span(9))
        ),
    )
    for path in ("../../etc/passwd", "/etc/passwd", "a"):
        yield f"an instance of {path}", module(components=f'<Instance Name="i" ModuleName="{path}"/>')
    uri = f'<?xml-stylesheet href="file:///etc/passwd"?>{module()}'
    yield "a style sheet", uri


def _supremica() -> Iterator[tuple[str, str]]:
    def project(states: str = "", events: str = "", transitions: str = "", n: int = 1) -> str:
        drawn = (
            f"<Events>{events}</Events><States>{states}</States><Transitions>{transitions}</Transitions></Automaton>"
        )
        listed = "".join(f'<Automaton name="A{k}" type="Plant">{drawn}' for k in range(n))
        return f'<SupremicaProject name="p">{listed}</SupremicaProject>'

    state, event = '<State id="{0}" name="q{0}" initial="true" forbidden="true"/>', '<Event id="{0}" label="e{0}"/>'
    step = '<Transition source="{0}" dest="{0}" event="{0}"/>'
    numbers = range(_MANY)
    yield "many initial and forbidden states", project("".join(map(state.format, numbers)), event.format(0))
    yield (
        "unknown states without number",
        project(state.format(-1), event.format(-1), "".join(map(step.format, numbers))),
    )
    yield "a state again and again", project(state.format(0) * _MANY, event.format(0) * _MANY)
    loose = '<Event id="{0}" label="e{0}" prioritized="false"/>'
    only = '<State id="{0}" name="q{0}" initial="true"/>'
    states = only.format(0) + "".join(f'<State id="{k}" name="{k}"/>' for k in range(1, 3_000))
    yield "loose events and states", project(states, "".join(map(loose.format, range(3_000))))
    tight = f'<Automaton name="T">{project("", "".join(map(event.format, range(3_000)))).partition("Plant")[2][2:]}'
    loosened = project(states, "".join(map(loose.format, range(3_000))))
    yield "loose events and states, tight elsewhere", loosened.replace("</SupremicaProject>", tight)
    yield "automata of one name", project(only.format(0), event.format(0), n=5_000).replace("A1", "A2")
    for huge in _HUGE:
        yield f"an id of {huge}", project(state.format(huge), event.format(huge), step.format(huge))


def _faudes() -> Iterator[tuple[str, str]]:
    text = "<Generator> g <Alphabet> a </Alphabet> <States> {} </States> <TransRel> {} </TransRel> {} </Generator>"
    for huge in _HUGE:
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


def _faudes_xml() -> Iterator[tuple[str, str]]:
    text = (
        "<Generator><Alphabet><Event name='a'/></Alphabet><StateSet>{}</StateSet>"
        "<TransitionRelation>{}</TransitionRelation></Generator>"
    )
    state = '<State id="{}"><Initial/></State>'
    for huge in _HUGE:
        yield f"states up to {huge}", text.format(state.format(1) + f'<Consecutive from="2" to="{huge}"/>', "")
        yield f"state {huge}", text.format(state.format(huge), "")
        yield f"a transition to {huge}", text.format(state.format(1), f'<Transition x1="1" event="a" x2="{huge}"/>')
    spans = "".join(f'<Consecutive from="{k}" to="{k}"/>' for k in range(2, 50_000))
    yield "many short ranges", text.format(state.format(1) + spans, "")
    yield "many states", text.format("".join(map(state.format, range(1, 50_000))), "")
    step = '<Transition x1="1" event="a" x2="1"><Timing/></Transition>'
    yield "many transitions with more in them", text.format(state.format(1), step.replace("Timing", "x") * 100_000)
    yield (
        "transitions of states by name",
        text.format(
            "".join(f'<State id="{k}" name="n{k}"><Initial/></State>' for k in range(1, 20_000)),
            "".join(f'<Transition x1="n{k}" event="a" x2="n{k}"/>' for k in range(1, 20_000)),
        ),
    )
    yield "an attribute without a value", text.format(f"<State {'a' * 500_000}/>", "")
    yield "attributes of nothing", text.format(f"<State {'=' * 500_000}/>", "")


def _ides() -> Iterator[tuple[str, str]]:
    text = '<model version="2.1" type="FSA" id="m"><data>{}</data></model>'
    state = '<state id="{}"><properties><initial/></properties><name>q</name></state>'
    numbers = range(_MANY)
    yield "many initial states of one name", text.format("".join(map(state.format, numbers)))
    step = '<transition id="0" source="{0}" target="{0}" event="{0}"/>'
    yield "unknown states without number", text.format("".join(map(step.format, numbers)))
    event = '<event id="{0}"><properties/><name>e</name></event>'
    yield "many events of one name", text.format("".join(map(event.format, numbers)))
    yield "layouts", text.format("") + "<meta>" * 100_000
    yield "layouts and an end", text.format("") + "<meta <" * 100_000 + "</meta>"
    yield "a layout without end", text.format("").replace("</model>", "<meta " + "a" * 1_000_000)
    for huge in _HUGE:
        yield f"an id of {huge}", text.format(state.format(huge) + event.format(huge) + step.format(huge))


def _desuma() -> Iterator[tuple[str, str]]:
    for huge in (*_HUGE, "²", "٣"):
        yield f"{huge} states", f"{huge}\n\na\t1\t0\n"
        yield f"{huge} transitions", f"1\n\na\t1\t{huge}\ne\ta\n"
    unknown = "".join(f"s{k}\t0\t1\ne{k}\tt{k}\n" for k in range(_MANY))
    yield "unknown states without number", f"{_MANY}\n{unknown}"
    yield "states that announce what others have", f"{_MANY}\n" + f"s\t0\t{_MANY}\n" * _MANY
    yield "a state again and again", f"{_MANY}\n" + "s\t0\t0\n" * _MANY


def _dot() -> Iterator[tuple[str, str]]:
    group = "{" + " ".join(f"n{k}" for k in range(2_000)) + "}"
    yield (
        "groups of nodes with edges between all",
        f'digraph {{ i [shape=point]; i -> n0; {group} -> {group} [label="a"] }}',
    )
    yield "edges between groups, again and again", "digraph {" + " -> ".join([group] * 50) + ' [label="a"] }'
    yield "a chain of groups", "digraph {" + " -> ".join(["{}"] * _DEEP) + ' [label="a"] }'
    yield "groups in groups", "digraph {" + "{ a " * _DEEP + "}" * _DEEP + "}"
    nested = "{ a " * 3_000 + "} -> b " * 3_000
    yield "groups in groups with edges", f'digraph {{ edge [label="x"]; {nested} }}'
    defaults = "".join(f'{{ node [a{k}="{k}" label="{k}"] ' for k in range(5_000))
    yield "defaults in groups", "digraph {" + defaults + "}" * 5_001
    yield "a comment without end", "digraph { " + "/*" * 500_000
    yield "quotes without end", 'digraph { "' + "\\" * 1_000_000
    yield "quotes joined", "digraph { " + " + ".join(['"a"'] * _DEEP) + " }"
    yield "HTML in HTML", "digraph { a -> b [label=" + "<" * _DEEP + ">" * _DEEP + "] }"
    yield "HTML without end, often", "digraph { " + "a [label=<b>] " * 50_000 + "<"
    yield "entities", 'digraph { a -> b [label="' + "&#x10ffff;&#99999999;&amp" * 20_000 + '"] }'
    yield (
        "many labels",
        'digraph { i [shape=point]; i -> a; a -> a [label="' + ",".join(f"e{k}" for k in range(50_000)) + '"] }',
    )
    yield "edges without labels", "digraph { " + "a -> b " * 50_000 + "}"
    yield "hash signs", "digraph {" + "\n#" * 500_000
    for huge in _HUGE:
        yield (
            f"peripheries {huge}",
            f'digraph {{ i [shape=point]; i -> a; a [peripheries={huge}]; a -> a [label="e"] }}',
        )


def _mermaid() -> Iterator[tuple[str, str]]:
    head = "stateDiagram-v2\n[*] --> a\n"
    yield "codes that are none", head + "a --> b: #²; #٣; #1114112; #55296; #99999999; #x; #0;\n"
    yield "a title without end", '---\ntitle: "' + "\\" * 1_000_001 + "\n---\n" + head
    yield "front matter without end", "---\n" + "title: a\n" * _DEEP
    yield "states in states", head + "state a {\n" * _DEEP
    yield "notes without end", head + "note right of a\n" * _DEEP
    yield "descriptions without end", head + "accDescr {\n" * _DEEP
    yield "notes", head + "note right of a\nend note\n" * _DEEP
    yield "arrows without end", head + "a" + " --> a" * _DEEP
    yield "arrows with no spaces", head + "a" + "-->a" * _DEEP
    yield "classes", head + "a" + ":::a" * _DEEP
    yield "a class of many", head + "class " + ",".join(f"s{k}" for k in range(_DEEP)) + " marked"
    yield "spaces", head + "state" + " " * 1_000_000 + "a" + " " * 1_000_000 + "b"
    yield "spaces before a sign", head + ("a" + " " * 10_000 + "<\n") * 100
    yield "dashes", head + "a" + "-" * 1_000_000 + ">"
    yield "quotes", head + 'state "' + '" as "' * _DEEP
    yield "codes", head + "a --> b: " + "#" * 1_000_000 + ";"
    yield "breaks", head + "a --> b: " + "<br" + " " * 1_000_000
    yield "many labels", head + "a --> a: " + ",".join(f"e{k}" for k in range(50_000))
    yield "unknown lines", head + "?\n" * _DEEP


_OWN: Mapping[str, Callable[[], Iterator[tuple[str, str | bytes]]]] = {
    "toml": _toml, "json": _json, "cif": _cif, "tct": _tct, "ads": _ads, "wmod": _wmod, "supremica": _supremica,
    "faudes": _faudes, "faudes-xml": _faudes_xml, "ides": _ides, "desuma": _desuma, "dot": _dot, "mermaid": _mermaid,
}  # fmt: skip


# -- the process ---------------------------------------------------------------------------------------------------


def main(name: str) -> None:
    """Read the hostile files of the format called ``name``; print each one's name, its seconds, and what went wrong."""
    format = format_named(name)
    for seed in small_seeds(format):  # imports what is imported when it is needed
        check(seed, name)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGALRM, _too_long)
    for case, data in cases(format):
        print(case, end="\t", flush=True)
        begin = perf_counter()
        signal.setitimer(signal.ITIMER_REAL, SECONDS)
        try:
            read(data, name)
            wrong = ""
        except Exception as error:  # whatever it is, it is what this process is here to tell
            where = [f"{frame.filename}:{frame.lineno}" for frame in extract_tb(error.__traceback__)[-3:]]
            wrong = f"{type(error).__name__}: {str(error)[:200]!r} at {' < '.join(reversed(where))}"
        signal.setitimer(signal.ITIMER_REAL, 0)
        print(f"{perf_counter() - begin:.2f}\t{wrong}", flush=True)


def _too_long(signal_number: int, frame: object) -> None:
    raise TimeoutError(f"more than {SECONDS} seconds")


if __name__ == "__main__":
    main(sys.argv[1])
