"""Properties of a symbolic supervisor, found out again on the diagrams."""

from __future__ import annotations

from thenar.symbolic.synthesis import SymbolicSupervisor

__all__ = ["is_controllable", "is_nonblocking"]


def is_controllable(supervisor: SymbolicSupervisor) -> bool:
    """Return whether every uncontrollable event that the plants can do is allowed and stays within the supervisor.

    One image for each event: nothing of the synthesis is taken on trust but what events do.

    >>> from thenar.library.classics import agv
    >>> from thenar.synthesis.api import synthesize
    >>> is_controllable(synthesize(agv(), "symbolic").symbolic)
    True
    """
    forest, states = supervisor.encoding.forest, supervisor.controlled
    for event in supervisor.encoding.events:
        if event.controllable:
            continue
        inside = states & event.possible
        if inside - event.allowed or (forest.image(inside, event.relation) & supervisor.reachable) - states:
            return False
    return not any(states - required for required in supervisor.encoding.requirements)


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
