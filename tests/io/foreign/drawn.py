"""What the tests of text formats share: automata with odd names, the table beside a file, and damaged files."""

from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import strategies as st

from thenar.errors import InputError
from thenar.io.foreign.assemble import assembled, columns
from thenar.io.foreign.written import Names, Written
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import ExtendedAutomaton
from thenar.testing.random_models import random_alphabet, random_automaton

MODELS = Path(__file__).resolve().parents[4] / "shared" / "models"
Any = Automaton | ExtendedAutomaton
Facts = tuple[object, ...]

_LETTERS = "ab1_-.:;!?\"'\\/<>&#%|*+=$@~^`(){}[]äß√持"
_MORE = _LETTERS + ", \t\n\x07\x85\u2028\ud800"  # what states may be called, and events may not

_LIKELY = ["start", "graph", "end", "state", "EVENTS", "s0", "e0", "0", "-1", "init"]


def needs(folder: str) -> pytest.MarkDecorator:
    """Skip, visibly, where a folder of models of others is missing."""
    there = (MODELS / folder).is_dir()
    return pytest.mark.skipif(not there, reason=f"no {MODELS / folder}: models of others are no part of the project")


def odd_automaton(rng: Random, *, nondeterministic: bool = True, entries: bool = True) -> Any:
    """Draw an automaton whose names and properties try the limits of a format."""
    plain = random_automaton(rng, random_alphabet(rng, max_events=6), max_states=6, name=_word(rng, _LETTERS + " "))
    events, states = list(plain.alphabet), [plain.states[q] for q in range(plain.n_states)]
    if rng.random() < 0.7:
        events = [Event(name, rng.random() < 0.6) for name in _words(rng, _LETTERS, len(events))]
    if rng.random() < 0.4:
        events = [replace(e, observable=rng.random() < 0.6, forcible=rng.random() < 0.3) for e in events]
        events = [replace(e, meaning=_word(rng, _MORE)) if rng.random() < 0.2 else e for e in events]
    if rng.random() < 0.7:
        states = _words(rng, _MORE if rng.random() < 0.5 else _LETTERS, len(states))
    s, e, t = columns(plain)
    initial = [rng.randrange(len(states))]
    if nondeterministic and rng.random() < 0.3:
        more = rng.randint(1, 4)
        s, t = (np.append(c, [rng.randrange(len(states)) for _ in range(more)]) for c in (s, t))
        e = np.append(e, [rng.randrange(len(events)) for _ in range(more)])
    if entries and rng.random() < 0.2:
        initial.append(rng.randrange(len(states)))
    meaning = rng.choice(["", "", "it works & rests"])
    return assembled(plain.name, Alphabet(events), states, initial, plain.marked, s, e, t, meaning=meaning)


def _word(rng: Random, letters: str) -> str:
    return "".join(rng.choices(letters, k=rng.choice([0, 1, 1, 2, 3, 5])))


def _words(rng: Random, letters: str, n: int) -> list[str]:
    """Draw ``n`` different words, none of them empty."""
    words: dict[str, None] = {}
    while len(words) < n:
        words[
            _word(rng, letters) or rng.choice(["start", "graph", "end", "state", "EVENTS", "s0", "e0", "0", "-1"])
        ] = None
    return list(words)


def text(written: Written) -> bytes:
    """Return the file."""
    return b"".join(piece.encode() if isinstance(piece, str) else piece for piece in written.chunks)


def with_names(automaton: Any, names: object) -> Any:
    """Return ``automaton`` with the names of the table beside its file."""
    if names is None:
        return automaton
    assert isinstance(names, Names)
    s, e, t = columns(automaton)
    place = {label: k for k, (label, _) in enumerate(names.events)}
    number = np.array([place[event.name] for event in automaton.alphabet], np.int64)
    sigma = Alphabet(event for _, event in names.events)
    assert len(names.states) == len(automaton.marked)
    return assembled(automaton.name, sigma, names.states, entries(automaton), automaton.marked, s, number[e], t)


def entries(automaton: Any) -> list[int]:
    """Return the initial states."""
    if isinstance(automaton, Automaton):
        return [] if automaton.is_empty else [automaton.initial]
    return [q for q, first in enumerate(automaton.initial) if first]


def facts(automaton: Any) -> Facts:
    """Return all that is to be the same in two automata but name and meaning."""
    events = [(e, e.meaning) for e in automaton.alphabet]
    names = [automaton.states[q] for q in range(len(automaton.marked))]
    edges = {
        (names[s], automaton.alphabet[e].name, names[t])
        for s, e, t in zip(*(c.tolist() for c in columns(automaton)), strict=True)
    }
    marked = frozenset(q for q, m in zip(names, automaton.marked, strict=True) if m)
    first = frozenset(names[q] for q in entries(automaton))
    return tuple(events), tuple(names), edges, marked, first


@st.composite
def damaged(draw: st.DrawFn, files: list[bytes], words: list[bytes]) -> bytes:
    """A file of ``files``, cut off, or with some bytes lost, doubled, changed or in front of one of ``words``."""
    data = bytearray(draw(st.sampled_from(files)))
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        length = draw(st.integers(0, 30))
        kind = draw(st.sampled_from(["cut", "lose", "double", "change", "insert", "move"]))
        if kind == "cut":
            del data[at:]
        elif kind == "lose":
            del data[at : at + length]
        elif kind == "double":
            data[at:at] = data[at : at + length]
        elif kind == "change":
            data[at : at + 1] = draw(st.binary(max_size=2))
        elif kind == "insert":
            data[at:at] = draw(st.sampled_from(words))
        else:
            piece = data[at : at + length]
            del data[at : at + length]
            to = draw(st.integers(0, len(data)))
            data[to:to] = piece
    return bytes(data)


def assert_read_or_refused(loads: object, data: bytes) -> None:
    """Only an error of ours, with the file's name, may come out."""
    try:
        loads(data, "file.x")  # type: ignore[operator]
    except InputError as error:
        assert "file.x" in str(error)  # noqa: PT017
