"""Hanoi Omega-Automata (HOA v1), for tools of temporal logic such as Spot and Owl; written only.

* Each event is an atomic proposition, and in each step exactly one of them is true: the label of event k is the alias
  ``@k``, which says that proposition k holds and no other.
* Marked states are the acceptance set 0, and the condition is Büchi's: an infinite run is accepted if it passes marked
  states again and again.  HOA knows no finite runs: one that ends in a marked state is not accepted.
* Properties of events are said in headers that HOA lets tools ignore: ``controllable-AP`` (as in the format's extension
  for synthesis), ``unobservable-AP`` and ``forcible-AP`` list the propositions.
* Several initial states and nondeterminism are written as they are.

Source: Babiak et al., "The Hanoi Omega-Automata Format", CAV 2015; https://adl.github.io/hoaf/.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from thenar.errors import InputError
from thenar.io.foreign.apart import BLOCK, Parts, apart
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps"]

MOST_EVENTS = 1000  # the aliases take (number of events)² terms


def dumps(automaton: Automaton | ExtendedAutomaton) -> Written:
    r"""Return ``automaton`` in HOA.

    Raises InputError for guards and updates, for more than :data:`MOST_EVENTS` events, and for names that UTF-8 cannot
    say.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"],
    ...     uncontrollable=["off"], name="LAMP")
    >>> print("".join(dumps(lamp).chunks))
    HOA: v1
    name: "LAMP"
    States: 2
    Start: 0
    AP: 2 "on" "off"
    Alias: @0 0&!1
    Alias: @1 !0&1
    acc-name: Buchi
    Acceptance: 1 Inf(0)
    properties: trans-labels explicit-labels state-acc no-univ-branch deterministic
    controllable-AP: 0
    --BODY--
    State: 0 "off" {0}
    [@0] 1
    State: 1 "lit"
    [@1] 0
    --END--
    <BLANKLINE>
    """
    parts = apart(automaton, ".hoa")
    if len(parts.alphabet) > MOST_EVENTS:
        what = f"{len(parts.alphabet):,} events, and .hoa files here have at most {MOST_EVENTS:,}"
        raise InputError(f"automaton {parts.name!r}: {what}; write a .gen or .json file")
    for name in (parts.name, *parts.alphabet.names, *parts.states):
        if any("\ud800" <= c <= "\udfff" for c in name):
            raise InputError(f"automaton {parts.name!r}: the name {name!r} is half of a character; rename it")
    notes = ["a .hoa file is about infinite runs: one that ends is not accepted, though it ends in a marked state"]
    if parts.meaning or any(e.meaning for e in parts.alphabet):
        notes.append("a .hoa file has no place for what automata and events mean")
    return Written(_text(parts), None, tuple(notes))


def _text(parts: Parts) -> Iterator[str]:
    """Yield the lines of the file, some hundred states at a time."""
    n, events = len(parts.states), list(parts.alphabet)
    yield "HOA: v1\n"
    if parts.name:
        yield f"name: {_quoted(parts.name)}\n"
    yield f"States: {n}\n" + "".join(f"Start: {q}\n" for q in parts.initial)
    yield " ".join([f"AP: {len(events)}", *(_quoted(e.name) for e in events)]) + "\n"
    off = [f"!{k}" for k in range(len(events))]
    for k in range(len(events)):
        yield f"Alias: @{k} {'&'.join([*off[:k], str(k), *off[k + 1 :]])}\n"
    yield "acc-name: Buchi\nAcceptance: 1 Inf(0)\n"
    deterministic = len(parts.initial) <= 1 and not ((np.diff(parts.sources) == 0) & (np.diff(parts.events) == 0)).any()
    yield "properties: trans-labels explicit-labels state-acc no-univ-branch" + " deterministic" * deterministic + "\n"
    for header, held in (
        ("controllable", [e.controllable for e in events]),
        ("unobservable", [not e.observable for e in events]),
        ("forcible", [e.forcible for e in events]),
    ):
        numbers = [str(k) for k, true in enumerate(held) if true]
        if numbers or header == "controllable":
            yield " ".join([f"{header}-AP:", *numbers]) + "\n"
    yield "--BODY--\n"
    offsets = np.searchsorted(parts.sources, np.arange(n + 1)).tolist()
    for start in range(0, n, BLOCK):
        stop = min(start + BLOCK, n)
        lo, hi = offsets[start], offsets[stop]
        pairs = zip(parts.events[lo:hi].tolist(), parts.targets[lo:hi].tolist(), strict=True)
        edges = [f"[@{e}] {t}\n" for e, t in pairs]
        marked = parts.marked[start:stop].tolist()
        yield "".join(
            f"State: {q} {_quoted(parts.states[q])}{' {0}' if m else ''}\n"
            + "".join(edges[offsets[q] - lo : offsets[q + 1] - lo])
            for q, m in zip(range(start, stop), marked, strict=True)
        )
    yield "--END--\n"


def _quoted(text: str) -> str:
    """Return ``text`` as a string of HOA: any character may stand in it, quotes and backslashes behind a backslash."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
