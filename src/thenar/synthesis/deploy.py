"""Before a supervisor moves anything: is it fit to be executed?"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from thenar.explicit.control import closed_loop, is_controllable
from thenar.explicit.forcing import ForcingSupervisor, is_forcibly_controllable
from thenar.explicit.reach import is_nonblocking, path_to
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check
from thenar.synthesis.implementation import has_bounded_response

__all__ = ["fit_to_run"]


def fit_to_run(supervisor: Supervisor, plant: Automaton, commands: Iterable[str] = ()) -> list[Check]:
    """Return what must hold before ``supervisor`` is executed on ``plant``, each with its evidence.

    A supervisor exists; S allows every uncontrollable event that the plant can do, or forces another one to come
    before it; S/G is nonblocking; ψ disables no uncontrollable event; and no cycle of S/G consists of ``commands``
    only: events that take no time, so that it could go round for ever in one instant.  O(|δ| log |Q|) of S/G.  What a
    program with a scan cycle needs besides, :func:`~thenar.synthesis.implementation.fit_for_sampling` checks.

    >>> from thenar.explicit.products import sync
    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> problem = small_factory()
    >>> for check in fit_to_run(synthesize(problem).supervisor, sync(*problem.plants)):
    ...     print(check)
    a supervisor exists: yes
    controllable: yes
    nonblocking: yes
    uncontrollable events enabled: yes
    bounded response: yes
    """
    exists = Check("a supervisor exists", not supervisor.is_empty, reason="its automaton has no states")
    if not exists:
        return [exists]
    loop = closed_loop(plant, supervisor)
    return [
        Check("a supervisor exists", True),
        is_forcibly_controllable(supervisor.automaton, plant, preempted=supervisor.preempted)
        if isinstance(supervisor, ForcingSupervisor)
        else is_controllable(supervisor.automaton, plant),
        is_nonblocking(loop),
        _disables_no_uncontrollable(supervisor),
        has_bounded_response(loop, [name for name in commands if name in loop.alphabet]),
    ]


def _disables_no_uncontrollable(supervisor: Supervisor) -> Check:
    title, S = "uncontrollable events enabled", supervisor.automaton
    free = S.alphabet.uncontrollable[supervisor.disabled]
    owner = np.repeat(np.arange(S.n_states), np.diff(supervisor.disabled_offsets))
    goal = np.zeros(S.n_states, np.bool_)
    goal[owner[free]] = True
    path = path_to(S, goal)
    if path is None:
        return Check(title, True)
    trace, state = path
    name = next(e.name for e in supervisor.pattern(state).disabled if not e.controllable)
    return Check(title, False, trace, f"uncontrollable {name!r} is disabled in supervisor state {state}")
