"""Models as plain text tables, one row a line, for terminals and pipes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import singledispatch

from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check
from thenar.render.measure import cells, printable

__all__ = ["ROWS", "arrows", "event_names", "state_rows", "table"]

ROWS = 40  # states that a table lists before it says how many there are more

_LONG_NAME = 24  # characters; longer names of states entered are replaced by their numbers


@singledispatch
def table(obj: object, *, rows: int = ROWS) -> str:
    """Return a table of an automaton, a supervisor, a problem or a check; of anything else, its repr.

    At most ``rows`` states are listed, the rest is counted.  ``>`` points at the initial state, ``!`` marks
    an uncontrollable event.  Control characters in names are escaped.

    >>> lamp = Automaton.from_transitions(
    ...     ["off -on-> lit -fuse-> off"], initial="off", marked=["off"], uncontrollable=["fuse"], name="LAMP"
    ... )
    >>> print(table(lamp))
    Automaton 'LAMP': 2 states (1 marked), 2 transitions, 2 events
    <BLANKLINE>
         state  marked  transitions
    > 0  off    yes     on -> lit
      1  lit    -       fuse! -> off
    """
    return printable(repr(obj))


@table.register
def _(obj: Automaton, *, rows: int = ROWS) -> str:
    header = ("", "state", "marked", "transitions")
    return _states(obj, repr(obj), header, rows, lambda q: ("yes" if obj.marked[q] else "-", arrows(obj, q)))


@table.register
def _(obj: Supervisor, *, rows: int = ROWS) -> str:
    def patterns(q: int) -> tuple[str, str]:
        pattern = obj.pattern(q)
        return event_names(pattern.enabled) or "-", event_names(pattern.disabled) or "-"

    return _states(obj.automaton, repr(obj), ("", "state", "enabled", "disabled"), rows, patterns)


@table.register
def _(obj: Problem, *, rows: int = ROWS) -> str:
    lines: list[tuple[str, ...]] = [("automaton", "role", "states", "marked", "transitions", "events")]
    for k, a in enumerate(obj.automata[:rows]):
        sizes = a.n_states, int(a.marked.sum()), a.n_transitions, len(a.alphabet)
        role = "plant" if k < len(obj.plants) else "spec"
        lines.append((printable(a.name) or "-", role, *(f"{n:,}" for n in sizes)))
    return "\n".join(
        [printable(repr(obj)), "", *_aligned(lines, numbers={2, 3, 4, 5}), *_more(len(obj.automata) - rows)]
    )


@table.register
def _(obj: Check, *, rows: int = ROWS) -> str:
    lines = [("property", obj.property), ("holds", "yes" if obj.holds else "no")]
    if obj.witness is not None:
        lines.append(("witness", str(obj.witness)))
    if obj.reason:
        lines.append(("reason", obj.reason))
    return "\n".join(_aligned([(name, printable(value)) for name, value in lines]))


def arrows(G: Automaton, q: int, arrow: str = "->") -> str:
    """Return the transitions that leave state ``q``: ``"lift, pull -> held; slip! -> lost"``."""
    grouped: dict[int, list[Event]] = {}
    for e, t in G.row(q):
        grouped.setdefault(t, []).append(G.alphabet[e])
    return "; ".join(f"{event_names(events)} {arrow} {_short(G, t)}" for t, events in grouped.items()) or "-"


def event_names(events: Iterable[Event]) -> str:
    """Return the names, with ``!`` after that of an uncontrollable event, as an alphabet prints them."""
    return ", ".join(printable(e.name) + "!" * (not e.controllable) for e in events)


def state_rows(G: Automaton, rows: int, cells_of: Callable[[int], Sequence[str]]) -> list[tuple[str, ...]]:
    """Return number, name and ``cells_of`` each of the first ``rows`` states."""
    return [(f"{q}", printable(G.states[q]), *cells_of(q)) for q in range(min(rows, G.n_states))]


def _short(G: Automaton, q: int) -> str:
    name = G.states[q]
    return printable(name) if len(name) <= _LONG_NAME else f"{q}"


def _states(
    G: Automaton, title: str, header: Sequence[str], rows: int, cells_of: Callable[[int], Sequence[str]]
) -> str:
    if G.is_empty:
        return printable(title)
    lines = [tuple(header)]
    digits = len(str(min(rows, G.n_states) - 1))
    for q, (number, *rest) in enumerate(state_rows(G, rows, cells_of)):
        lines.append((f"{'>' if q == G.initial else ' '} {number:>{digits}}", *rest))
    return "\n".join([printable(title), "", *_aligned(lines), *_more(G.n_states - rows)])


def _more(left_out: int) -> list[str]:
    return [f"… {left_out:,} more"] if left_out > 0 else []


def _aligned(lines: Sequence[Sequence[str]], numbers: frozenset[int] | set[int] = frozenset()) -> list[str]:
    """Put columns below each other; a terminal's, in which some characters are two columns wide."""
    widths = [max(map(cells, column)) for column in zip(*lines, strict=True)]

    def padded(k: int, text: str) -> str:
        space = " " * (widths[k] - cells(text))
        return space + text if k in numbers else text + space

    return ["  ".join(padded(k, text) for k, text in enumerate(line)).rstrip() for line in lines]
