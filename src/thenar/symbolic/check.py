"""Properties of a symbolic supervisor, found out again on the diagrams."""

from __future__ import annotations

from thenar.symbolic.synthesis import SymbolicSupervisor

__all__ = ["is_controllable", "is_nonblocking"]


def is_controllable(supervisor: SymbolicSupervisor) -> bool:
    """Return whether uncontrollable events are all allowed and lead nowhere but to states of the supervisor.

    >>> from thenar.library.classics import agv
    >>> from thenar.synthesis.api import synthesize
    >>> is_controllable(synthesize(agv(), "symbolic").symbolic)
    True
    """
    encoding, states = supervisor.encoding, supervisor.controlled
    free = [e for e in encoding.events if not e.controllable]
    if states & encoding.forest.any_of([e.possible - e.allowed for e in free], encoding.tick):
        return False
    if any(states - required for required in encoding.requirements):
        return False
    forward = encoding.forest.saturation([e.relation for e in free])
    return forward(states, supervisor.reachable, encoding.tick) == states


def is_nonblocking(supervisor: SymbolicSupervisor) -> bool:
    """Return whether every state of the supervisor has a way to a marked one.

    >>> from thenar.library.classics import agv
    >>> from thenar.synthesis.api import synthesize
    >>> is_nonblocking(synthesize(agv(), "symbolic").symbolic)
    True
    """
    forest, states = supervisor.encoding.forest, supervisor.controlled
    steps = [
        forest.restrict(e.relation, supervisor.enabled(e)) if e.choice else e.relation
        for e in supervisor.encoding.events
    ]
    backward = forest.saturation([forest.inverse(r) for r in steps])
    return backward(supervisor.encoding.marked & states, states, supervisor.encoding.tick) == states
