"""A short name of what a supervisor and its plant say, by which a log knows them again."""

from __future__ import annotations

import hashlib

from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor

__all__ = ["identity"]


def identity(supervisor: Supervisor, plant: Automaton) -> str:
    """Return twelve hexadecimal digits that differ for another supervisor or another plant (SHA-256, cut).

    >>> from thenar.explicit.products import sync
    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> problem = small_factory()
    >>> supervisor, plant = synthesize(problem).supervisor, sync(*problem.plants)
    >>> identity(supervisor, plant) == identity(supervisor, plant) != identity(supervisor, supervisor.automaton)
    True
    """
    digest = hashlib.sha256()
    for automaton in (supervisor.automaton, plant):
        digest.update(repr([(e.name, e.controllable) for e in automaton.alphabet]).encode())
        arrays = automaton.offsets, automaton.events, automaton.targets, automaton.marked
        digest.update(b"".join(a.tobytes() for a in arrays) + str(automaton.initial).encode())
    digest.update(supervisor.disabled_offsets.tobytes() + supervisor.disabled.tobytes())
    return digest.hexdigest()[:12]
