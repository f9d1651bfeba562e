"""The policy of least cost: of the events that may be started, one on the cheapest way to a marked state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from thenar.errors import InputError
from thenar.explicit.cost import Case, Costs, cost_to_go, numbers_of_events
from thenar.explicit.rows import row_offsets
from thenar.model.automaton import Automaton
from thenar.model.names import Numbered
from thenar.model.supervisor import Supervisor
from thenar.runtime.cells import Cells, unfold

__all__ = ["Cheapest"]

MAX_GOALS = 8  # the plan holds every subset of the goal events


class Cheapest:
    """Chooses what leads at least cost to a marked state, each of ``through`` having happened since the last one.

    What events cost, and what can come in between, are those of :func:`~thenar.explicit.cost.cost_to_go`.  Where
    the ``case`` that was asked for has no finite cost it goes the way that is cheapest at best, and where not all
    of ``through`` can happen any more the one to any marked state.  It waits where all that may be started costs
    more than to wait, and ends in the first marked state that is a goal.  Of choices that cost the same it takes the
    first in the alphabet.  The plan serves any number of runs; it takes cost_to_go on 2^|through| |X| states.

    :class:`~thenar.runtime.plan.Shortest` counts seconds instead, and asks the driver for them.  Raises InputError
    without a supervisor or for more than 8 events in ``through``, and what cost_to_go raises.

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> supervisor = synthesize(small_factory()).supervisor
    >>> policy = Cheapest(supervisor, {"break_2": 5}, case="worst", through=["finish_2"])
    >>> policy.choose(0, [supervisor.automaton.alphabet.index("start_1")], may_wait=False)
    0
    """

    name = "cheapest"
    __slots__ = ("_automaton", "_cell", "_plans", "_price")

    def __init__(
        self,
        supervisor: Supervisor,
        costs: Costs | None = None,
        *,
        case: Case = "best",
        weights: Costs | None = None,
        through: Sequence[str] = (),
    ) -> None:
        if supervisor.is_empty:
            raise InputError("there is nothing to plan: no supervisor exists for this problem")
        S = supervisor.automaton
        goals = list(dict.fromkeys(S.alphabet.index(name) for name in through))
        if len(goals) > MAX_GOALS:
            raise InputError(f"a plan goes through at most {MAX_GOALS} events, not {len(goals)}")
        cells = unfold(supervisor, goals)
        anywhere = _as_automaton(cells, S)
        task = replace(anywhere, marked=anywhere.marked & (cells.done == (1 << len(goals)) - 1))
        #: what is tried first, second and last
        self._plans = [cost_to_go(task, costs, case=case, weights=weights)]
        if case != "best":
            self._plans.append(cost_to_go(task, costs))
        if goals:
            self._plans.append(cost_to_go(anywhere, costs))
        self._automaton, self._price, self._cell = anywhere, numbers_of_events("costs", S, costs), 0

    def begin(self) -> None:
        """Forget the last run."""
        self._cell = self._automaton.initial

    def saw(self, event: int, state: int) -> None:
        """Follow ``event``."""
        self._cell = dict(self._automaton.row(self._cell))[event]

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        """Return the choice of least cost; None to wait, or to end where the way ends."""
        plan = next((p for p in self._plans if np.isfinite(p.values[self._cell])), self._plans[-1])
        if plan.automaton.marked[self._cell]:
            return None
        best = plan.choices(self._cell)
        ready = [e for e in choices if self._automaton.alphabet[e].name in best]
        if ready or (may_wait and plan.waits[self._cell]):
            return ready[0] if ready else None
        # what is best cannot be started now: the next best can
        target = dict(self._automaton.row(self._cell))
        return min(choices, key=lambda e: (self._price[e] + plan.values[target[e]], e), default=None)


def _as_automaton(cells: Cells, S: Automaton) -> Automaton:
    """Return the cells as an automaton that is marked where ``S`` is."""
    n = len(cells.state)
    return Automaton(
        "",
        S.alphabet,
        0,
        row_offsets(np.bincount(cells.source, minlength=n)),
        cells.event.astype(np.int32),
        cells.target.astype(np.int32),
        S.marked[cells.state],
        Numbered(np.arange(n)),
    )
