"""From transitions as people write them to an automaton; collects every mistake before it complains."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from thenar.errors import InputError, Mistake, ModelError, did_you_mean
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.names import Listed

__all__ = ["Parts", "Unknown", "assemble", "build_automaton", "check_parts", "parse_arrows", "place_in_words"]

Transition = tuple[str, str, str]
KeyPath = tuple[str | int, ...]
Complaint = tuple[KeyPath, str]  # path to the culprit inside the automaton, and what is wrong

_LOOKS = 100_000  # at known names for the one nearest to an unknown one; about half a second
_ARROW = re.compile(r"\s+-(\S+)->\s+")


def parse_arrows(text: str) -> list[Transition]:
    """Read ``"idle -approach-> near -lift,pull-> held"`` as transitions; one arrow may carry several events.

    >>> parse_arrows("idle -approach-> near -lift,pull-> held")
    [('idle', 'approach', 'near'), ('near', 'lift', 'held'), ('near', 'pull', 'held')]
    """
    states_and_labels = _ARROW.split(text.strip())
    states, labels = states_and_labels[::2], states_and_labels[1::2]
    events = [event for label in labels for event in label.split(",")]
    if len(states) < 2 or not all(states) or not all(events) or any("->" in s for s in states):
        raise InputError(f"cannot read {text!r} as transitions; write 'state -event-> state', spaces around the arrow")
    arrows = zip(pairwise(states), labels, strict=True)
    return [(s, event, t) for (s, t), label in arrows for event in label.split(",")]


def build_automaton(
    cls: type[Automaton],
    transitions: Iterable[str | Transition],
    *,
    initial: str,
    marked: Iterable[str],
    events: Alphabet | Iterable[Event | str] | None,
    uncontrollable: Iterable[str],
    alphabet: Iterable[str],
    states: Iterable[str] | None,
    name: str,
    meaning: str,
) -> Automaton:
    """Do the work of :meth:`Automaton.from_transitions`."""
    listed = {"transitions": transitions, "marked": marked, "uncontrollable": uncontrollable, "alphabet": alphabet}
    for what, entries in {**listed, "states": states}.items():
        if isinstance(entries, str):
            raise InputError(f"{what} is a list, not the text {entries!r}")
    parts = Parts(transitions, initial, marked, alphabet, states)
    uncontrollable = list(uncontrollable)
    free = set(uncontrollable)
    if events is None:
        known = Alphabet(Event(e, controllable=e not in free) for e in dict.fromkeys(parts.event_names()))
    else:
        given = events if isinstance(events, Alphabet) else Alphabet(events)
        known = given
        for e in dict.fromkeys(uncontrollable):
            if e in known and known[e].controllable:
                parts.complaints.append((("uncontrollable",), f"event {e!r} is controllable in the given events"))
    parts.complaints += [
        (("uncontrollable",), f"unknown event {e!r}{did_you_mean(e, known.names)}")
        for e in dict.fromkeys(uncontrollable)
        if e not in known
    ]
    complaints = [*parts.complaints, *check_parts(parts, known)]
    if complaints:
        raise ModelError([Mistake(_place(name, path), what) for path, what in complaints])
    return assemble(cls, parts, known, name, meaning)


class Parts:
    """What an author wrote about one automaton, arrows read, mistakes noted."""

    def __init__(
        self,
        transitions: Iterable[str | Sequence[str]],
        initial: str,
        marked: Iterable[str],
        alphabet: Iterable[str] = (),
        states: Iterable[str] | None = None,
    ) -> None:
        self.complaints: list[Complaint] = []
        self.triples: list[tuple[int, Transition]] = []  # with the position of the text they come from
        for k, item in enumerate(transitions):
            if isinstance(item, str):
                try:
                    self.triples += [(k, triple) for triple in parse_arrows(item)]
                except InputError as error:
                    self.complaints.append((("transitions", k), str(error)))
            elif len(item) == 3 and all(isinstance(part, str) for part in item):
                self.triples.append((k, (item[0], item[1], item[2])))
            else:
                self.complaints.append((("transitions", k), f"{item!r} is no triple (state, event, state)"))
        self.initial, self.marked, self.alphabet = initial, list(marked), list(alphabet)
        self.declared = None if states is None else list(states)

    def event_names(self) -> Iterable[str]:
        """Yield the event of each transition, and the rest of the alphabet; names repeat."""
        yield from (e for _, (_, e, _) in self.triples)
        yield from self.alphabet

    def state_names(self) -> list[str]:
        """Return the states as declared, else the initial one and those mentioned, in that order."""
        if self.declared is not None:
            return list(dict.fromkeys(self.declared))
        mentioned = (q for _, (s, _, t) in self.triples for q in (s, t))
        return list(dict.fromkeys((self.initial, *mentioned) if self.initial else mentioned))


class Unknown:
    """Says that a name is unknown, and offers the nearest known one, or ``otherwise`` another way out.

    To find that one takes a look at every known name, so it is done once a name, and only while the looks
    are few: a file whose names are all wrong is told so without delay.

    >>> Unknown("event", ["lift", "slip"])("slop")
    "unknown event 'slop'; did you mean 'slip'?"
    """

    def __init__(self, kind: str, known: Sequence[str], otherwise: str = "") -> None:
        self._kind, self._known, self._otherwise = kind, known, otherwise
        self._searches = max(1, _LOOKS // max(1, len(known)))
        self._said: dict[str, str] = {}

    def __call__(self, name: str) -> str:
        """Return the sentence about ``name``."""
        if name not in self._said:
            near = did_you_mean(name, self._known) if len(self._said) < self._searches else ""
            self._said[name] = f"unknown {self._kind} {name!r}{near or self._otherwise}"
        return self._said[name]


def check_parts(parts: Parts, known: Alphabet, unknown_event: Unknown | None = None) -> list[Complaint]:
    """Return everything that is wrong with ``parts`` when ``known`` are the events that exist.

    Whoever checks many automata against the same events gives the same ``unknown_event`` to all of them.
    """
    complaints: list[Complaint] = []
    states = parts.state_names()
    state_set = set(states)
    unknown_state = Unknown("state", states)
    unknown_event = unknown_event or Unknown("event", known.names)
    for what, listed in (("states", parts.declared or []), ("alphabet", parts.alphabet), ("marked", parts.marked)):
        met: set[str] = set()
        for k, item in enumerate(listed):
            if item in met:
                complaints.append(((what, k), f"{item!r} is listed twice"))
            met.add(item)
    if not parts.initial:
        complaints.append((("initial",), "no initial state; write which state the automaton starts in"))
    elif parts.initial not in state_set:
        complaints.append((("initial",), unknown_state(parts.initial)))
    complaints += [(("marked", k), unknown_state(q)) for k, q in enumerate(parts.marked) if q not in state_set]
    complaints += [(("alphabet", k), unknown_event(e)) for k, e in enumerate(parts.alphabet) if e not in known]
    seen: dict[tuple[str, str], tuple[int, str]] = {}
    for k, (s, e, t) in parts.triples:
        here = ("transitions", k)
        complaints += [(here, unknown_state(q)) for q in dict.fromkeys((s, t)) if q not in state_set]
        if e not in known:
            complaints.append((here, unknown_event(e)))
        first, other = seen.setdefault((s, e), (k, t))
        if other != t:
            what = f"nondeterministic: {e!r} leads from {s!r} to {t!r}, and to {other!r} in transition {first + 1}"
            complaints.append((here, what))
        elif (first, s, e) != (k, s, e):
            complaints.append((here, f"{s} -{e}-> {t} repeats transition {first + 1}"))
    return complaints


def assemble(cls: type[Automaton], parts: Parts, known: Alphabet, name: str, meaning: str = "") -> Automaton:
    """Turn checked ``parts`` into arrays."""
    alphabet = known.restrict(dict.fromkeys(parts.event_names()))
    states = parts.state_names()
    number = {q: k for k, q in enumerate(states)}
    index = {e: k for k, e in enumerate(alphabet.names)}
    rows = sorted((number[s], index[e], number[t]) for _, (s, e, t) in parts.triples)
    columns = np.array(rows, np.int64).reshape(-1, 3)
    offsets = np.zeros(len(states) + 1, np.int64)
    np.cumsum(np.bincount(columns[:, 0], minlength=len(states)), out=offsets[1:])
    marked = np.isin(np.arange(len(states)), [number[q] for q in parts.marked])
    return cls(
        name,
        alphabet,
        number[parts.initial],
        offsets,
        columns[:, 1].astype(np.int32),
        columns[:, 2].astype(np.int32),
        marked,
        Listed(tuple(states)),
        meaning=meaning,
    )


def place_in_words(path: Sequence[str | int]) -> str:
    """Say where a complaint's path leads: ``("transitions", 2)`` is ``"transition 3"``."""
    if not path:
        return ""
    noun = {"transitions": "transition", "states": "state", "marked": "marked state", "alphabet": "alphabet entry"}
    head = noun.get(str(path[0]), str(path[0])) if len(path) > 1 else str(path[0])
    return f"{head} {int(path[1]) + 1}" if len(path) > 1 and isinstance(path[1], int) else head


def _place(name: str, path: Sequence[str | int]) -> str:
    owner = f"automaton {name!r}" if name else "automaton"
    return f"{owner}, {place_in_words(path)}" if path else owner
