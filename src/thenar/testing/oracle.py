"""Slow, obvious twins of the operations on automata: what the fast ones are compared with.

Everything here is dictionaries and sets, and each function is its definition written down.  The cost grows
with the square of the number of states or worse: fine up to some thousands.

States are numbered breadth-first from the initial state in the order of the alphabet, and called as the
fast operations call them: ``x|y`` in a product, ``{x, y}`` for a set of states.  Wherever a function takes
plants or specs it takes one automaton or several.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import reduce
from operator import or_

import numpy as np

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace
from thenar.testing.graphs import Graph, State, read, write

__all__ = [
    "closed_loop",
    "complement",
    "condat",
    "coreachable",
    "is_controllable",
    "is_nonblocking",
    "is_nonconflicting",
    "isomorphic",
    "language",
    "meet",
    "minimize",
    "project",
    "reachable",
    "same_languages",
    "supcon",
    "sync",
    "trim",
]

Automata = Automaton | Iterable[Automaton]

# -- products ----------------------------------------------------------------------------------------------


def sync(*automata: Automaton, alphabet: Alphabet | None = None) -> Automaton:
    """Return the synchronous product A1 ∥ A2 ∥ ...: an event happens in all automata that know it, at once.

    ``alphabet`` orders the events, and so numbers the states; by default, in order of first mention.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", marked=["0"])
    >>> B = Automaton.from_transitions(["0 -b-> 1 -c-> 0"], initial="0", marked=["0"])
    >>> list(sync(A, B).transitions())
    [('0|0', 'a', '1|0'), ('1|0', 'b', '0|1'), ('0|1', 'a', '1|1'), ('0|1', 'c', '0|0'), ('1|1', 'c', '1|0')]
    """
    return write(_product([read(a) for a in automata], alphabet))


def meet(*automata: Automaton) -> Automaton:
    """Return A1 ∩ A2 ∩ ...: an event happens in all automata at once; one that some automaton does not
    know never happens.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", marked=["0"])
    >>> B = Automaton.from_transitions(["0 -a-> 1 -c-> 0"], initial="0", marked=["0"])
    >>> list(meet(A, B).transitions())
    [('0|0', 'a', '1|1')]
    """
    alphabet = _union(read(a) for a in automata)
    return write(_product([replace(read(a), alphabet=alphabet) for a in automata]))


def _product(graphs: Sequence[Graph], alphabet: Alphabet | None = None) -> Graph:
    """Return the reachable part of the synchronous product, events in the order of ``alphabet``."""
    alphabet = _union(graphs) if alphabet is None else alphabet.restrict(_union(graphs).names)
    initial = tuple(g.initial for g in graphs)
    step: dict[State, dict[str, State]] = {}
    queue = [initial] if all(g.step for g in graphs) else []
    for x in queue:  # grows while it is read
        if x in step:
            continue
        step[x] = {}
        for e in alphabet.names:
            y = tuple(g.step[q].get(e) if e in g.alphabet else q for g, q in zip(graphs, x, strict=True))
            if None not in y:
                step[x][e] = y
                queue.append(y)
    marked = {x for x in step if all(q in g.marked for g, q in zip(graphs, x, strict=True))}
    names = {x: "|".join(g.names[q] for g, q in zip(graphs, x, strict=True)) for x in step}
    return Graph(alphabet, initial, step, marked, names)


def _union(graphs: Iterable[Graph]) -> Alphabet:
    return reduce(or_, (g.alphabet for g in graphs), Alphabet())


# -- reachability ------------------------------------------------------------------------------------------


def reachable(automaton: Automaton) -> Automaton:
    """Return ``automaton`` without the states that no string leads to."""
    graph = read(automaton)
    return write(graph.without(graph.unreachable()))


def coreachable(automaton: Automaton) -> Automaton:
    """Return ``automaton`` without the states from which no marked state can be reached."""
    graph = read(automaton)
    return write(graph.without(graph.blocking()))


def trim(automaton: Automaton) -> Automaton:
    """Return the reachable and coreachable part of ``automaton``.

    >>> A = Automaton.from_transitions(["0 -a-> done", "0 -b-> stuck", "lost -a-> done"], initial="0", marked=["done"])
    >>> list(trim(A).transitions())
    [('0', 'a', 'done')]
    """
    return reachable(coreachable(automaton))


def is_nonblocking(automaton: Automaton) -> Check:
    """Return whether a marked state can be reached from every state that can be reached."""
    graph = read(automaton)
    blocking = graph.blocking()
    for x, trace in graph.shortest_traces().items():
        if x in blocking:
            return Check("nonblocking", False, trace, "no marked state can be reached")
    return Check("nonblocking", True)


def is_nonconflicting(*automata: Automaton) -> Check:
    """Return whether A1 ∥ A2 ∥ ... is nonblocking."""
    check = is_nonblocking(sync(*automata))
    return Check("nonconflicting", check.holds, check.witness, check.reason)


# -- control -----------------------------------------------------------------------------------------------


def supcon(plants: Automata, specs: Automata = (), *, alphabet: Alphabet | None = None) -> Automaton:
    """Return the supremal controllable, nonblocking sublanguage of what ``plants`` can do and ``specs`` allow.

    From the product of all of them, remove the states at which the plants can do an uncontrollable event
    that is not allowed or leads to a removed state, and those from which no marked state can be reached any
    more, until none is left to remove.  An event that no plant knows is one that they do not hinder.

    >>> arrows = ["0 -a-> 1 -u-> 2", "0 -b-> 2"]
    >>> G = Automaton.from_transitions(arrows, initial="0", marked=["2"], uncontrollable=["u"])
    >>> never_u = Automaton.from_transitions([], initial="0", marked=["0"], alphabet=["u"], events=G.alphabet)
    >>> list(supcon(G, never_u).transitions())
    [('0|0', 'b', '2|0')]
    """
    plant = _read_all(plants)
    graph = _product([*plant, *_read_all(specs)], alphabet)
    uncontrollable = [e.name for e in graph.alphabet if not e.controllable]
    while True:
        violating = {x for x in graph.step if any(_can(plant, x, e) and e not in graph.step[x] for e in uncontrollable)}
        if not (removed := violating | graph.blocking()):
            return write(graph.without(graph.unreachable()))
        graph = graph.without(removed)


def is_controllable(specs: Automata, plants: Automata) -> Check:
    """Return whether ``specs`` allow every uncontrollable event that ``plants`` can do while they are obeyed.

    The witness ends with an event that they do not allow.

    >>> G = Automaton.from_transitions(["0 -a-> 1 -u-> 0"], initial="0", marked=["0"], uncontrollable=["u"])
    >>> E = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["1"], events=G.alphabet, alphabet=["u"])
    >>> print(is_controllable(E, G))
    controllable: no after a, u: the plant can do u, which is not allowed
    """
    plant = _read_all(plants)
    graph = _product([*plant, *_read_all(specs)])
    for x, trace in graph.shortest_traces().items():
        for e in graph.alphabet:
            if not e.controllable and _can(plant, x, e.name) and e.name not in graph.step[x]:
                reason = f"the plant can do {e.name}, which is not allowed"
                return Check("controllable", False, Trace([*trace, e.name]), reason)
    return Check("controllable", True)


def condat(plants: Automata, automaton: Automaton) -> Supervisor:
    """Return the supervisor that disables what ``plants`` can do and ``automaton`` does not follow."""
    plant = _read_all(plants)
    graph = _product([*plant, read(automaton)])
    rows: list[list[int]] = [[] for _ in range(automaton.n_states)]
    for k, e in enumerate(automaton.alphabet):
        at = {x[-1] for x in graph.step if _can(plant, x, e.name) and e.name not in graph.step[x]}
        for q in at if e.controllable else ():
            rows[q].append(k)
    offsets = np.cumsum([0, *(len(row) for row in rows)])
    return Supervisor(automaton, offsets, np.array([k for row in rows for k in row], np.int32))


def closed_loop(plants: Automata, supervisor: Supervisor) -> Automaton:
    """Return S/G: what ``plants`` do when each event needs the permission ψ of the ``supervisor``.

    It is marked where both are.  Raises ValueError when the supervisor permits an event that it cannot follow itself.
    """
    s = supervisor.automaton
    plant = _product(_read_all(plants))
    guide = read(s)
    known = set(s.alphabet.names)
    step: dict[State, dict[str, State]] = {}
    queue = [(plant.initial, s.initial)] if plant.step and guide.step else []
    for p, x in queue:
        if (p, x) in step:
            continue
        step[p, x] = {}
        for e, target in plant.step[p].items():
            if e in known and not supervisor.psi(e, x):
                continue
            if e in known and e not in guide.step[x]:
                raise ValueError(f"at {guide.names[x]!r} the supervisor permits {e!r}, and has no transition for it")
            step[p, x][e] = (target, guide.step[x][e] if e in known else x)
            queue.append(step[p, x][e])
    marked = {(p, x) for p, x in step if p in plant.marked and x in guide.marked}
    names = {(p, x): f"{plant.names[p]}|{guide.names[x]}" for p, x in step}
    return write(Graph(plant.alphabet | s.alphabet, (plant.initial, s.initial), step, marked, names))


def _can(plants: Sequence[Graph], x: tuple[State, ...], event: str) -> bool:
    """Return whether every plant that knows ``event`` can do it; the plants lie first in the product state x."""
    return all(event in g.step[q] for g, q in zip(plants, x, strict=False) if event in g.alphabet)


def _read_all(automata: Automata) -> list[Graph]:
    return [read(a) for a in ([automata] if isinstance(automata, Automaton) else automata)]


# -- condensing --------------------------------------------------------------------------------------------


def project(automaton: Automaton, events: Iterable[str]) -> Automaton:
    """Return the natural projection on ``events``: what an observer sees who sees only these.

    A state is the set of states in which the automaton may be.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -hidden-> 2 -b-> 0"], initial="0", marked=["2"])
    >>> list(project(A, ["a", "b"]).transitions())
    [('0', 'a', '{1, 2}'), ('{1, 2}', 'b', '0')]
    """
    graph = read(automaton)
    seen = automaton.alphabet.restrict(events)

    def unseen_closure(states: Iterable[State]) -> frozenset[State]:
        queue = list(states)
        for x in queue:
            queue += [y for e, y in graph.step[x].items() if e not in seen and y not in queue]
        return frozenset(queue)

    initial = unseen_closure([graph.initial] if graph.step else [])
    step: dict[State, dict[str, State]] = {}
    queue = [initial] if initial else []
    for subset in queue:
        if subset not in step:
            moves = {e: {graph.step[x][e] for x in subset if e in graph.step[x]} for e in seen.names}
            step[subset] = {e: unseen_closure(targets) for e, targets in moves.items() if targets}
            queue += step[subset].values()
    marked = {subset for subset in step if not graph.marked.isdisjoint(subset)}
    return write(Graph(seen, initial, step, marked, {s: _group_name(graph, s) for s in step}))


def minimize(automaton: Automaton) -> Automaton:
    """Return the automaton with the fewest states that has the same closed and the same marked behaviour.

    Tell states apart by marking, then by the classes that their events lead to (or that they lack the
    event), until no more can be told apart.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -a-> 2 -a-> 1"], initial="0", marked=["0", "2"])
    >>> list(minimize(A).transitions())
    [('{0, 2}', 'a', '1'), ('1', 'a', '{0, 2}')]
    """
    graph = read(reachable(automaton))
    kind: dict[State, object] = {x: x in graph.marked for x in graph.step}
    while True:
        views = {
            x: (kind[x], tuple(kind.get(row.get(e)) for e in graph.alphabet.names)) for x, row in graph.step.items()
        }
        numbers = {view: k for k, view in enumerate(dict.fromkeys(views.values()))}
        if len(numbers) == len(set(kind.values())):
            break
        kind = {x: numbers[view] for x, view in views.items()}
    classes: dict[object, list[State]] = {}
    for x, k in kind.items():
        classes.setdefault(k, []).append(x)
    return write(
        Graph(
            graph.alphabet,
            kind.get(graph.initial),
            {k: {e: kind[y] for e, y in graph.step[members[0]].items()} for k, members in classes.items()},
            {kind[x] for x in graph.marked},
            {k: _group_name(graph, members) for k, members in classes.items()},
        )
    )


def complement(automaton: Automaton) -> Automaton:
    """Return the automaton with the closed behaviour Σ* that marks what ``automaton`` does not mark.

    Every undefined event leads to a new state ``dump``.

    >>> A = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["0"], alphabet=["b"])
    >>> complement(A)
    Automaton: 3 states (2 marked), 6 transitions, 2 events
    """
    graph = read(reachable(automaton))
    dump = "dump"
    while dump in graph.names.values():
        dump += "'"
    states = [*graph.step, dump]
    step = {x: {e: graph.step.get(x, {}).get(e, dump) for e in graph.alphabet.names} for x in states}
    initial = graph.initial if graph.step else dump
    full = Graph(graph.alphabet, initial, step, set(states) - graph.marked, {**graph.names, dump: dump})
    return write(full.without(full.unreachable()))


def _group_name(graph: Graph, states: Iterable[int]) -> str:
    names = [graph.names[x] for x in sorted(states)]
    return names[0] if len(names) == 1 else "{" + ", ".join(names) + "}"


# -- comparing ---------------------------------------------------------------------------------------------


def language(automaton: Automaton, n: int) -> set[tuple[tuple[str, ...], bool]]:
    """Return every string of at most ``n`` events that ``automaton`` generates, with whether it marks it.

    >>> A = Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", marked=["0"])
    >>> sorted(language(A, 2))
    [((), True), (('a',), False), (('a', 'b'), True)]
    """
    graph = read(automaton)
    strings: dict[tuple[str, ...], State] = {(): graph.initial} if graph.step else {}
    longest = strings
    for _ in range(n):
        longest = {(*s, e): y for s, x in longest.items() for e, y in graph.step[x].items()}
        strings = strings | longest
    return {(s, x in graph.marked) for s, x in strings.items()}


def same_languages(a: Automaton, b: Automaton) -> Check:
    """Return whether L(a) = L(b) and Lm(a) = Lm(b); the witness is a shortest string in one only."""
    g, h = read(a), read(b)
    alphabet = dict.fromkeys([*a.alphabet.names, *b.alphabet.names])
    pairs: dict[tuple[State, State], Trace] = {(g.initial, h.initial): Trace()} if g.step or h.step else {}
    queue = list(pairs)
    for x, y in queue:
        for x_has, y_has, verb in ((x in g.step, y in h.step, "generates"), (x in g.marked, y in h.marked, "marks")):
            if x_has != y_has:
                which = "first" if x_has else "second"
                return Check("same languages", False, pairs[x, y], f"only the {which} {verb} it")
        for e in alphabet:
            successors = (g.step[x].get(e), h.step[y].get(e))
            if successors != (None, None) and successors not in pairs:
                pairs[successors] = Trace([*pairs[x, y], e])
                queue.append(successors)
    return Check("same languages", True)


def isomorphic(a: Automaton, b: Automaton) -> Check:
    """Return whether ``a`` and ``b`` are equal but for the names and numbers of their states.

    They must have the same events; states out of reach do not count.
    """
    if differing := sorted(e.name for e in set(a.alphabet) ^ set(b.alphabet)):
        return Check("isomorphic", False, None, f"the alphabets differ in {', '.join(dict.fromkeys(differing))}")
    if not (check := same_languages(a, b)):
        return Check("isomorphic", False, check.witness, check.reason)
    g, h = read(a), read(b)
    first, second = g.shortest_traces(), h.shortest_traces()
    pairs = [(g.initial, h.initial)] if first else []
    forth, back = dict(pairs), {y: x for x, y in pairs}
    for x, y in pairs:
        for e, target in g.step[x].items():
            twin = h.step[y][e]
            if target not in forth and twin not in back:
                forth[target], back[twin] = twin, target
                pairs.append((target, twin))
            elif forth.get(target) != twin:
                which, earlier = ("first", first[target]) if target in forth else ("second", second[twin])
                reason = f"only the {which} is then in the same state as after {earlier}"
                return Check("isomorphic", False, Trace([*first[x], e]), reason)
    return Check("isomorphic", True)
