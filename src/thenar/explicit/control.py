"""Control: what a supervisor can enforce."""

from __future__ import annotations

import numpy as np

from thenar._native import kernel
from thenar.errors import InputError
from thenar.explicit.exploration import Automata, Exploration, Extract, as_tuple, common_alphabet, ticker
from thenar.explicit.products import sync
from thenar.explicit.rows import kept, row_offsets, sources
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.limits import Limits, Progress
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace

__all__ = ["allows", "closed_loop", "condat", "followed", "forbidden", "is_controllable", "obeyed", "supcon"]


def supcon(
    plant: Automata,
    spec: Automata,
    *,
    name: str = "supC",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return sup C(E, G): the largest controllable, nonblocking part of what ``plant`` does and ``spec`` allows.

    Several plants, or specifications, stand for their synchronous product, which is never built on its own.
    An event that only specifications have is one that no plant hinders; one that nothing has never happens.
    The states are those of the product that survive, numbered breadth-first.  Time O(|δ|) per round; one or
    two rounds for most models, O(|Q|) in the worst case.  Empty (0 states) when no supervisor exists:
    :func:`synthesize` says why.

    Raises AlphabetClash if an event is controllable in one and uncontrollable in another, LimitReached at a
    limit.   [Ramadge and Wonham 1987; Wonham and Cai 2019, sec. 3.5]

    >>> from thenar.library.classics import small_factory
    >>> problem = small_factory()
    >>> supcon(problem.plants, problem.specs).n_states
    12
    """
    plants, specs = as_tuple(plant), as_tuple(spec)
    alphabet = common_alphabet((*plants, *specs))
    if any(a.is_empty for a in (*plants, *specs)):
        return Automaton.empty(alphabet, name)
    tick = ticker(limits, progress)
    exploration = Exploration(plants, specs, alphabet, tick)
    exploration.native.fixpoint(tick)
    return exploration.extract(name, tick).automaton


def is_controllable(
    spec: Automata, plant: Automata, *, limits: Limits | None = None, progress: Progress | None = None
) -> Check:
    """Return whether L(spec)Σ_uc ∩ L(plant) ⊆ L(spec), on the strings that both can do.

    The witness is a shortest trace of both, followed by an uncontrollable event that the plant can do and a
    specification forbids.  O(|δ|) of their product.   [Wonham and Cai 2019, sec. 3.4]

    >>> plant = Automaton.from_transitions(["0 -go-> 1 -slip-> 2"], initial="0", uncontrollable=["slip"])
    >>> spec = Automaton.from_transitions([], initial="0", alphabet=["slip"], uncontrollable=["slip"], name="DRY")
    >>> print(is_controllable(spec, plant))
    controllable: no after go, slip: the plant can do uncontrollable 'slip', which 'DRY' forbids in state '0'
    """
    plants, specs = as_tuple(plant), as_tuple(spec)
    if any(a.is_empty for a in (*plants, *specs)):
        return Check("controllable", True)
    alphabet = common_alphabet((*plants, *specs))
    exploration = Exploration(plants, specs, alphabet, ticker(limits, progress))
    broken = _first_broken(exploration)
    if broken is None:
        return Check("controllable", True)
    trace, event, by, q = broken
    why = f"the plant can do uncontrollable {event!r}, which {by.name!r} forbids in state {by.states[q]!r}"
    return Check("controllable", False, Trace([*trace, event]), why)


def condat(plant: Automata, supervisor: Automaton) -> Supervisor:
    """Return ``supervisor`` with its feedback map: the controllable events that it must disable in each state.

    An event is disabled in x if the plant can do it after some trace that leads the supervisor to x, and the
    supervisor cannot (TCT's condat).  O(|δ|) of the closed loop.

    Raises InputError if the supervisor would have to disable an uncontrollable event.

    >>> from thenar.library.classics import small_factory
    >>> problem = small_factory()
    >>> condat(problem.plants, supcon(problem.plants, problem.specs))
    Supervisor: 12 states, 25 transitions, 6 disablements
    """
    plants = as_tuple(plant)
    alphabet = common_alphabet((*plants, supervisor))
    if supervisor.is_empty or any(a.is_empty for a in plants):
        offsets = np.zeros(supervisor.n_states + 1, np.int64)
        return Supervisor(supervisor, offsets, np.zeros(0, np.int32))
    exploration, loop = followed(plants, supervisor, alphabet, ticker())
    local = exploration.coordinates(loop.origin)[:, -1]
    x = np.repeat(local, np.diff(loop.disabled_offsets))
    own = supervisor.alphabet
    in_supervisor = np.array([own.index(e) if e in own else -1 for e in alphabet.names], np.int64)
    pairs = np.unique(np.stack([x, in_supervisor[loop.disabled]], axis=1), axis=0)
    offsets = row_offsets(np.bincount(pairs[:, 0], minlength=supervisor.n_states))
    return Supervisor(supervisor, offsets, pairs[:, 1].astype(np.int32))


def followed(
    plants: tuple[Automaton, ...], supervisor: Automaton, alphabet: Alphabet, tick: kernel.Ticker
) -> tuple[Exploration, Extract]:
    """Return the closed loop of ``plants`` and ``supervisor``, whose states are the last coordinates; none is empty.

    Raises InputError if the supervisor would have to disable an uncontrollable event.
    """
    exploration = Exploration(plants, (supervisor,), alphabet, tick)
    broken = _first_broken(exploration)
    if broken is not None:
        trace, event, *_ = broken
        raise InputError(f"after {trace} the supervisor {supervisor.name!r} disables uncontrollable event {event!r}")
    return exploration, exploration.extract("", tick)


def closed_loop(
    plant: Automata, supervisor: Supervisor, *, limits: Limits | None = None, progress: Progress | None = None
) -> Automaton:
    """Return the supervised system S/G: an event happens if the plant can do it, S follows it, and ψ enables it.

    States are pairs of plant and supervisor states, numbered breadth-first.  O(|δ|) of the result.  Make a
    Supervisor of an automaton by :func:`condat`.

    Raises AlphabetClash if an event has two meanings, LimitReached at a limit.   [Ramadge and Wonham 1987]

    >>> from thenar.library.classics import small_factory
    >>> problem = small_factory()
    >>> closed_loop(problem.plants, condat(problem.plants, supcon(problem.plants, problem.specs)))
    Automaton 'S/G': 12 states (1 marked), 25 transitions, 8 events
    """
    return sync(*as_tuple(plant), obeyed(supervisor), name="S/G", limits=limits, progress=progress)


def obeyed(supervisor: Supervisor) -> Automaton:
    """Return the supervisor's automaton without the transitions that its feedback map disables.

    >>> from thenar.synthesis.api import synthesize
    >>> from thenar.library.classics import small_factory
    >>> supervisor = synthesize(small_factory()).supervisor
    >>> obeyed(supervisor) is supervisor.automaton
    True
    """
    s = supervisor.automaton
    n, k = s.n_states, len(s.alphabet)
    disabled = np.repeat(np.arange(n), np.diff(supervisor.disabled_offsets)) * k + supervisor.disabled
    keep = ~np.isin(sources(s) * k + s.events, disabled)
    return s if keep.all() else kept(s, keep)


def forbidden(exploration: Exploration, state: int, *, uncontrollable_only: bool) -> list[tuple[str, Automaton, int]]:
    """Return (event, specification, its state) for each event that a specification forbids in ``state``.

    Only events that all plants can do there; in the order of the alphabet, then of the specifications.
    """
    plants, specs = exploration.local(state)
    found = []
    for event in exploration.alphabet:
        if uncontrollable_only and event.controllable:
            continue
        if all(allows(p, q, event.name) for p, q in plants):
            found += [(event.name, s, q) for s, q in specs if not allows(s, q, event.name)]
    return found


def _first_broken(exploration: Exploration) -> tuple[Trace, str, Automaton, int] | None:
    """Return a shortest trace to where an uncontrollable event is forbidden: that event, by whom, in which state."""
    path = exploration.shortest(exploration.native.illegal)
    if path is None:
        return None
    event, by, q = forbidden(exploration, path[-1][1] if path else 0, uncontrollable_only=True)[0]
    return Trace(e for e, _ in path), event, by, q


def allows(automaton: Automaton, state: int, event: str) -> bool:
    """Return whether ``automaton`` can do ``event`` in ``state``, or has no say in it."""
    return event not in automaton.alphabet or automaton.step(state, event) is not None
