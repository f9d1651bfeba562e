"""Hostile files of the formats that are languages: our own two, and CIF."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping

__all__ = ["DEEP", "HUGE", "MANY", "OWN"]

HUGE = ("1000000000", "1000000000000000000", "9" * 30, "-1")
MANY = 5_000
DEEP = 100_000


def _toml() -> Iterator[tuple[str, str]]:
    yield "a key of many parts", "a" + ".a" * DEEP + " = 1"
    yield "a table of many parts", f"[a{'.a' * DEEP}]"
    yield "many keys of many parts", "".join(f"k{k}{'.a' * 900} = 1\n" for k in range(1_000))
    yield "many keys of some parts", "".join(f"k{k}{'.a' * 90} = 1\n" for k in range(10_000))
    yield "quoted keys of many parts", '"a"' + ' . "a"' * DEEP + " = 1"
    yield "lists in lists", f"a = {'[' * DEEP}{']' * DEEP}"
    yield "tables in tables", f"a = {'{a=' * DEEP}1{'}' * DEEP}"
    yield "many tables", "".join(f"[[a]]\nb.c = {k}\n" for k in range(MANY))
    yield "one table twice", "[a]\n" * DEEP
    yield "a number of many digits", "a = " + "9" * 1_000_000
    broken = '0={e=false}\nc={}\n[a]\nd=""\ni=""\nm=[""]\ns=["",""]\ns=1[a][l=""\nd 4]'
    yield "a key twice, and lines that look like one key", broken
    yield "a date that is none", "a = 9999-99-99T99:99:99"
    for huge in HUGE:
        yield f"a variable of {huge}", f'[variables]\nv = {{ values = "0..{huge}" }}'
    yield (
        "variables of many values",
        "[variables]\n" + "".join(f'v{k} = {{ values = "0..999999" }}\n' for k in range(3)),
    )
    yield "events without number", "[events]\n" + "".join(f"e{k} = {{}}\n" for k in range(MANY))
    unknown = "\n".join(f"q{k} -e{k}-> q{k}" for k in range(MANY))
    yield "unknown events without number", _AUTOMATON.format(f'"""\n{unknown}\n"""')
    listed = ", ".join(f'"q{k} -e{k}-> q{k}"' for k in range(MANY))
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
    yield "lists in lists", '{"a":' + "[" * DEEP + "]" * DEEP + "}"
    yield "tables in tables", '{"a":' * DEEP + "1" + "}" * DEEP
    yield "a number of many digits", '{"a": ' + "9" * 1_000_000 + "}"
    yield "numbers that are none", '{"a": NaN, "b": -Infinity, "c": 1e999}'
    yield "half a character", '{"name": "\\ud800"}'
    yield "a key twice, and another mistake", '{"a": {"b": 1, "b": 2}, "\n": 1}'
    yield "a key twice, of numbers that are none", '{"a": NaN, "a": Infinity}'
    yield "a key very often", "{" + ", ".join(['"a": 1'] * DEEP) + "}"
    for huge in HUGE:
        yield f"a variable of {huge}", json.dumps({"variables": {"v": {"values": f"0..{huge}"}}})
    unknown = [f"q{k} -e{k}-> q{k}" for k in range(MANY)]
    automaton = {"kind": "plant", "initial": "q0", "transitions": unknown}
    yield "unknown events without number", json.dumps({"events": {}, "automata": {"A": automaton}})
    for name, expression in _expressions():
        condition = {"kind": "spec", "invariant": expression}
        model = {"variables": {"n": {"values": "0..9"}}, "automata": {"A": {"kind": "plant", "initial": "q"}}}
        yield name, json.dumps(model | {"conditions": [condition]})


def _cif() -> Iterator[tuple[str, str]]:
    plant = "plant p: {} location: initial; marked; end"
    for huge in HUGE:
        yield f"a variable up to {huge}", plant.format(f"disc int[0..{huge}] n;")
        yield f"an input up to {huge}", f"input int[0..{huge}] n; " + plant.format("")
    yield "variables of many values", plant.format("".join(f"disc int[0..999999] v{k};" for k in range(3)))
    for path in ("../a.cif", "/etc/passwd", "a.cif", "", "a\\b.cif", "x" * 5_000):
        yield f"an import of {path[:20]!r}", f'import "{path}"; {plant.format("")}'
    yield "constants in a circle", "const int a = b; const int b = a; " + plant.format("disc int[0..a] n;")
    chain = "".join(f"const int c{k} = c{k + 1};" for k in range(MANY)) + f"const int c{MANY} = 1;"
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
        ("brackets", "(" * DEEP + "true" + ")" * DEEP),
        ("some brackets", "(" * 2_000 + "true" + ")" * 2_000),
        ("not, often", "not " * 20_000 + "true"),
        ("a long conjunction", " and ".join(["true"] * 20_000)),
        ("a long sum", "1 < " + " + ".join(["1"] * 20_000)),
        ("a large number", "1 < " + "9" * 5_000),
        ("ifs", "if true: true else " * 5_000 + "true" + " end" * 5_000),
        ("brackets without an end", "(" * DEEP),
    ):
        yield f"{name} in an expression", f"plant invariant {inner};" + plant.format("")
    yield "an enumeration of many", f"enum E = {', '.join(f'e{k}' for k in range(20_000))};" + plant.format("disc E e;")
    yield "a comment without end", plant.format("") + "/*" * 500_000
    yield "comments", "/* a */" * 200_000 + plant.format("")
    yield "unknown names without number", plant.format("".join(f"invariant a{k};" for k in range(MANY)))
    yield "many automata", "".join(f"plant p{k}: location: initial; end " for k in range(MANY))
    edges = "".join(f"location l{k}: edge e goto l{k};" for k in range(MANY))
    yield "many locations", f"event e; plant p: {edges} end"


OWN: Mapping[str, Callable[[], Iterator[tuple[str, str]]]] = {"toml": _toml, "json": _json, "cif": _cif}
