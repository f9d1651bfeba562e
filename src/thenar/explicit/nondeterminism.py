"""Nondeterminism, and the deterministic automaton with the same languages: the subset construction."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thenar._native import kernel
from thenar.errors import InputError, Mistake, ModelError
from thenar.explicit.exploration import common_alphabet, ticker
from thenar.explicit.reach import reachable
from thenar.explicit.rows import bytemask, row_offsets, rows_in_order_of, sources
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.expressions import TRUE
from thenar.model.extended import ExtendedAutomaton
from thenar.model.limits import Limits, Progress
from thenar.model.names import Grouped, Listed, StateNames, every_name, state_index

__all__ = ["EPSILON", "Moves", "determinise", "subsets"]

EPSILON = -1  # the event of a silent move
_WAY_OUT = "an automaton with variables is no subject for this, make a problem of it: synthesize takes them"


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """A nondeterministic automaton: several moves for one state and event, silent ones, several first states.

    * ``source``, ``event``, ``target``: (n_moves,) int64; an event is a position in ``alphabet``, or EPSILON
    * ``initial``: numbers of states; ``marked``: (n_states,) bool; ``states``: their names

    >>> a = Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=["1"])
    >>> list(subsets(Moves.of(a).silently([0], [1]), "").transitions())
    [('{0, 1}', 'x', '1')]
    """

    alphabet: Alphabet
    source: NDArray[np.int64]
    event: NDArray[np.int64]
    target: NDArray[np.int64]
    initial: NDArray[np.int64]
    marked: NDArray[np.bool_]
    states: StateNames

    @classmethod
    def of(cls, *automata: Automaton) -> Moves:
        """Return ``automata`` side by side, over the union of their alphabets; any of them may be the one that moves.

        The states of each follow those of the one before.
        """
        alphabet = common_alphabet(automata)
        begins = row_offsets([a.n_states for a in automata])[:-1]
        columns = [
            np.stack((sources(a) + k, rows[0].astype(np.int64), rows[1] + k))
            for a, k, rows in ((a, k, rows_in_order_of(alphabet, a)) for a, k in zip(automata, begins, strict=True))
        ]
        source, event, target = np.concatenate(columns, axis=1)
        states = tuple(a.states for a in automata)
        return cls(
            alphabet,
            source,
            event,
            target,
            np.array([a.initial + k for a, k in zip(automata, begins, strict=True) if not a.is_empty], np.int64),
            np.concatenate([a.marked for a in automata]),
            states[0] if len(states) == 1 else _SideBySide(states, _labels(automata)),
        )

    def silently(self, source: ArrayLike, target: ArrayLike) -> Moves:
        """Return these moves and silent ones from ``source`` to ``target``, (n,) numbers of states."""
        more = np.asarray(source, np.int64)
        return replace(
            self,
            source=np.concatenate((self.source, more)),
            event=np.concatenate((self.event, np.full(len(more), EPSILON))),
            target=np.concatenate((self.target, np.asarray(target, np.int64))),
        )

    def and_state(self, name: str, *, marked: bool) -> Moves:
        """Return these moves and one more state, the last, called ``name``, with primes should it be taken."""
        while state_index(self.states, name) is not None:
            name += "'"
        states = _SideBySide((self.states, Listed((name,))), ("", ""))
        return replace(self, marked=np.append(self.marked, marked), states=states)


def determinise(
    automaton: ExtendedAutomaton,
    silent: Iterable[str] = (),
    *,
    name: str = "",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return a deterministic automaton with the languages of a nondeterministic one, ``silent`` events erased.

    An :class:`ExtendedAutomaton` may begin in several states and have several edges for one state and event.
    A string is in L of the result if it can lead somewhere, in Lm if it can lead to a marked state: a state stands
    for the set of states in which the automaton may be, and is marked if one of them is.  Events in ``silent``
    (CIF's ``tau``, say) happen unseen, and are not in the alphabet of the result.  It is numbered breadth-first in the
    order of the alphabet, and not minimal: see :func:`~thenar.explicit.language.minimize`.  O(2^|Q|) in the worst
    case: give ``limits``.

    Raises InputError for an :class:`Automaton`, which is deterministic, ModelError for guards and updates, UnknownName
    for a silent event that the alphabet lacks, LimitReached at a limit.   [Rabin and Scott 1959]

    >>> coin = ExtendedAutomaton.from_edges(
    ...     "COIN", ["up -flip-> up", "up -flip-> down -stop-> end"], initial="up", marked=["end"])
    >>> list(determinise(coin).transitions())
    [('up', 'flip', '{up, down}'), ('{up, down}', 'flip', '{up, down}'), ('{up, down}', 'stop', 'end')]
    >>> determinise(coin, silent=["flip"]).marks("stop")
    True
    """
    if isinstance(silent, str):
        raise InputError(f"silent is a list of events, not the text {silent!r}")
    if isinstance(automaton, Automaton):
        which = f"automaton {automaton.name!r}" if automaton.name else "it"
        raise InputError(f"determinise: {which} is an Automaton, which is deterministic already; project erases events")
    mistakes = [
        Mistake(f"determinise: {automaton.place(k)} of {automaton.name!r}", f"it has {what}; {_WAY_OUT}")
        for k, edge in enumerate(automaton.edges)
        for what, there in (("a guard", edge.guard != TRUE), ("updates", bool(edge.updates)))
        if there
    ]
    if mistakes:
        raise ModelError(mistakes)
    erased = automaton.alphabet.restrict(silent)
    seen = Alphabet(e for e in automaton.alphabet if e not in erased)
    position = [seen.index(e) if e in seen else EPSILON for e in automaton.alphabet]
    rows = [(e.source, position[e.event], e.target) for e in automaton.edges]
    source, event, target = np.array(rows, np.int64).reshape(-1, 3).T
    initial, marked = np.flatnonzero(automaton.initial), np.array(automaton.marked, np.bool_)
    moves = Moves(seen, source, event, target, initial, marked, Listed(automaton.states))
    return subsets(moves, name or automaton.name, limits, progress)


