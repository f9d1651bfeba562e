"""Hypothesis strategies for alphabets, automata and control problems; needs ``pip install thenar[testing]``.

>>> from hypothesis import given
>>> from thenar.testing import oracle
>>> @given(problems())
... def test_every_supervisor_is_nonblocking(problem):
...     assert oracle.is_nonblocking(oracle.supcon(problem.plants, problem.specs))
>>> test_every_supervisor_is_nonblocking()
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

from hypothesis import strategies as st

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.extended import ExtendedProblem
from thenar.model.problem import Problem
from thenar.testing.random_models import extended_by_chance, numbered_alphabet, problem_by_chance, random_automaton

__all__ = ["alphabets", "automata", "extended_problems", "problems"]


class _Tape(Random):
    """A source of chance that reads bytes drawn by Hypothesis, then zeros.

    A tape for each automaton, instead of a hundred small draws, makes shrinking ten times as quick, and a
    shorter tape for one automaton leaves the others as they are.
    """

    def __init__(self, tape: bytes) -> None:
        super().__init__(0)
        self._tape = iter(tape)

    def randrange(self, start: int, stop: int | None = None, step: int = 1) -> int:
        return next(self._tape, 0) * start // 256

    def randint(self, a: int, b: int) -> int:
        return a + self.randrange(b - a + 1)

    def choice(self, seq: Sequence[Any]) -> Any:  # type: ignore[override]
        return seq[self.randrange(len(seq))]


_TAPES = st.binary(min_size=60, max_size=90).map(_Tape)


def alphabets(*, min_events: int = 1, max_events: int = 6) -> st.SearchStrategy[Alphabet]:
    """Alphabets of ``min_events`` to ``max_events`` events, one of three uncontrollable."""
    uncontrollable = st.sampled_from([False, False, True])
    return st.lists(uncontrollable, min_size=min_events, max_size=max_events).map(numbered_alphabet)


@st.composite
def automata(
    draw: st.DrawFn, alphabet: Alphabet | None = None, *, max_events: int = 4, max_states: int = 5
) -> Automaton:
    """Automata of 1 to ``max_states`` states, over ``alphabet`` or one of at most ``max_events`` events.

    They may block, and have states out of reach and events without transitions.
    """
    if alphabet is None:
        alphabet = draw(alphabets(max_events=max_events))
    return random_automaton(draw(_TAPES), alphabet, max_states=max_states)


@st.composite
def problems(
    draw: st.DrawFn, *, max_events: int = 8, max_plants: int = 3, max_specs: int = 3, max_states: int = 4
) -> Problem:
    """Control problems like those of :func:`~thenar.testing.random_models.random_problem`, but plainer.

    Hypothesis tries simple things first: half of them need no control or little, a quarter have states to
    avoid, one in eight has no supervisor.
    """
    alphabet = draw(alphabets(min_events=(max_events + 1) // 2, max_events=max_events))
    plants = draw(st.lists(_TAPES, min_size=1, max_size=max_plants))
    specs = draw(st.lists(_TAPES, max_size=max_specs))
    return problem_by_chance(alphabet, plants, specs, max_states=max_states)


@st.composite
def extended_problems(
    draw: st.DrawFn,
    *,
    max_events: int = 6,
    max_plants: int = 3,
    max_specs: int = 2,
    max_variables: int = 2,
    max_states: int = 4,
) -> ExtendedProblem:
    """Control problems like those of :func:`~thenar.testing.random_models.random_extended_problem`, but plainer."""
    alphabet = draw(alphabets(min_events=(max_events + 1) // 2, max_events=max_events))
    plants = draw(st.lists(_TAPES, min_size=1, max_size=max_plants))
    specs = draw(st.lists(_TAPES, max_size=max_specs))
    extension = draw(st.binary(max_size=200).map(_Tape))
    return extended_by_chance(alphabet, plants, specs, extension, max_variables=max_variables, max_states=max_states)
