"""Random automata with names, flags and shapes that files of other tools find hard to say, and how to compare them."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import TypeAlias

import thenar
from thenar.io.foreign.written import Names, ProblemNames
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import Edge, ExtendedAutomaton

MODELS = Path(__file__).resolve().parents[4] / "shared" / "models"
Any: TypeAlias = Automaton | ExtendedAutomaton
WORDS = [
    *(
        "start",
        "a b",
        "über",
        "x&y",
        "x&amp;y",
        "<tag>",
        '"quoted"',
        "it's",
        "#3",
        "n#1",
        "+C+",
        "%rest",
        "true",
        "inf",
    ),
    *("0x1f", "-3", "1.5", "=b=", "State size", "a,b", "σ", "\u00a0", " lead", "\u2028", "States", "</States>", "2"),
]


def odd_automaton(rng: Random, *, nondeterministic: bool = True) -> Any:
    """Draw an automaton of 0 to 6 states; one of three has plain names, one of four is nondeterministic."""
    n = rng.randrange(7)
    plain = rng.random() < 1 / 3
    words = rng.sample([w for w in WORDS if not any(c.isspace() or c == "," for c in w)], rng.randint(0, 5))
    names = [str(k) for k in range(1, 6)] if plain else words
    events = [
        Event(e, int(e) % 2 == 1) if plain else Event(e, rng.random() < 0.5, rng.random() < 0.5, rng.random() < 0.5)
        for e in names
    ]
    states = tuple(map(str, range(n))) if plain else tuple(rng.sample(WORDS, n))
    rows = {(q, e): rng.randrange(n) for q in range(n) for e in range(len(events)) if rng.random() < 0.4}
    marked = tuple(rng.random() < 0.5 for _ in range(n))
    name = rng.choice(["", "G", "two words", 'a "<&>" b', "DES"])
    if nondeterministic and n and rng.random() < 0.25:
        edges = {Edge(q, e, t) for (q, e), t in rows.items()}
        edges |= {Edge(rng.randrange(n), rng.randrange(len(events)), rng.randrange(n)) for _ in range(3) if events}
        initial = tuple(q == 0 or rng.random() < 0.2 for q in range(n))
        ordered = sorted(edges, key=lambda edge: (edge.source, edge.event, edge.target))
        return ExtendedAutomaton(name, Alphabet(events), states, initial, marked, tuple(ordered))
    if not n:
        return Automaton.empty(Alphabet(events), name)
    return Automaton.from_transitions(
        [(states[q], events[e].name, states[t]) for (q, e), t in rows.items()],
        initial=states[0 if plain else rng.randrange(n)],
        marked=[q for q, mark in zip(states, marked, strict=True) if mark],
        events=Alphabet(events),
        alphabet=[e.name for e in events],
        states=states,
        name=name,
    )


def said(automaton: Any) -> tuple[object, ...]:
    """Return what ``automaton`` says, whatever the order of its states: a value to compare."""
    extended = automaton if isinstance(automaton, ExtendedAutomaton) else ExtendedAutomaton.from_automaton(automaton)
    q = extended.states
    return (
        tuple(extended.alphabet),
        frozenset(zip(q, extended.initial, extended.marked, strict=True)),
        frozenset((q[e.source], extended.alphabet[e.event].name, q[e.target]) for e in extended.edges),
    )


def several_starts(automaton: Any) -> bool:
    """Return whether ``automaton`` has several initial states."""
    return isinstance(automaton, ExtendedAutomaton) and sum(automaton.initial) > 1


def restored(read: Any, names: Names | ProblemNames | None) -> ExtendedAutomaton:
    """Return what was read of a file, with the names that its writer kept."""
    a = read if isinstance(read, ExtendedAutomaton) else ExtendedAutomaton.from_automaton(read)
    if names is None:
        return a
    assert isinstance(names, Names)
    n = len(names.states)
    place = {label: k for k, (label, _) in enumerate(names.events)}
    edges = (Edge(e.source, place[a.alphabet[e.event].name], e.target) for e in a.edges if max(e.source, e.target) < n)
    alphabet = Alphabet(event for _, event in names.events)
    return ExtendedAutomaton(a.name, alphabet, names.states, a.initial[:n], a.marked[:n], tuple(edges))


def through_a_file(automaton: Any, path: Path, format_: str | None = None) -> Any:
    """Write ``automaton`` to ``path``, with the table of names beside it, and read it again."""
    thenar.save(automaton, path, format_)
    model = thenar.load(path)
    (again,) = model.plants
    return again
