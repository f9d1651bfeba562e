"""Before a supervisor moves anything: is it fit to be executed?"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from thenar.explicit.control import closed_loop, is_controllable, obeyed
from thenar.explicit.exploration import Exploration, common_alphabet, ticker
from thenar.explicit.forcing import ForcingSupervisor, is_forcibly_controllable
from thenar.explicit.reach import is_nonblocking, path_to
from thenar.explicit.rows import sources
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check
from thenar.synthesis.implementation import has_bounded_response

__all__ = ["fit_to_run"]


def fit_to_run(supervisor: Supervisor, plant: Automaton, commands: Iterable[str] = ()) -> list[Check]:
    """Return what must hold before ``supervisor`` is executed on ``plant``, each with its evidence.

    A supervisor exists; S allows every uncontrollable event that the plant can do, or forces another one to come
    before it; S/G is nonblocking; ψ disables no uncontrollable event; and no cycle of S/G consists of ``commands``
    only: events that take no time, so that it could go round for ever in one instant.  Of a
    :class:`~thenar.explicit.forcing.ForcingSupervisor` also: where it forces, one of the forced events is controllable.
    An uncontrollable one may be forcible, and synthesis relies on that; but no skill is started for it.

    O(|δ| log |Q|) of S/G.  What a program with a scan cycle needs besides,
    :func:`~thenar.synthesis.implementation.fit_for_sampling` checks.  Raises UnknownName for an unknown command.

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
    checks = [Check("a supervisor exists", True)]
    if isinstance(supervisor, ForcingSupervisor):
        checks += [
            is_forcibly_controllable(supervisor.automaton, plant, preempted=supervisor.preempted),
            _can_start_what_it_forces(supervisor, plant),
        ]
    else:
        checks.append(is_controllable(supervisor.automaton, plant))
    return [
        *checks,
        is_nonblocking(loop),
        _disables_no_uncontrollable(supervisor),
        has_bounded_response(loop, commands),
    ]


def _can_start_what_it_forces(supervisor: ForcingSupervisor, plant: Automaton) -> Check:
    title = "forced events can be started"
    parts = (plant, obeyed(supervisor))
    alphabet, tick = common_alphabet(parts), ticker()
    exploration = Exploration(parts, (), alphabet, tick)
    part = exploration.extract("", tick)
    loop, x = part.automaton, exploration.coordinates(part.origin)[:, 1]
    started = np.array([e.controllable and e.forcible for e in alphabet], np.bool_)
    stuck = supervisor.forcing[x]
    stuck[sources(loop)[started[loop.events]]] = False
    path = path_to(loop, stuck)
    if path is None:
        return Check(title, True)
    trace, q = path
    forced = " or ".join(repr(e.name) for e in loop.enabled(q) if e.forcible)
    what = f"{forced} is forced there, which no skill can start" if forced else "nothing is left there to force"
    return Check(title, False, trace, f"{what}: supervisor state {x[q]}")


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
