"""One automaton of a model file: its names and transitions checked, and made into an automaton."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from thenar.io.block import lines, quick
from thenar.io.schema import AutomatonTable, TransitionTable
from thenar.model.build import Complaint, Parts, Unknown, check_parts
from thenar.model.events import Alphabet
from thenar.model.expressions import TRUE, Expression
from thenar.model.extended import Edge, ExtendedAutomaton

__all__ = ["Actions", "Written", "complaints_of"]

_UNREAD = 100  # unreadable transitions searched for state names; a file with more has other troubles
_CHOICE = re.compile(r"nondeterministic: .*|.* repeats transition \d+", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Actions:
    """The guard and the updates of one entry of the transitions, read."""

    guard: Expression = TRUE
    updates: tuple[tuple[str, Expression], ...] = ()


class Written(Parts):
    """What an author wrote about one automaton: its arrows read, its guards and updates still texts.

    ``quick`` is the automaton itself, if it is a long list of transitions without a mistake.
    """

    def __init__(self, table: AutomatonTable, name: str, known: Alphabet) -> None:
        self.table = table
        self.starts = table.initial if isinstance(table.initial, list) else [table.initial]
        self.quick = quick(table, name, known)
        self.entries = [] if self.quick else lines(table.transitions)
        self.guarded = {k: t for k, t in enumerate(self.entries) if isinstance(t, TransitionTable)}
        arrows = [t.arrow if isinstance(t, TransitionTable) else t for t in self.entries]
        states = lines(table.states) if table.states else None
        super().__init__(arrows, self.starts[0], lines(table.marked), table.alphabet, states)

    @property
    def is_extended(self) -> bool:
        """Whether it says what an :class:`Automaton` cannot."""
        acting = any(t.model_fields_set & {"when", "do"} for t in self.guarded.values())
        return acting or len(self.starts) > 1 or self.table.nondeterministic

    def event_names(self) -> Iterable[str]:
        """Yield the event of each transition, and the rest of the alphabet; names repeat."""
        return self.quick.alphabet.names if self.quick else super().event_names()

    def state_names(self) -> list[str]:
        """Return the states as declared, else the initial ones and those mentioned, in that order."""
        if self.quick:
            return [self.quick.states[q] for q in range(self.quick.n_states)]
        if self.declared is not None or len(self.starts) == 1:
            return super().state_names()
        mentioned = (q for _, (s, _, t) in self.triples for q in (s, t))
        return list(dict.fromkeys([*self.starts, *mentioned]))

    def build(self, name: str, known: Alphabet, actions: Mapping[int, Actions]) -> ExtendedAutomaton:
        """Return the automaton; ``actions`` are those of the entries of its transitions that have some."""
        if self.quick:
            return ExtendedAutomaton.from_automaton(self.quick)
        states = self.state_names()
        own = known.restrict(dict.fromkeys(self.event_names()))
        number = {q: k for k, q in enumerate(states)}
        index = {e: k for k, e in enumerate(own.names)}
        nothing = Actions()
        does = [actions.get(k, nothing) for k, _ in self.triples]
        edges = (
            Edge(number[s], index[e], number[t], action.guard, action.updates)
            for (_, (s, e, t)), action in zip(self.triples, does, strict=True)
        )
        first, last = set(self.starts), set(self.marked)
        return ExtendedAutomaton(
            name,
            own,
            tuple(states),
            tuple(q in first for q in states),
            tuple(q in last for q in states),
            tuple(edges),
            meaning=self.table.says,
        )


def complaints_of(parts: Written, known: Alphabet, unknown_event: Unknown) -> list[Complaint]:
    """Return all that is wrong with ``parts``, apart from guards and updates, when ``known`` are the events."""
    if parts.quick:
        return []
    wrong = check_parts(parts, known, unknown_event)
    if parts.guarded or parts.table.nondeterministic:  # there, two ways to go may well be meant
        wrong = [(path, what) for path, what in wrong if not _CHOICE.fullmatch(what)]
    if parts.guarded and not parts.table.nondeterministic:
        wrong += _choices(parts)
    if isinstance(parts.table.initial, list):
        wrong = [(("initial", 0) if path == ("initial",) else path, what) for path, what in wrong]
        wrong += _further_starts(parts)
    # a marked state may be mentioned only in a transition that could not be read; then it is not unknown
    unread = "\n".join(str(parts.entries[k]) for (_, k), _ in parts.complaints[:_UNREAD] if isinstance(k, int))
    known_later = {("marked", k) for k, state in enumerate(parts.marked) if unread and state in unread}
    return parts.complaints + [(path, what) for path, what in wrong if path not in known_later]


def _further_starts(parts: Written) -> list[Complaint]:
    states = parts.state_names()
    known, unknown_state = set(states), Unknown("state", states)
    wrong: list[Complaint] = []
    met: set[str] = set()
    for k, state in enumerate(parts.starts):
        if state in met:
            wrong.append((("initial", k), f"{state!r} is listed twice"))
        elif k and state not in known:
            wrong.append((("initial", k), unknown_state(state)))
        met.add(state)
    return wrong


def _choices(parts: Written) -> list[Complaint]:
    """Return which transitions of one state and event no guards tell apart."""
    wrong: list[Complaint] = []
    unguarded: dict[tuple[str, str], tuple[int, str]] = {}
    whole: dict[tuple[object, ...], int] = {}
    way_out = "tell them apart by when, or say nondeterministic = true"
    for k, (s, e, t) in parts.triples:
        table = parts.guarded.get(k)
        when = table.when if table and "when" in table.model_fields_set else None
        do = tuple((v, type(x), x) for v, x in table.do.items()) if table else ()
        here = ("transitions", k)
        if (same := whole.setdefault((s, e, t, when, do), k)) != k:
            wrong.append((here, f"{s} -{e}-> {t} repeats transition {same + 1}"))
        elif when is None:
            first, other = unguarded.setdefault((s, e), (k, t))
            if first != k:
                what = f"{e!r} leads from {s!r} to {t!r}, and to {other!r} in transition {first + 1}"
                wrong.append((here, f"nondeterministic: {what}; {way_out}"))
    return wrong
