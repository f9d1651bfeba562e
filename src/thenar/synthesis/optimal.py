"""Of what a supervisor allows, the choices of least cost: again a supervisor."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from thenar.errors import InputError, counted
from thenar.explicit.control import closed_loop, condat
from thenar.explicit.cost import Case, Costs, CostToGo, least_cost
from thenar.explicit.exploration import Automata, ticker
from thenar.explicit.forcing import ForcingSupervisor
from thenar.explicit.reach import reachable
from thenar.explicit.rows import kept
from thenar.model.limits import Limits, Progress
from thenar.model.supervisor import Supervisor

__all__ = ["optimal_supervisor"]


def optimal_supervisor(
    plant: Automata,
    supervisor: Supervisor,
    costs: Costs | None = None,
    *,
    case: Case = "best",
    weights: Costs | None = None,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> tuple[Supervisor, CostToGo]:
    """Return the supervisor that leaves all choices of least cost, and no others, and the costs in S/G.

    The costs and cases are those of :func:`~thenar.explicit.cost.cost_to_go`, on the closed loop S/G.  What the
    result enables is enabled by ``supervisor``; whoever starts any of the controllable events that it leaves, or
    waits where ``waits`` says so, has the least cost.  With positive costs it is the largest such supervisor:
    each choice that it forbids has a higher cost.  Among events of cost 0 there need not be a largest one, because
    they could lead round in a circle; those are left that come nearer.

    In the worst case no string is longer than it must be: all that the result lets happen from a state of
    finite value reach a marked state, at a cost of at most this value.  Where the value is infinite, and in
    marked states, nothing more is forbidden.  So the result is nonblocking if S/G is.

    O(|δ| log |Q|) of S/G; for expected costs see there.  Errors as for cost_to_go and closed_loop; InputError for a
    supervisor that forces events: who must act at once cannot wait, and what that costs is not defined.
    [Sengupta and Lafortune, SIAM Journal on Control and Optimization 36(2), 1998, without their costs of disabling]

    >>> from thenar.model.automaton import Automaton
    >>> from thenar.model.problem import Problem
    >>> from thenar.synthesis.api import synthesize
    >>> way = ["home -fly,walk-> there", "home -drive-> road -jam-> late -walk-> there", "road -arrive-> there"]
    >>> trip = Automaton.from_transitions(way, initial="home", marked=["there"], uncontrollable=["jam", "arrive"])
    >>> for case in ("best", "worst"):
    ...     least, found = optimal_supervisor(trip, synthesize(Problem(trip)).supervisor,
    ...         {"drive": 3, "jam": 2, "fly": 6, "walk": 6}, case=case)
    ...     print(found.value, least.pattern(0))
    4.0 enabled: drive; disabled: fly, walk
    6.0 enabled: fly, walk; disabled: drive
    """
    if isinstance(supervisor, ForcingSupervisor) and supervisor.forcing.any():
        where = counted(int(supervisor.forcing.sum()), "state")
        raise InputError(
            f"optimal_supervisor: the supervisor forces events in {where}, where nobody may wait; "
            "costs are defined for supervisors that only disable"
        )
    begun = time.perf_counter()
    loop = closed_loop(plant, supervisor, limits=limits, progress=progress)
    found = least_cost(loop, costs, case, weights, ticker(limits, progress, time.perf_counter() - begun))
    free = loop.alphabet.uncontrollable[loop.events] if loop.n_transitions else np.zeros(0, np.bool_)
    best = reachable(kept(loop, free | found.chosen))
    return condat(plant, replace(best, name=supervisor.automaton.name)), found