def subsets(moves: Moves, name: str, limits: Limits | None = None, progress: Progress | None = None) -> Automaton:
    """Return the subset construction of ``moves``, named ``name``: each state stands for a set of theirs.

    It is called after them; those whose names could be taken for sets, or for several, are quoted if they are.
    """
    if not len(moves.initial):
        return Automaton.empty(moves.alphabet, name)
    several, first = len(moves.initial) > 1, int(moves.initial[0])
    if several:  # one state before them leads to each of them in silence; its name is never needed
        first = len(moves.marked)
        moves = replace(moves, marked=np.append(moves.marked, False))
        moves = moves.silently(np.full(len(moves.initial), first), moves.initial)
    order, silence = np.argsort(moves.source, kind="stable"), len(moves.alphabet)
    events = np.where(moves.event == EPSILON, silence, moves.event)
    offsets, labels, targets, marked, member_offsets, members = kernel.project(
        row_offsets(np.bincount(moves.source, minlength=len(moves.marked))),
        events[order].astype(np.int32),
        moves.target[order].astype(np.int32),
        silence + 1,
        first,
        bytemask(moves.marked),
        bytemask(np.arange(silence + 1) == silence),
        ticker(limits, progress),
    )
    initial = 0
    if several:  # that state is the last member of the first set and in no other; without it the set may come again
        members = np.delete(members, member_offsets[1] - 1)
        member_offsets = np.maximum(member_offsets - 1, 0)
        initial = _same_as_the_first(member_offsets, members)
    states = _told_apart(Grouped(moves.states, member_offsets, members))
    automaton = Automaton(name, moves.alphabet, initial, offsets, labels, targets, marked.view(np.bool_), states)
    return reachable(automaton) if initial else automaton


def _same_as_the_first(offsets: NDArray[np.int64], members: NDArray[np.int64]) -> int:
    """Return the number of another set with the members of set 0, or 0 if there is none."""
    sizes = np.diff(offsets)
    others = np.flatnonzero(sizes[1:] == sizes[0]) + 1
    for k in range(sizes[0]):
        if not len(others):
            return 0
        others = others[members[offsets[others] + k] == members[k]]
    return int(others[0]) if len(others) else 0


def _told_apart(sets: Grouped) -> Grouped:
    """Return ``sets``, the names of their members in quotes where necessary if two of them had one name."""
    if not any(map(_looks_like_sets, every_name(sets.names))):
        return sets
    names = every_name(sets)
    return sets if len(set(names)) == len(names) else replace(sets, names=_Quoted(sets.names))


def _looks_like_sets(name: str) -> bool:
    return name.startswith(("{", "'")) or ", " in name


@dataclass(frozen=True, slots=True)
class _Quoted:
    """Names of which those are in quotes that could be taken for sets of names, or for several of them."""

    names: StateNames

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, state: int, /) -> str:
        name = self.names[state]
        return "'" + name.replace("'", "''") + "'" if _looks_like_sets(name) else name

    def take(self, states: NDArray[np.int64]) -> StateNames:
        """Return the names of ``states``."""
        return _Quoted(self.names.take(states))


@dataclass(frozen=True, slots=True)
class _SideBySide:
    """The names of states side by side, each after the label of its automaton; composed when looked at."""

    parts: tuple[StateNames, ...]
    labels: tuple[str, ...]

    def __len__(self) -> int:
        return sum(len(part) for part in self.parts)

    def __getitem__(self, state: int, /) -> str:
        for part, label in zip(self.parts, self.labels, strict=True):
            if state < len(part):
                return label + part[state]
            state -= len(part)
        raise IndexError(state)

    def take(self, states: NDArray[np.int64]) -> StateNames:
        """Return the names of ``states``."""
        return Listed(tuple(self[q] for q in states.tolist()))


def _labels(automata: Sequence[Automaton]) -> tuple[str, ...]:
    """Return what tells the states of the automata apart: their names, or numbers where those do not."""
    labels = tuple(f"{a.name}." for a in automata)
    told_apart = all(a.name for a in automata) and not any(
        a.startswith(b) for k, a in enumerate(labels) for i, b in enumerate(labels) if i != k
    )
    return labels if told_apart else tuple(f"{k}." for k in range(1, len(automata) + 1))
