"""Before a supervisor moves anything: is it fit to be executed?"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from thenar.explicit.control import closed_loop, is_controllable
from thenar.explicit.reach import is_nonblocking, path_to
from thenar.explicit.rows import kept, sources
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check

__all__ = ["fit_to_run"]


def fit_to_run(supervisor: Supervisor, plant: Automaton, commands: Iterable[str] = ()) -> list[Check]:
    """Return what must hold before ``supervisor`` is executed on ``plant``, each with its evidence.

    A supervisor exists; S allows every uncontrollable event that the plant can do; S/G is nonblocking; ψ disables
    no uncontrollable event; and no cycle of S/G consists of ``commands`` only: events that take no time, so that
    it could go round for ever in one instant.  O(|δ|) of S/G.

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
    commands end: yes
    """
    exists = Check("a supervisor exists", not supervisor.is_empty, reason="its automaton has no states")
    if not exists:
        return [exists]
    loop = closed_loop(plant, supervisor)
    return [
        Check("a supervisor exists", True),
        is_controllable(supervisor.automaton, plant),
        is_nonblocking(loop),
        _disables_no_uncontrollable(supervisor),
        _commands_end(loop, commands),
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


def _commands_end(loop: Automaton, commands: Iterable[str]) -> Check:
    """Return whether the part of the loop that only has ``commands`` has no cycle."""
    title = "commands end"
    instant = np.zeros(len(loop.alphabet), np.bool_)
    instant[[loop.alphabet.index(name) for name in commands if name in loop.alphabet]] = True
    burst = kept(loop, instant[loop.events])
    cyclic = _on_the_way_to_a_cycle(burst)
    path = path_to(loop, cyclic)
    if path is None:
        return Check(title, True)
    trace, q = path
    cycle: list[str] = []
    seen: dict[int, int] = {}
    while q not in seen:  # each state on the way to a cycle has a successor that is
        seen[q] = len(cycle)
        event, q = next((e, t) for e, t in burst.row(q) if cyclic[t])
        cycle.append(burst.alphabet[event].name)
    again = ", ".join(cycle[seen[q] :])
    return Check(title, False, trace + cycle, f"the commands {again} can follow each other without end")


def _on_the_way_to_a_cycle(automaton: Automaton) -> NDArray[np.bool_]:
    """Return (n_states,) bool: what is left when states without successors are taken away again and again."""
    alive = np.ones(automaton.n_states, np.bool_)
    source = sources(automaton)
    while True:
        successors = np.zeros(automaton.n_states, np.bool_)
        successors[source[alive[automaton.targets]]] = True
        if (left := alive & successors).sum() == alive.sum():
            return alive
        alive = left
