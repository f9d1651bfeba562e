"""Assertions about automata whose message shows the first difference by a trace."""

from __future__ import annotations

from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace
from thenar.testing.graphs import read
from thenar.testing.oracle import isomorphic, same_languages

__all__ = ["assert_isomorphic", "assert_same_languages", "assert_same_numbering", "assert_same_supervisor"]


def assert_isomorphic(a: Automaton, b: Automaton) -> None:
    """Fail unless ``a`` and ``b`` are equal but for the names and numbers of their states.

    >>> A = Automaton.from_transitions(["0 -on-> 1 -off-> 0"], initial="0", marked=["0"])
    >>> B = Automaton.from_transitions(["x -on-> y -off-> z -on-> y"], initial="x", marked=["x"])
    >>> assert_isomorphic(A, B)
    Traceback (most recent call last):
    AssertionError: isomorphic: no after on, off: only the first marks it
      first:  Automaton: 2 states (1 marked), 2 transitions, 2 events
      second: Automaton: 3 states (1 marked), 3 transitions, 2 events
    """
    _require(isomorphic(a, b), a, b)


def assert_same_languages(a: Automaton, b: Automaton) -> None:
    """Fail unless ``a`` and ``b`` have the same closed and the same marked behaviour."""
    _require(same_languages(a, b), a, b)


def assert_same_numbering(a: Automaton, b: Automaton) -> None:
    """Fail unless ``a`` and ``b`` are isomorphic and lead to states of the same number.

    >>> A = Automaton.from_transitions(["0 -a-> 1", "0 -b-> 2 -a-> 0"], initial="0")
    >>> B = Automaton.from_transitions(["0 -b-> 1 -a-> 0", "0 -a-> 2"], initial="0")
    >>> assert_same_numbering(A, B)
    Traceback (most recent call last):
    AssertionError: same numbering: no after a: the first is in state 1, the second in state 2
      first:  Automaton: 3 states (0 marked), 3 transitions, 2 events
      second: Automaton: 3 states (0 marked), 3 transitions, 2 events
    """
    assert_isomorphic(a, b)
    for state, trace in read(a).shortest_traces().items():
        if (other := b.run(trace)[-1]) != state:
            reason = f"the first is in state {state}, the second in state {other}"
            _require(Check("same numbering", False, trace, reason), a, b)


def assert_same_supervisor(a: Supervisor, b: Supervisor) -> None:
    """Fail unless ``a`` and ``b`` have the same states by number and name, and enable and disable the same there.

    >>> from thenar.library.classics import cat_and_mouse
    >>> from thenar.synthesis.api import synthesize
    >>> explicit, symbolic = (synthesize(cat_and_mouse(), engine) for engine in ("explicit", "symbolic"))
    >>> assert_same_supervisor(explicit.supervisor, symbolic.supervisor)
    """
    if a.is_empty or b.is_empty:
        _require(
            Check("supervisor", a.is_empty == b.is_empty, Trace(), "one of them is empty"), a.automaton, b.automaton
        )
        return
    assert_same_numbering(a.automaton, b.automaton)
    for q in range(a.n_states):
        mine, theirs = (f"{s.automaton.states[q]}: {s.pattern(q)}" for s in (a, b))
        if mine != theirs:
            trace = read(a.automaton).shortest_traces()[q]
            reason = f"the first says {mine}, the second {theirs}"
            _require(Check("same supervisor", False, trace, reason), a.automaton, b.automaton)


def _require(check: Check, a: Automaton, b: Automaton) -> None:
    if not check:
        raise AssertionError(f"{check}\n  first:  {a!r}\n  second: {b!r}")
