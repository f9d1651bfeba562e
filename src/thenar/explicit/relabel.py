"""The same behaviour with other names for its events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from thenar.explicit.nondeterminism import Moves, subsets
from thenar.explicit.reach import reachable
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event, merge
from thenar.model.limits import Limits, Progress

__all__ = ["relabel"]


def relabel(
    automaton: Automaton,
    names: Mapping[str, Event | str],
    *,
    name: str = "",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return the image of ``automaton`` under the relabelling that maps each event in ``names`` to what stands there.

    L and Lm are the images of those of ``automaton``; other events keep their names.  A new name given as text keeps
    the properties of the event, an :class:`Event` brings its own.  Two events may become one: where both lead on from
    a state, a state of the result stands for the set of states in which the automaton may be (as in
    :func:`~thenar.explicit.language.project`).  What cannot be reached is dropped, and the rest numbered breadth-first.
    O(|δ|), and O(2^|Q|) in the worst case where events become one.

    Raises UnknownName for an event outside the alphabet, AlphabetClash for one name with two meanings, LimitReached.

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2", "0 -z-> 2"], initial="0", marked=["2"])
    >>> list(relabel(a, {"x": "go"}).transitions())[0]
    ('0', 'go', '1')
    >>> list(relabel(a, {"x": "go", "z": "go"}).transitions())
    [('0', 'go', '{1, 2}'), ('{1, 2}', 'y', '2')]
    """
    for old in names:
        automaton.alphabet.index(old)
    image = [_called(event, names.get(event.name, event)) for event in automaton.alphabet]
    alphabet = merge([Alphabet([event]) for event in image], [f"{e.name}, renamed" for e in automaton.alphabet])
    if len(alphabet) == len(image):
        return reachable(replace(automaton, alphabet=alphabet, name=name or automaton.name))
    moves = Moves.of(automaton)
    place = np.array([alphabet.index(event) for event in image], np.int64)
    return subsets(
        replace(moves, alphabet=alphabet, event=place[moves.event]), name or automaton.name, limits, progress
    )


def _called(event: Event, new: Event | str) -> Event:
    return new if isinstance(new, Event) else replace(event, name=new)
