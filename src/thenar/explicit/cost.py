"""What it costs to reach a marked state: at best, in the worst case, and with which choices."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from heapq import heapify, heappop, heappush
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import InputError, UnknownName
from thenar.explicit.exploration import ticker
from thenar.explicit.rows import row_offsets, sources
from thenar.model.automaton import Automaton
from thenar.model.limits import Limits, Progress
from thenar.model.trace import Trace

__all__ = [
    "Case",
    "CostToGo",
    "Costs",
    "cheapest_trace",
    "cost_to_go",
    "least_cost",
    "numbers_of_events",
    "settle",
    "settled_choices",
]

Costs: TypeAlias = Mapping[str, float | Fraction]
"""A number for each event by its name; an event that is not mentioned has 1."""

Case: TypeAlias = Literal["best", "expected", "worst"]
_SAME_SUM = 1e-9  # relative; costs that differ by less are the same, for sums of floats depend on their order
_EXACT = 2.0**53  # whole numbers up to here are added without rounding
_LARGEST = float(np.finfo(np.float64).max)
_LOOK = 10_000  # states between two looks at the limits


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class CostToGo:
    """The least cost of the way from each state to a marked one, and the choices that have this cost.

    * ``automaton``, ``case``: what was asked
    * ``values``: (n_states,) float64, 0 in marked states, infinite where no choice is sure to lead to one, or where
      the expected cost is above 1.8e308
    * ``chosen``: (n_transitions,) bool, the controllable transitions that have the least cost
    * ``waits``: (n_states,) bool, where the least cost is also had by starting nothing
    * ``error``: the values are right within this share of them; 0 up to rounding but for expected costs, where it
      is a bound, and a loose one if costs differ by many orders of magnitude, see :mod:`thenar.explicit.chance`

    Where the value is infinite nothing is better than anything else, and in a marked state the way is at its end:
    there all transitions are ``chosen``.

    >>> lamp = Automaton.from_transitions(["off -on-> lit", "off -wait-> off"], initial="off", marked=["lit"])
    >>> found = cost_to_go(lamp, {"on": 2.5})
    >>> found.value, found.values.tolist(), found.choices(0)
    (2.5, [2.5, 0.0], ('on',))
    """

    automaton: Automaton
    case: Case
    values: NDArray[np.float64]
    chosen: NDArray[np.bool_]
    waits: NDArray[np.bool_]
    error: float = 0.0

    def __post_init__(self) -> None:
        for array in (self.values, self.chosen, self.waits):
            array.flags.writeable = False

    @property
    def value(self) -> float:
        """The cost from the initial state; infinite if there is no state."""
        return float(self.values[self.automaton.initial]) if self.automaton.n_states else math.inf

    def choices(self, state: str | int) -> tuple[str, ...]:
        """Return the controllable events that have the least cost in ``state``, in the order of the alphabet.

        Raises UnknownName for a name, or a number, that is no state's.
        """
        a = self.automaton
        q = a.state(state)
        lo, hi = a.offsets[q], a.offsets[q + 1]
        events = a.events[lo:hi][self.chosen[lo:hi]].tolist()
        return tuple(a.alphabet[e].name for e in events if a.alphabet[e].controllable)

    def __repr__(self) -> str:
        return f"CostToGo ({self.case}): {self.value:g} from the initial state"


def cost_to_go(
    automaton: Automaton,
    costs: Costs | None = None,
    *,
    case: Case = "best",
    weights: Costs | None = None,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> CostToGo:
    """Return the least cost V(q) of the way from each state q of a closed loop to a marked one.

    Each event costs what ``costs`` says, 0 or more, 1 where it says nothing; the way ends in the first marked state.
    In an unmarked state somebody who wants to get there cheaply may start one of the controllable events or
    *wait*: where uncontrollable events are enabled, one of them will come if nothing is started, and one may
    come before what is started.  With U the uncontrollable events of q, q·e the state that e enters and
    v(e) = cost(e) + V(q·e),

    * ``"best"``: everything happens as one would wish, V(q) = min v(e).  O(|δ| log |Q|).   [Dijkstra 1959; Passino
      and Antsaklis 1989]
    * ``"worst"``: what comes is what costs most.  V(q) = max {v(u): u ∈ U}, for to wait is never worse than to start
      something that others may come before; if U is empty V(q) = min v(e).  Infinite where the adversary can
      keep away from the marked states for ever.  O(|δ| log |Q|).   [Knuth 1977; Sengupta and Lafortune 1998]
    * ``"expected"``: what comes first is drawn by ``weights``, 1 where they say nothing, among U and the event
      that was started: V(q) is the least mean, see :mod:`thenar.explicit.chance`.   [Bertsekas and Tsitsiklis 1991]

    An uncontrollable event of weight 0 never comes; a controllable one of weight inf comes before all others.

    A choice has the least cost if v(e) = V(q), in the worst case where U is not empty if v(e) ≤ V(q): it does no
    harm; but each choice must come nearer.  So an event of cost 0 must lead to a state with fewer events to go.
    Whole numbers are compared exactly, other sums as equal within 1e-9 of them, expected costs within 1e-8.

    Raises UnknownName for an event that the automaton does not have, InputError for a number below 0, none at all or
    too large to be added up, LimitReached at a limit.

    >>> way = ["home -fly-> there", "home -drive-> road -jam-> late -walk-> there", "road -arrive-> there"]
    >>> trip = Automaton.from_transitions(way, initial="home", marked=["there"], uncontrollable=["jam", "arrive"])
    >>> costs = {"fly": 5, "drive": 3, "arrive": 0, "jam": 1, "walk": 4}
    >>> for case in ("best", "worst", "expected"):
    ...     found = cost_to_go(trip, costs, case=case, weights={"jam": 0.1, "arrive": 0.9})
    ...     print(found, found.choices(0))
    CostToGo (best): 3 from the initial state ('drive',)
    CostToGo (worst): 5 from the initial state ('fly',)
    CostToGo (expected): 3.5 from the initial state ('drive',)
    """
    return least_cost(automaton, costs, case, weights, ticker(limits, progress))


def least_cost(
    automaton: Automaton, costs: Costs | None, case: Case, weights: Costs | None, tick: kernel.Ticker
) -> CostToGo:
    """Return what :func:`cost_to_go` returns, as part of a longer computation."""
    if case not in get_args(Case):
        raise UnknownName("case", case, get_args(Case))
    price = numbers_of_events("costs", automaton, costs)
    odds = numbers_of_events("weights", automaton, weights)
    if case == "expected":
        from thenar.explicit.chance import expected_cost

        return expected_cost(automaton, price, odds, tick)
    return _sure_cost(automaton, price, case, tick)


def cheapest_trace(
    automaton: Automaton, costs: Costs | None = None, to: str | int | None = None
) -> tuple[Trace, float] | None:
    """Return a trace of least cost from the initial state to the state ``to``, or to any marked one, and its cost.

    None if there is none.  Of several the one with the fewest events, of these the first in the order of the
    alphabet.  O(|δ| log |Q|).  Errors as for :func:`cost_to_go`.   [Dijkstra 1959]

    >>> a = Automaton.from_transitions(["0 -x-> 1 -y-> 2", "0 -z-> 2"], initial="0", marked=["2"])
    >>> cheapest_trace(a), cheapest_trace(a, {"z": 3})
    ((Trace('z'), 1.0), (Trace('x, y'), 2.0))
    """
    goal = automaton.marked if to is None else np.arange(automaton.n_states) == automaton.state(to)
    price = numbers_of_events("costs", automaton, costs)
    paid, counts = price[automaton.events], np.ones(automaton.n_transitions, np.bool_)
    value, steps = settle(automaton, goal, paid, counts, False, ticker())
    if automaton.is_empty or not math.isfinite(value[automaton.initial]):
        return None
    q, total, names = automaton.initial, float(value[automaton.initial]), []
    while steps[q]:
        onward = (way for way in automaton.row(q) if steps[way[1]] == steps[q] - 1)
        event, q = next((e, t) for e, t in onward if value[t] + price[e] == value[q])
        names.append(automaton.alphabet[event].name)
    return Trace(names), total


def numbers_of_events(
    what: Literal["costs", "weights"], automaton: Automaton, given: Costs | None
) -> NDArray[np.float64]:
    """Return (len(alphabet),) float64: the cost, or weight, of each event, checked."""
    numbers = np.ones(len(automaton.alphabet))
    most = _LARGEST / max(automaton.n_states, 1) if what == "costs" else _LARGEST
    for name, value in (given or {}).items():
        number = value.item() if isinstance(value, np.generic) else value
        k = automaton.alphabet.index(name)
        is_weight = what == "weights" and automaton.alphabet[k].controllable
        if not (isinstance(number, (int, float, Fraction)) and 0 <= number and (is_weight or number < math.inf)):
            raise InputError(f"{what} of event {name!r}: {number!r} is no number from 0 on")
        if is_weight and not number:
            raise InputError(f"{what} of event {name!r}: a controllable event of weight 0 could never be started")
        if most < number < math.inf:
            raise InputError(f"{what} of event {name!r}: a number above {most:.2g} is too large to be added up")
        numbers[k] = float(number)
    return numbers


def settled_choices(
    automaton: Automaton, nearer: NDArray[np.bool_], values: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return ``chosen`` and ``waits`` of a CostToGo from the transitions that bring ``nearer`` at least cost."""
    source = sources(automaton)
    free = automaton.alphabet.uncontrollable[automaton.events] if automaton.n_transitions else nearer
    waits = np.zeros(automaton.n_states, np.bool_)
    waits[source[free & nearer]] = True
    over = automaton.marked | np.isinf(values)
    waits[over] = True
    return over[source] | (nearer & ~free), waits


