"""HOA: what is written follows the grammar, and says what the automaton says."""

import re
from dataclasses import dataclass, field
from random import Random

import pytest
from tests.io.foreign.drawn import entries, odd_automaton, text

from thenar.errors import InputError
from thenar.io.foreign import hoa
from thenar.io.foreign.assemble import columns
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.extended import ExtendedAutomaton

_TOKEN = re.compile(
    r'\s*(?:(?P<string>"(?:[^"\\]|\\.)*")|(?P<mark>--(?:BODY|END|ABORT)--)|(?P<header>[a-zA-Z_][0-9a-zA-Z_-]*:)'
    r"|(?P<word>[a-zA-Z_][0-9a-zA-Z_-]*)|(?P<alias>@[0-9a-zA-Z_-]+)|(?P<number>0|[1-9][0-9]*)|(?P<sign>[][{}()!&|]))",
    re.DOTALL,
)


@dataclass
class Parsed:
    """A file of the part of HOA v1 that has state-based acceptance and explicit labels."""

    headers: dict[str, list[list[str]]] = field(default_factory=dict)
    aliases: dict[str, frozenset[int]] = field(default_factory=dict)  # the propositions that are true
    states: list[tuple[str, bool]] = field(default_factory=list)
    edges: list[tuple[int, int, int]] = field(default_factory=list)


def parsed(data: bytes) -> Parsed:
    """Return ``data``, which must follow the grammar of https://adl.github.io/hoaf/."""
    content, tokens, at = data.decode().rstrip(), [], 0
    while at < len(content):
        match = _TOKEN.match(content, at)
        assert match, content[at : at + 40]
        tokens.append((match.lastgroup or "", match[match.lastgroup or 0]))
        at = match.end()
    result, k = Parsed(), 0
    assert tokens[:2] == [("header", "HOA:"), ("word", "v1")]
    while tokens[k] != ("mark", "--BODY--"):
        kind, header = tokens[k]
        assert kind == "header"
        end = next(i for i in range(k + 1, len(tokens)) if tokens[i][0] in ("header", "mark"))
        result.headers.setdefault(header, []).append([value for _, value in tokens[k + 1 : end]])
        k = end
    propositions = int(result.headers["AP:"][0][0])
    for name, *terms in result.headers.get("Alias:", []):
        words = "".join(terms).split("&")
        assert [int(word.lstrip("!")) for word in words] == list(range(propositions))  # each is true or false
        result.aliases[name] = frozenset(int(word) for word in words if word[0] != "!")
    k += 1
    while tokens[k] != ("mark", "--END--"):
        if tokens[k] == ("header", "State:"):
            assert (tokens[k + 1][0], tokens[k + 2][0]) == ("number", "string")
            assert int(tokens[k + 1][1]) == len(result.states)
            accepting = [value for _, value in tokens[k + 3 : k + 6]] == ["{", "0", "}"]
            result.states.append((_unquoted(tokens[k + 2][1]), accepting))
            k += 6 if accepting else 3
        else:
            (_, opening), (kind, alias), (_, closing), (number, target) = tokens[k : k + 4]
            assert (opening, kind, closing, number) == ("[", "alias", "]", "number")
            (proposition,) = result.aliases[alias]
            result.edges.append((len(result.states) - 1, proposition, int(target)))
            k += 4
    assert k == len(tokens) - 1
    return result


def _unquoted(value: str) -> str:
    return re.sub(r"\\(.)", r"\1", value[1:-1], flags=re.DOTALL)


def test_what_is_written_follows_the_grammar_and_says_the_automaton() -> None:
    rng = Random(7)
    for _ in range(1000):
        a = odd_automaton(rng)
        states = [a.states[q] for q in range(len(a.marked))]
        if any("\ud800" in name for name in states):
            with pytest.raises(InputError, match="half of a character"):
                hoa.dumps(a)
            continue
        found = parsed(text(hoa.dumps(a)))
        rows = sorted(set(zip(*(c.tolist() for c in columns(a)), strict=True)))
        events = list(a.alphabet)
        assert found.states == list(zip(states, map(bool, a.marked), strict=True))
        assert found.edges == rows
        assert found.headers["States:"] == [[str(len(states))]]
        assert [int(q) for (q,) in found.headers["Start:"]] == entries(a)
        assert [_unquoted(name) for name in found.headers["AP:"][0][1:]] == [e.name for e in events]
        assert found.headers["Acceptance:"] == [["1", "Inf", "(", "0", ")"]]
        assert found.headers["controllable-AP:"][0] == [str(k) for k, e in enumerate(events) if e.controllable]
        assert ("deterministic" in found.headers["properties:"][0]) == isinstance(a, Automaton)


def test_the_empty_automaton_has_no_start() -> None:
    found = parsed(text(hoa.dumps(Automaton.empty(Alphabet(["a"])))))
    assert (found.states, "Start:" in found.headers) == ([], False)


def test_more_than_a_thousand_events_and_guards_are_refused() -> None:
    with pytest.raises(InputError, match=r"1,001 events"):
        hoa.dumps(Automaton.empty(Alphabet(f"e{k}" for k in range(1001))))
    with pytest.raises(InputError, match=r"edge 1 .* no guards and updates"):
        hoa.dumps(ExtendedAutomaton.from_edges("A", [("p", "a", "q", "n < 2")], initial="p"))
