"""The automaton: frozen arrays, and lookup in them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thenar.errors import Mistake, ModelError, UnknownName, counted
from thenar.model.display import Displayable
from thenar.model.events import Alphabet, Event
from thenar.model.names import Listed, Numbered, StateNames, state_index
from thenar.model.trace import Trace

__all__ = ["Automaton"]


@dataclass(frozen=True, slots=True, eq=False, repr=False, weakref_slot=True)
class Automaton(Displayable):
    """A deterministic automaton G = (Q, Σ, δ, q0, Qm) with a partial transition function δ.

    The transitions of all states lie one state after the other (compressed sparse rows), each row in the
    order of the alphabet:

    * ``offsets``: (n_states + 1,) int64, row q is ``offsets[q]:offsets[q + 1]``
    * ``events``: (n_transitions,) int32, position in ``alphabet`` of the event of each transition
    * ``targets``: (n_transitions,) int32, state entered by each transition
    * ``marked``: (n_states,) bool, the marker states Qm
    * ``initial``: q0; -1 in the empty automaton, which has no states
    * ``meaning``: what the automaton says, in words, for explanations

    The constructor trusts its arrays; build with :func:`from_transitions` or :func:`from_arrays`, which check.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> lamp
    Automaton 'LAMP': 2 states (1 marked), 2 transitions, 2 events
    >>> lamp.generates("on, off, on"), lamp.marks("on"), lamp.generates("off")
    (True, False, False)
    """

    name: str
    alphabet: Alphabet
    initial: int
    offsets: NDArray[np.int64]
    events: NDArray[np.int32]
    targets: NDArray[np.int32]
    marked: NDArray[np.bool_]
    states: StateNames
    meaning: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        for array in (self.offsets, self.events, self.targets, self.marked):
            array.flags.writeable = False

    def __reduce__(self) -> tuple[Any, ...]:
        # not __setstate__: Python before 3.11.4 puts its own in the place of a frozen slotted dataclass's; and arrays
        # come back writable from a pickle
        return _again, (type(self), {f.name: getattr(self, f.name) for f in fields(self)})

    # -- building ------------------------------------------------------------------------------------------

    @classmethod
    def from_arrays(
        cls,
        alphabet: Alphabet,
        offsets: ArrayLike,
        events: ArrayLike,
        targets: ArrayLike,
        *,
        marked: ArrayLike,
        initial: int = 0,
        name: str = "",
        meaning: str = "",
        states: list[str] | tuple[str, ...] | StateNames | None = None,
    ) -> Automaton:
        """Build from arrays as in the class docstring; they are copied and checked, O(transitions).

        Raises ModelError naming every array that is malformed.
        """
        wrong: list[str] = []
        o, e, t, m = (
            _whole_numbers(array, what, wrong)
            for what, array in (("offsets", offsets), ("events", events), ("targets", targets), ("marked", marked))
        )
        if wrong:
            raise ModelError([Mistake(f"automaton {name!r}", w) for w in wrong])
        n = len(m)
        if not np.isin(m, (0, 1)).all():
            wrong.append("marked must be true or false for each state")
        if o.ndim != 1 or len(o) != n + 1 or (o[0], o[-1]) != (0, len(e)) or (np.diff(o) < 0).any():
            wrong.append(f"offsets must rise from 0 to {len(e)} over {n + 1} entries")
        if len(e) != len(t):
            wrong.append(f"{len(e)} events but {len(t)} targets")
        if len(e) and not (0 <= e.min() and e.max() < len(alphabet)):
            wrong.append(f"events must lie in 0 .. {len(alphabet) - 1}")
        if len(t) and not (0 <= t.min() and t.max() < n):
            wrong.append(f"targets must lie in 0 .. {n - 1}")
        if not (0 <= initial < n if n else initial == -1):
            wrong.append(f"initial is {initial}, no state (-1 for an automaton without states)")
        if not wrong and len(e) > 1:
            row_starts = np.zeros(len(e), np.bool_)
            row_starts[o[:-1][o[:-1] < len(e)]] = True
            if (~row_starts[1:] & (np.diff(e) <= 0)).any():
                wrong.append("the events of each state must rise strictly (sorted, and deterministic)")
        if states is not None and len(states) != n:
            wrong.append(f"{len(states)} state names for {n} states")
        if wrong:
            raise ModelError([Mistake(f"automaton {name!r}", w) for w in wrong])
        if states is None:
            names: StateNames = Numbered(np.arange(n))
        else:
            names = Listed(tuple(states)) if isinstance(states, (list, tuple)) else states
        return cls(
            name,
            alphabet,
            initial,
            o,
            e.astype(np.int32),
            t.astype(np.int32),
            m.astype(np.bool_),
            names,
            meaning=meaning,
        )

    @classmethod
    def from_transitions(
        cls,
        transitions: Iterable[str | tuple[str, str, str]],
        *,
        initial: str,
        marked: Iterable[str] = (),
        events: Alphabet | Iterable[Event | str] | None = None,
        uncontrollable: Iterable[str] = (),
        alphabet: Iterable[str] = (),
        states: Iterable[str] | None = None,
        name: str = "",
        meaning: str = "",
    ) -> Automaton:
        """Build from triples (source, event, target) or from arrow notation.

        An arrow text is a chain of transitions; one arrow may carry several events:
        ``"idle -approach-> near -lift,pull-> held"``.

        ``events`` are the known events: any other name is an error, and their order orders the alphabet.
        Without it, every event mentioned is known, and controllable unless listed in ``uncontrollable``.
        ``alphabet`` adds events that no transition carries: the automaton blocks them.
        ``states`` lists the states (any other name is an error); without it they are those mentioned,
        the initial one first.

        Raises ModelError with all mistakes at once: unknown or duplicate names, nondeterminism, syntax.
        """
        from thenar.model.build import build_automaton

        return build_automaton(
            cls,
            transitions,
            initial=initial,
            marked=marked,
            events=events,
            uncontrollable=uncontrollable,
            alphabet=alphabet,
            states=states,
            name=name,
            meaning=meaning,
        )

    @classmethod
    def empty(cls, alphabet: Alphabet, name: str = "") -> Automaton:
        """Return the automaton without states: both of its languages are empty.

        >>> Automaton.empty(Alphabet(["a"])).n_states
        0
        """
        none = np.zeros(0, np.int32)
        return cls(name, alphabet, -1, np.zeros(1, np.int64), none, none.copy(), np.zeros(0, np.bool_), Listed(()))

    # -- lookup --------------------------------------------------------------------------------------------

    @property
    def n_states(self) -> int:
        """|Q|."""
        return len(self.marked)

    @property
    def n_transitions(self) -> int:
        """|δ|."""
        return len(self.targets)

    @property
    def is_empty(self) -> bool:
        """True if there is no state, and so no string, not even ε."""
        return self.n_states == 0

    def state(self, name: str | int) -> int:
        """Return the number of the state called ``name`` (a number is checked and returned)."""
        if isinstance(name, str):
            found = state_index(self.states, name)
        else:
            found = int(name) if 0 <= name < self.n_states else None
        if found is None:
            known = (self.states[q] for q in range(min(self.n_states, 10_000)))
            raise UnknownName("state", name, known, f"automaton {self.name!r}" if self.name else "")
        return found

    def row(self, state: int) -> Iterator[tuple[int, int]]:
        """Yield (event, target) of each transition that leaves ``state``, in the order of the alphabet."""
        lo, hi = self.offsets[state], self.offsets[state + 1]
        yield from zip(self.events[lo:hi].tolist(), self.targets[lo:hi].tolist(), strict=True)

    def enabled(self, state: int) -> tuple[Event, ...]:
        """Return the events defined at ``state``."""
        return tuple(self.alphabet[e] for e, _ in self.row(state))

    def step(self, state: int, event: str | Event) -> int | None:
        """Return δ(event, state), or None where it is undefined."""
        k = self.alphabet.index(event)
        lo, hi = self.offsets[state], self.offsets[state + 1]
        i = lo + np.searchsorted(self.events[lo:hi], k)
        return int(self.targets[i]) if i < hi and self.events[i] == k else None

    def run(self, trace: Iterable[str] | str) -> list[int]:
        """Return the states passed by the longest prefix of ``trace`` that is generated, q0 first.

        Its length is 1 + len(trace) exactly if the whole trace is in L(G); [] if the automaton is empty.
        """
        if self.is_empty:
            return []
        states = [self.initial]
        for event in Trace(trace):
            target = self.step(states[-1], event)
            if target is None:
                break
            states.append(target)
        return states

    def generates(self, trace: Iterable[str] | str) -> bool:
        """Return whether ``trace`` is in the closed behaviour L(G); raise UnknownName for a foreign event."""
        string = Trace(trace)
        return len(self.run(string)) == len(string) + 1

    def marks(self, trace: Iterable[str] | str) -> bool:
        """Return whether ``trace`` is in the marked behaviour Lm(G); raise UnknownName for a foreign event."""
        string = Trace(trace)
        states = self.run(string)
        return len(states) == len(string) + 1 and bool(self.marked[states[-1]])

    def transitions(self) -> Iterator[tuple[str, str, str]]:
        """Yield every transition as (source, event, target) names."""
        for q in range(self.n_states):
            for e, t in self.row(q):
                yield self.states[q], self.alphabet[e].name, self.states[t]

    def __repr__(self) -> str:
        title = f"Automaton {self.name!r}" if self.name else "Automaton"
        return (
            f"{title}: {counted(self.n_states, 'state')} ({int(self.marked.sum()):,} marked), "
            f"{counted(self.n_transitions, 'transition')}, {counted(len(self.alphabet), 'event')}"
        )


def _whole_numbers(array: ArrayLike, what: str, wrong: list[str]) -> NDArray[np.int64]:
    """Return ``array`` as a vector of whole numbers; note in ``wrong`` if it is none."""
    given = np.asarray(array)
    if given.ndim != 1 or (given.dtype.kind not in "iub" and given.size):
        wrong.append(f"{what} must be a vector of whole numbers")
        return np.zeros(1, np.int64)
    return given.astype(np.int64)


def _again(cls: type[Automaton], values: dict[str, Any]) -> Automaton:
    """Make an automaton of what a pickle held."""
    return cls(**values)