def _sure_cost(automaton: Automaton, price: NDArray[np.float64], case: Case, tick: kernel.Ticker) -> CostToGo:
    """Return the cost if everything goes well, or if everything goes wrong."""
    a, source = automaton, sources(automaton)
    counts = np.ones(a.n_transitions, np.bool_)
    free = a.alphabet.uncontrollable[a.events] if a.n_transitions else counts
    if case == "worst":
        exposed = np.zeros(a.n_states, np.bool_)
        exposed[source[free]] = True
        counts = free | ~exposed[source]
    paid = price[a.events]
    value, steps = settle(a, a.marked, paid, counts, case == "worst", tick)
    here, there = value[source], value[a.targets]
    comes_nearer = (there < here) | ((there == here) & (steps[a.targets] < steps[source]))
    is_exact = (paid % 1 == 0).all() and paid.max(initial=0.0) * a.n_states <= _EXACT
    nearer = np.isfinite(here) & comes_nearer & (paid + there <= here * (1.0 if is_exact else 1.0 + _SAME_SUM))
    return CostToGo(a, case, value, *settled_choices(a, nearer, value))


def settle(
    automaton: Automaton,
    goal: NDArray[np.bool_],
    paid: NDArray[np.float64],
    counts: NDArray[np.bool_],
    adverse: bool,
    tick: kernel.Ticker,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return cost and number of events of the way from each state to ``goal``, infinite and 0 where there is none.

    ``paid``, (n_transitions,), is what each transition costs; only those of the mask ``counts`` are looked at.  A
    state takes the best of them, but with ``adverse`` the worst of the uncontrollable ones where it has some.  States
    are settled in the order of their (cost, events): a number that grows with each of those that it comes from, so
    that those are settled first.
    """
    a, n = automaton, automaton.n_states
    source = sources(a)
    used = np.flatnonzero(counts & ~goal[source])
    used = used[np.argsort(a.targets[used], kind="stable")]
    enters = row_offsets(np.bincount(a.targets[used], minlength=n)).tolist()
    leaves, fees = source[used].tolist(), paid[used].tolist()
    to_come = np.zeros(n, np.int64)
    if adverse:
        to_come = np.bincount(source[used][a.alphabet.uncontrollable[a.events[used]]], minlength=n)
    missing, value, steps = to_come.tolist(), [math.inf] * n, [0] * n
    worst, settled = [(-1.0, 0)] * n, [False] * n
    heap = [(0.0, 0, q) for q in np.flatnonzero(goal).tolist()]
    heapify(heap)
    for q in np.flatnonzero(goal).tolist():
        value[q] = 0.0
    found = looked = 0
    while heap:
        cost, events, q = heappop(heap)
        if settled[q]:
            continue
        settled[q] = True
        found += 1
        if found - looked >= _LOOK:
            looked = found
            tick.look(found, enters[q])
        for k in range(enters[q], enters[q + 1]):
            p, sum_ = leaves[k], cost + fees[k]
            if missing[p]:
                missing[p] -= 1
                worst[p] = max(worst[p], (sum_, events + 1))
                if missing[p]:
                    continue
                value[p], steps[p] = worst[p]
                heappush(heap, (*worst[p], p))
            elif sum_ < value[p] or (sum_ == value[p] and events + 1 < steps[p]):
                value[p], steps[p] = sum_, events + 1
                heappush(heap, (sum_, events + 1, p))
    return np.array(value, np.float64), np.array(steps, np.int64)
