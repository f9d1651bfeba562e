"""Slow, obvious twins of timed graphs and of forcing: the definitions, written down over dictionaries and sets.

As in :mod:`thenar.testing.oracle`, of which this is a part: fine up to some thousands of states.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from thenar.explicit.timed import TICK
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.trace import Check, Trace
from thenar.testing.graphs import Graph, State, read, write
from thenar.testing.oracle import sync

__all__ = ["is_activity_loop_free", "is_forcibly_controllable", "supcon_forcing", "timed"]

Automata = Automaton | Iterable[Automaton]


def timed(activities: Automaton, bounds: Mapping[str, tuple[int, int | None]]) -> Automaton:
    """Return the timed transition graph of ``activities``: states are an activity and a timer for every event.

    >>> bus = Automaton.from_transitions(["coming -pass-> gone"], initial="coming", marked=["gone"])
    >>> list(timed(bus, {"pass": (0, 1)}).transitions())[:2]
    [('coming, 1', 'tick', 'coming, 0'), ('coming, 1', 'pass', 'gone, 1')]
    """
    a, alphabet = read(activities), Alphabet([TICK, *activities.alphabet])
    lower, upper, start = {}, {}, {}
    for e in a.alphabet.names:
        lower[e], upper[e] = bounds.get(e, (0, None))
        above = upper[e]
        start[e] = lower[e] if above is None else above

    def after(state: State, event: str) -> State | None:
        """Return the state that ``event`` leads to, None where it is impossible."""
        activity, timers = state[0], dict(state[1])
        possible = a.step[activity]
        if event == TICK.name:
            if any(upper[e] is not None and timers[e] == 0 for e in possible):
                return None
            new = {e: max(timers[e] - 1, 0) if e in possible else start[e] for e in timers}
            return activity, tuple(new.items())
        above = upper[event]
        if event not in possible or timers[event] > (0 if above is None else above - lower[event]):
            return None
        entered = possible[event]
        new = {e: timers[e] if e in a.step[entered] and e != event else start[e] for e in timers}
        return entered, tuple(new.items())

    initial = (a.initial, tuple(start.items()))
    step: dict[State, dict[str, State]] = {}
    queue = [initial] if a.step else []
    for x in queue:  # grows while it is read
        if x not in step:
            step[x] = {e: y for e in alphabet.names if (y := after(x, e)) is not None}
            queue += step[x].values()
    names = {x: ", ".join([a.names[x[0]], *(str(t) for _, t in x[1])]) for x in step}
    return write(Graph(alphabet, initial, step, {x for x in step if x[0] in a.marked}, names))


def is_activity_loop_free(automaton: Automaton, tick: str = TICK.name) -> bool:
    """Return whether no state that can be reached can be reached again from itself without a tick.

    >>> is_activity_loop_free(Automaton.from_transitions(["0 -a-> 1 -tick-> 0"], initial="0"))
    True
    """
    graph = read(automaton)
    for x in graph.shortest_traces():
        reached = {y for e, y in graph.step[x].items() if e != tick}
        while more := {y for z in reached for e, y in graph.step[z].items() if e != tick} - reached:
            reached |= more
        if x in reached:
            return False
    return True


def supcon_forcing(
    plants: Automata, specs: Automata = (), preempted: Collection[str] | None = (TICK.name,)
) -> tuple[Automaton, dict[str, set[str]]]:
    """Return the largest forcibly controllable, nonblocking part, and the events to be forced in each of its states.

    Remove the states in which a condition does not hold, and those from which no marked state can be reached, until
    none is left to remove.  Where an event must be forced, the others that it preempts are gone.

    >>> from thenar.model.events import Event
    >>> alphabet = Alphabet([TICK, Event("stop", forcible=True)])
    >>> G = Automaton.from_transitions(["0 -stop-> 1", "0 -tick-> 2"], initial="0", marked=["1"], events=alphabet)
    >>> supervisor, forced = supcon_forcing(G)
    >>> list(supervisor.transitions()), forced
    ([('0|any', 'stop', '1|any')], {'0|any': {'stop'}})
    """
    graph, possible = _product(plants, specs)
    while True:
        rows, forced, removed = {}, {}, set()
        for x, row in graph.step.items():
            kept = _kept(graph.alphabet, row, possible[x], preempted)
            if kept is None:
                removed.add(x)
            elif kept != row or _missing(graph.alphabet, row, possible[x]):
                rows[x], forced[x] = kept, {e for e in kept if graph.alphabet[e].forcible}
            else:
                rows[x] = row
        controlled = Graph(graph.alphabet, graph.initial, rows, graph.marked - removed, graph.names)
        controlled = controlled.without(removed)
        if blocking := removed | controlled.blocking():
            graph = graph.without(blocking)
            continue
        result = controlled.without(controlled.unreachable())
        return write(result), {graph.names[x]: events for x, events in forced.items() if x in result.step}


def is_forcibly_controllable(
    specs: Automata, plants: Automata, preempted: Collection[str] | None = (TICK.name,)
) -> Check:
    """Return whether both conditions hold after every string that ``specs`` and ``plants`` can do.

    >>> G = Automaton.from_transitions(["0 -u-> 1", "0 -f-> 2"], initial="0", uncontrollable=["u"])
    >>> E = Automaton.from_transitions(["0 -f-> 1"], initial="0", events=G.alphabet, alphabet=["u"])
    >>> print(is_forcibly_controllable(E, G, None))
    forcibly controllable: no after ε: a condition is broken
    """
    graph, possible = _product(plants, specs)
    for x, trace in graph.shortest_traces().items():
        if _kept(graph.alphabet, graph.step[x], possible[x], preempted) != graph.step[x]:
            return Check("forcibly controllable", False, Trace(trace), "a condition is broken")
    return Check("forcibly controllable", True)


def _missing(alphabet: Alphabet, row: dict[str, State], possible: set[str]) -> set[str]:
    """Return the uncontrollable events that the plants can do and that are none of ``row``."""
    return {e for e in possible if not alphabet[e].controllable and e not in row}


def _kept(
    alphabet: Alphabet, row: dict[str, State], possible: set[str], preempted: Collection[str] | None
) -> dict[str, State] | None:
    """Return what is left of ``row`` where the plants can do ``possible``; None if it cannot be controlled."""
    missing = _missing(alphabet, row, possible)
    before_all = set(alphabet.names) if preempted is None else set(preempted)
    if not missing:
        return row
    if not missing <= before_all or not any(alphabet[e].forcible for e in row):
        return None
    return {e: y for e, y in row.items() if e not in before_all or alphabet[e].forcible}


def _product(plants: Automata, specs: Automata) -> tuple[Graph, dict[State, set[str]]]:
    """Return plants || specs, and the events that the plants can do, or do not know, in each state."""
    plants, specs = ([a] if isinstance(a, Automaton) else list(a) for a in (plants, specs))
    anything = Automaton.from_transitions([], initial="any", marked=["any"])
    g, e = read(sync(*plants)), read(sync(*(specs or [anything])))
    alphabet = g.alphabet | e.alphabet
    step: dict[State, dict[str, State]] = {}
    possible: dict[State, set[str]] = {}
    queue = [(g.initial, e.initial)] if g.step and e.step else []
    for x in queue:  # grows while it is read
        if x in step:
            continue
        p, q = x
        possible[x] = {k for k in alphabet.names if k not in g.alphabet or k in g.step[p]}
        step[x] = {
            k: (g.step[p].get(k, p), e.step[q].get(k, q))
            for k in alphabet.names
            if k in possible[x] and (k not in e.alphabet or k in e.step[q])
        }
        queue += step[x].values()
    marked = {(p, q) for p, q in step if p in g.marked and q in e.marked}
    names = {(p, q): f"{g.names[p]}|{e.names[q]}" for p, q in step}
    return Graph(alphabet, (g.initial, e.initial), step, marked, names), possible
