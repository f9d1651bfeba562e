"""Slow, obvious twins of supervisor reduction, the infimal controllable superlanguage, and relative closure.

Each function is its definition, or a published algorithm, written down with dictionaries and sets.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import combinations

from thenar.model.automaton import Automaton
from thenar.model.trace import Check
from thenar.testing.graphs import Graph, State, read, write
from thenar.testing.oracle import reachable, sync

__all__ = ["fewest_cells", "infcon", "is_relatively_closed", "sup_relatively_closed", "supreduce"]

Automata = Automaton | Iterable[Automaton]
Cells = list[set[State]]

# -- supervisor reduction ----------------------------------------------------------------------------------


@dataclass
class _Duty:
    """What the closed loop asks of one state: events that happen, events that must not, whether it is marked."""

    happens: dict[str, State] = field(default_factory=dict)
    disabled: set[str] = field(default_factory=set)
    marked: bool | None = None  # None: the plant never is


def supreduce(plants: Automata, supervisor: Automaton) -> Automaton:
    """Return the reduction of ``supervisor`` by the algorithm of Su and Wonham, states taken breadth-first.

    [Discrete Event Dynamic Systems 14(1), 2004, sec. 3.4]

    >>> G = Automaton.from_transitions(["0 -a-> 1 -b-> 0 -b-> 2"], initial="0", marked=["0"])
    >>> S = Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", marked=["0"])
    >>> supreduce(G, S).n_states
    2
    """
    duties = _duties(plants, supervisor)
    cell = {x: {x} for x in duties}
    order = list(duties)
    place = {x: k for k, x in enumerate(order)}

    def first(x: State) -> int:
        return min(place[y] for y in cell[x])

    for k, x in enumerate(order):
        for j in range(k + 1, len(order)):
            if first(x) < k:
                break
            if first(order[j]) == j and (merged := _merged(duties, cell, x, order[j])) is not None:
                cell = merged
    return _quotient(duties, list({id(c): c for c in cell.values()}.values()), supervisor)


def fewest_cells(plants: Automata, supervisor: Automaton) -> int:
    """Return how many cells the smallest control congruence has: every partition of the states is looked at.

    >>> S = Automaton.from_transitions(["0 -a-> 1 -b-> 0"], initial="0", marked=["0"])
    >>> fewest_cells(S, S)
    1
    """
    duties = _duties(plants, supervisor)
    return min(len(cells) for cells in _partitions(list(duties)) if _is_control_cover(duties, cells))


def _duties(plants: Automata, supervisor: Automaton) -> dict[State, _Duty]:
    """Return what the closed loop asks of each state that it leads to, breadth-first in the supervisor."""
    plant, guide = read(sync(*_several(plants))), read(supervisor)
    duties: defaultdict[State, _Duty] = defaultdict(_Duty)
    pairs = {(plant.initial, guide.initial): None} if plant.step and guide.step else {}
    queue = list(pairs)
    for q, x in queue:
        duty = duties[x]
        if q in plant.marked:
            duty.marked = x in guide.marked
        for e in (plant.alphabet | guide.alphabet).names:
            if e in plant.alphabet and e not in plant.step[q]:
                continue
            if e in guide.alphabet and e not in guide.step[x]:
                duty.disabled.add(e)
                continue
            after = (plant.step[q].get(e, q), guide.step[x].get(e, x))
            if e in guide.alphabet:
                duty.happens[e] = after[1]
            if after not in pairs:
                pairs[after] = None
                queue.append(after)
    names = guide.alphabet.names
    step = {x: {e: duty.happens[e] for e in names if e in duty.happens} for x, duty in duties.items()}
    order = Graph(guide.alphabet, guide.initial, step, set(), {}).shortest_traces()
    return {x: duties[x] for x in order}


def _consistent(a: _Duty, b: _Duty) -> bool:
    return (
        a.disabled.isdisjoint(b.happens)
        and b.disabled.isdisjoint(a.happens)
        and (a.marked is None or b.marked is None or a.marked == b.marked)
    )


def _merged(
    duties: dict[State, _Duty], cell: dict[State, set[State]], x: State, y: State
) -> dict[State, set[State]] | None:
    """Return the cells when those of x and y are one, and what then must be; None if that cannot be."""
    cell = dict(cell)
    waiting = [(x, y)]
    while waiting:
        x, y = waiting.pop()
        if cell[x] is cell[y]:
            continue
        together = cell[x] | cell[y]
        for a, b in combinations(together, 2):
            if not _consistent(duties[a], duties[b]):
                return None
            shared = duties[a].happens.keys() & duties[b].happens.keys()
            waiting += [(duties[a].happens[e], duties[b].happens[e]) for e in shared]
        cell |= dict.fromkeys(together, together)
    return cell


def _is_control_cover(duties: dict[State, _Duty], cells: Cells) -> bool:
    for cell in cells:
        for a, b in combinations(cell, 2):
            if not _consistent(duties[a], duties[b]):
                return False
            for e in duties[a].happens.keys() & duties[b].happens.keys():
                x, y = duties[a].happens[e], duties[b].happens[e]
                if not any(x in c and y in c for c in cells):
                    return False
    return True


def _partitions(states: list[State]) -> Iterator[Cells]:
    """Yield every partition of ``states``."""
    if not states:
        yield []
        return
    x, *others = states
    for cells in _partitions(others):
        yield [{x}, *cells]
        for k, cell in enumerate(cells):
            yield [*cells[:k], {x, *cell}, *cells[k + 1 :]]


def _quotient(duties: dict[State, _Duty], cells: Cells, supervisor: Automaton) -> Automaton:
    number = {x: k for k, cell in enumerate(cells) for x in cell}
    step: dict[State, dict[str, State]] = {k: {} for k in range(len(cells))}
    for x, duty in duties.items():
        step[number[x]] |= {e: number[y] for e, y in duty.happens.items()}
    marked = {number[x] for x, duty in duties.items() if duty.marked}
    names = {k: str(k) for k in range(len(cells))}
    initial = number.get(supervisor.initial, -1)
    return reachable(write(Graph(supervisor.alphabet, initial, step, marked, names)))


# -- the infimal controllable superlanguage ----------------------------------------------------------------


def infcon(plants: Automata, specs: Automata) -> Automaton:
    """Return an automaton of (L(G) ∩ L(E))Σ_uc* ∩ L(G), marked where the plants are.

    >>> G = Automaton.from_transitions(["0 -u-> 1 -a-> 2"], initial="0", marked=["1"], uncontrollable=["u"])
    >>> E = Automaton.from_transitions([], initial="0", events=G.alphabet, alphabet=["u"])
    >>> list(infcon(G, E).transitions())
    [('0|0', 'u', '1|out')]
    """
    plants = _several(plants)
    plant, legal = read(sync(*plants)), read(sync(*plants, *_several(specs)))
    out = object()
    initial = (plant.initial, legal.initial)
    step: dict[State, dict[str, State]] = {}
    queue = [initial] if legal.step else []
    for q, x in queue:
        if (q, x) in step:
            continue
        step[q, x] = {}
        for e in legal.alphabet:
            if e.name in plant.alphabet and e.name not in plant.step[q]:
                continue
            after = out if x is out else legal.step[x].get(e.name, out)
            if after is not out or not e.controllable:
                step[q, x][e.name] = (plant.step[q].get(e.name, q), after)
        queue += step[q, x].values()
    names = {(q, x): f"{plant.names[q]}|out" if x is out else legal.names[x] for q, x in step}
    return write(Graph(legal.alphabet, initial, step, {(q, x) for q, x in step if q in plant.marked}, names))


# -- relative closure --------------------------------------------------------------------------------------


def is_relatively_closed(specs: Automata, plants: Automata) -> Check:
    """Return whether every prefix of a string of K = Lm(G) ∩ Lm(E) that is in Lm(G) is in K.

    >>> G = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["0", "1"])
    >>> E = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["1"])
    >>> print(is_relatively_closed(E, G))
    relatively closed: no after ε: only the plant marks it
    """
    product, unmarked = _product(plants, specs)
    blocking = product.blocking()
    for x, trace in product.shortest_traces().items():
        if x in unmarked and x not in blocking:
            return Check("relatively closed", False, trace, "only the plant marks it")
    return Check("relatively closed", True)


def sup_relatively_closed(plants: Automata, specs: Automata) -> Automaton:
    """Return K - (Lm(G) - K)Σ*, for K = Lm(G) ∩ Lm(E), as a trim automaton.

    >>> G = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["0", "1"])
    >>> E = Automaton.from_transitions(["0 -a-> 1"], initial="0", marked=["1"])
    >>> sup_relatively_closed(G, E).n_states
    0
    """
    product, unmarked = _product(plants, specs)
    rest = product.without(unmarked)
    rest = rest.without(rest.blocking())
    return write(rest.without(rest.unreachable()))


def _product(plants: Automata, specs: Automata) -> tuple[Graph, set[State]]:
    """Return the product, and its states in which the plants alone are marked."""
    everything_marked = [
        Automaton.from_arrays(e.alphabet, e.offsets, e.events, e.targets, marked=[True] * e.n_states, initial=e.initial)
        for e in _several(specs)
    ]
    plants = _several(plants)
    product = read(sync(*plants, *_several(specs)))
    unmarked = read(sync(*plants, *everything_marked)).marked - product.marked
    return product, unmarked


def _several(automata: Automata) -> list[Automaton]:
    return [automata] if isinstance(automata, Automaton) else list(automata)
