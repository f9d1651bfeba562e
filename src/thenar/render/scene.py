"""What a picture shows: nodes and edges picked from an automaton, before anyone decides where they go."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from thenar.errors import InputError
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Trace

__all__ = ["Edge", "Label", "Node", "Scene", "scene"]

LIMIT = 30  # states; beyond it a drawing of everything takes long to make and longer to read


@dataclass(frozen=True, slots=True)
class Label:
    """One event on an edge: ``disabled`` by a supervisor, or ``highlighted`` as a step of the path."""

    event: Event
    disabled: bool = False
    highlighted: bool = False


@dataclass(frozen=True, slots=True)
class Node:
    """A state; or the loose end of an edge: ``cut`` leads out of the picture, ``disabled`` leads nowhere.

    ``highlighted`` is a current state, ``passed`` one that the path visits.  ``state`` is its number; of a
    loose end, that of the state it hangs on.
    """

    state: int
    label: str
    initial: bool = False
    marked: bool = False
    highlighted: bool = False
    passed: bool = False
    kind: Literal["state", "cut", "disabled"] = "state"


@dataclass(frozen=True, slots=True)
class Edge:
    """All transitions between two nodes; ``source`` and ``target`` are positions in ``Scene.nodes``."""

    source: int
    target: int
    labels: tuple[Label, ...]

    @property
    def controllable(self) -> bool:
        """True if some event on the edge can be disabled."""
        return any(label.event.controllable for label in self.labels)

    @property
    def uncontrollable(self) -> bool:
        """True if every event on the edge happens when it likes."""
        return bool(self.labels) and not self.controllable

    @property
    def highlighted(self) -> bool:
        """True if the path runs along the edge."""
        return any(label.highlighted for label in self.labels)


@dataclass(frozen=True, slots=True)
class Scene:
    """A graph to be drawn, with its ``title``; ``caption`` says what was left out and is empty otherwise.

    ``root`` is the position of the node that the drawing starts from: the initial state, if it is shown.
    """

    title: str
    caption: str
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    root: int = 0


def scene(
    automaton: Automaton | Supervisor,
    *,
    highlight: Iterable[int] = (),
    path: Trace | str | None = None,
    centre: int | None = None,
    limit: int = LIMIT,
) -> Scene:
    """Pick what a picture of ``automaton`` shows.

    ``highlight`` are current states.  ``path`` is a trace, say a counterexample, to be drawn along the states
    and transitions that it takes; where it takes an event that is not defined, the refused event is shown.
    At each state of a supervisor the disabled events are shown too.

    Above ``limit`` states the whole is never drawn, but the states passed by ``path`` if there are several
    of them; otherwise those nearest to ``centre`` (by default, where the path ends, the first highlighted
    state, or the initial state): first those that can follow it, breadth-first, then those that lead there.
    The caption says so.  Time O(limit), and one look at every transition to find those that lead in.

    Raises UnknownName for a state or event that does not exist, InputError for what is no automaton.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> picture = scene(lamp, path="on")
    >>> [node.label for node in picture.nodes if node.passed], picture.edges[0].highlighted
    (['off', 'lit'], True)
    >>> scene(lamp, limit=1).caption
    '1 of 2 states, around state 0'
    """
    if not isinstance(automaton, Automaton | Supervisor):
        raise InputError(f"cannot draw {automaton!r} as one graph; give an automaton or a supervisor")
    if limit < 1:
        raise InputError(f"limit is {limit}; a picture shows at least 1 state")
    supervisor, G = (automaton, automaton.automaton) if isinstance(automaton, Supervisor) else (None, automaton)
    lit = [G.state(q) for q in highlight]
    walk = _Walk(G, path)
    view, caption, focus = _view(G, walk, lit, None if centre is None else G.state(centre), limit)

    position = {q: k for k, q in enumerate(view)}
    visited = frozenset(walk.states)
    nodes = [Node(q, G.states[q], q == G.initial, bool(G.marked[q]), q in lit, q in visited, "state") for q in view]
    edges: list[Edge] = []
    incoming = _entered_from_outside(G, view)
    for k, q in enumerate(view):
        grouped: dict[int, list[Label]] = {}
        for e, t in G.row(q):
            label = Label(G.alphabet[e], highlighted=(q, e) in walk.steps)
            grouped.setdefault(position.get(t, -1), []).append(label)
        cut = grouped.pop(-1, [])
        edges += [Edge(k, t, tuple(labels)) for t, labels in grouped.items()]
        if cut:
            edges.append(Edge(k, len(nodes), tuple(cut)))
            nodes.append(Node(q, "…", kind="cut"))
        if q in incoming:
            edges.append(Edge(len(nodes), k, ()))
            nodes.append(Node(q, "…", kind="cut"))
        if stopped := _stopped(supervisor, G, walk, q):
            edges.append(Edge(k, len(nodes), stopped))
            nodes.append(Node(q, "", kind="disabled"))
    root = position.get(G.initial, position.get(focus, 0))
    return Scene(repr(automaton), caption, tuple(nodes), tuple(edges), root)


class _Walk:
    """The states and steps of a trace, and the event that is refused where it ends, if one is."""

    def __init__(self, G: Automaton, path: Trace | str | None) -> None:
        trace = Trace(path) if isinstance(path, str) else path
        events = [] if trace is None else [G.alphabet.index(e) for e in trace]
        self.states = [] if trace is None else G.run(trace)
        self.steps = frozenset(zip(self.states, events[: max(0, len(self.states) - 1)], strict=False))
        refused = bool(self.states) and len(self.states) <= len(events)
        self.refused = (self.states[-1], events[len(self.states) - 1]) if refused else None


def _view(G: Automaton, walk: _Walk, lit: list[int], centre: int | None, limit: int) -> tuple[list[int], str, int]:
    """Return the states to show, in ascending order, the caption, and where the flow of what is shown starts."""
    if G.n_states <= limit:
        return list(range(G.n_states)), "" if G.n_states else "no states", G.initial
    passed = list(dict.fromkeys(reversed(walk.states)))[:limit]  # from its end, where what it shows happens
    if centre is None and len(passed) > 1:
        whole = len(passed) == len(set(walk.states))
        which = "those passed by the trace" if whole else "the last passed by the trace"
        return sorted(passed), f"{len(passed):,} of {G.n_states:,} states, {which}", passed[-1]
    if centre is None:
        centre = (*passed, *lit, G.initial)[0]
    near = _neighbourhood(G, centre, limit)
    return near, f"{len(near):,} of {G.n_states:,} states, around state {centre:,}", centre


def _neighbourhood(G: Automaton, centre: int, limit: int) -> list[int]:
    """Return up to ``limit`` states around ``centre``: those ahead first, then those behind."""
    found = {centre: None}  # a dict, since it keeps the order of discovery
    queue = [centre]
    for q in queue:
        for _, t in G.row(q):
            if t not in found and len(found) < limit:
                found[t] = None
                queue.append(t)
    while len(found) < limit:
        inside = np.zeros(G.n_states, np.bool_)
        inside[list(found)] = True
        leading_in = np.flatnonzero(inside[G.targets])
        sources = np.unique(np.searchsorted(G.offsets, leading_in, side="right") - 1)
        behind = sources[~inside[sources]][: limit - len(found)].tolist()
        if not behind:
            break
        found.update(dict.fromkeys(behind))
    return sorted(found)


def _entered_from_outside(G: Automaton, view: list[int]) -> frozenset[int]:
    """Return the states of ``view`` that a transition from another state than these enters."""
    if len(view) == G.n_states:
        return frozenset()
    inside = np.zeros(G.n_states, np.bool_)
    inside[view] = True
    from_outside = np.repeat(~inside, np.diff(G.offsets))
    return frozenset(np.unique(G.targets[from_outside & inside[G.targets]]).tolist())


def _stopped(supervisor: Supervisor | None, G: Automaton, walk: _Walk, q: int) -> tuple[Label, ...]:
    """Return the events that do not happen at ``q``: disabled there, or refused to the path."""
    refused = None if walk.refused is None or walk.refused[0] != q else G.alphabet[walk.refused[1]]
    stopped = [] if supervisor is None else list(supervisor.pattern(q).disabled)
    if refused is not None and refused not in stopped:
        stopped.append(refused)
    return tuple(Label(event, disabled=True, highlighted=event == refused) for event in stopped)
