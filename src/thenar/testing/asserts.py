"""Assertions about automata whose message shows the first difference by a trace."""

from __future__ import annotations

from thenar.model.automaton import Automaton
from thenar.testing.oracle import isomorphic, same_languages

__all__ = ["assert_isomorphic", "assert_same_languages", "assert_same_numbering"]


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
    _require(str(check) if not (check := isomorphic(a, b)) else "", a, b)


def assert_same_languages(a: Automaton, b: Automaton) -> None:
    """Fail unless ``a`` and ``b`` have the same closed and the same marked behaviour."""
    _require(str(check) if not (check := same_languages(a, b)) else "", a, b)


def assert_same_numbering(a: Automaton, b: Automaton) -> None:
    """Fail unless ``a`` and ``b`` are equal state number by state number; names do not count.

    >>> A = Automaton.from_transitions(["0 -a-> 1", "0 -b-> 2"], initial="0")
    >>> B = Automaton.from_transitions(["0 -a-> 1", "0 -b-> 2"], initial="0", states=["0", "2", "1"])
    >>> assert_same_numbering(A, B)
    Traceback (most recent call last):
    AssertionError: same numbering: no: a leads to state 1 in the first, to state 2 in the second
      ...
    """
