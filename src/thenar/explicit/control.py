"""Control: what a supervisor can enforce."""

from __future__ import annotations

import numpy as np

from thenar.errors import InputError
from thenar.explicit.kernel import Automata, Exploration, as_tuple, ticker
from thenar.explicit.products import sync
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, merge
from thenar.model.limits import Limits, Progress
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace

__all__ = ["closed_loop", "condat", "is_controllable", "supcon"]


def supcon(
    plant: Automata,
    spec: Automata,
    *,
    name: str = "",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return sup C(E, G): the largest controllable, nonblocking part of what ``plant`` does and ``spec`` allows.

    Several plants, or specifications, stand for their synchronous product, which is never built on its own.
    The states are those of the product that survive, numbered breadth-first, as TCT's supcon gives them.
    Time O(|δ|) per round, one round for most models; empty (0 states) when no supervisor exists:
    :func:`synthesize` says why.

    Raises AlphabetClash if an event is controllable in one and uncontrollable in another, LimitReached at a
    limit.   [Ramadge and Wonham 1987; Wonham and Cai 2019, sec. 3.5]

    >>> from thenar.library.classics import small_factory
    >>> problem = small_factory()
    >>> supcon(problem.plants, problem.specs).n_states
    12
    """
    plants, specs = as_tuple(plant), as_tuple(spec)
    alphabet = common_alphabet(plants, specs)
    if any(a.is_empty for a in (*plants, *specs)):
        return Automaton.empty(alphabet, name)
    exploration = Exploration(plants, specs, alphabet, ticker(limits, progress))
    exploration.native.fixpoint(True, exploration.tick)
    return exploration.extract(name or "supC").automaton


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
    alphabet = common_alphabet(plants, specs)
    exploration = Exploration(plants, specs, alphabet, ticker(limits, progress))
    path = exploration.shortest(exploration.native.illegal)
    if path is None:
        return Check("controllable", True)
    event, by, q = forbidden(exploration, len(plants), path[-1][1] if path else 0)[0]
    why = f"the plant can do uncontrollable {event!r}, which {by.name!r} forbids in state {by.states[q]!r}"
    return Check("controllable", False, Trace([*(e for e, _ in path), event]), why)


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
    alphabet = common_alphabet(plants, (supervisor,))
    if supervisor.is_empty or any(a.is_empty for a in plants):
        offsets = np.zeros(supervisor.n_states + 1, np.int64)
        return Supervisor(supervisor, offsets, np.zeros(0, np.int32))
    exploration = Exploration(plants, (supervisor,), alphabet, ticker(None, None))
    path = exploration.shortest(exploration.native.illegal)
    if path is not None:
        event = forbidden(exploration, len(plants), path[-1][1] if path else 0)[0][0]
        trace = Trace(e for e, _ in path)
        raise InputError(f"after {trace} the supervisor {supervisor.name!r} disables uncontrollable event {event!r}")
    loop = exploration.extract("")
    local = exploration.coordinates(loop.origin)[:, -1]
    x = np.repeat(local, np.diff(loop.disabled_offsets))
    in_supervisor = np.array([supervisor.alphabet.index(e) if e in supervisor.alphabet else -1 for e in alphabet.names])
    pairs = np.unique(np.stack([x, in_supervisor[loop.disabled]], axis=1), axis=0)
    offsets = np.concatenate(([0], np.cumsum(np.bincount(pairs[:, 0], minlength=supervisor.n_states))))
    return Supervisor(supervisor, offsets.astype(np.int64), pairs[:, 1].astype(np.int32))


def closed_loop(
    plant: Automata,
    supervisor: Supervisor | Automaton,
    *,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Automaton:
    """Return the supervised system S/G, in which an event happens if the plant can do it and S enables it.

    States are pairs of plant and supervisor states.  O(|δ|) of the result.
    """
    automaton = supervisor.automaton if isinstance(supervisor, Supervisor) else supervisor
    return sync(*as_tuple(plant), automaton, name="S/G", limits=limits, progress=progress)


def common_alphabet(plants: tuple[Automaton, ...], specs: tuple[Automaton, ...]) -> Alphabet:
    """Return the union of the alphabets, in order of first mention."""
    automata = (*plants, *specs)
    return merge([a.alphabet for a in automata], [a.name or "an automaton without a name" for a in automata])


def forbidden(exploration: Exploration, n_plants: int, state: int) -> list[tuple[str, Automaton, int]]:
    """Return (event, specification, its state) for each uncontrollable event that a specification forbids in ``state``.

    Only events that all plants can do there; in the order of the alphabet, then of the specifications.
    """
    local = exploration.coordinates([state])[0].tolist()
    plants = list(zip(exploration.parts[:n_plants], local[:n_plants], strict=True))
    specs = list(zip(exploration.parts[n_plants:], local[n_plants:], strict=True))
    found = []
    for event in exploration.alphabet:
        if event.controllable or not all(allows(p, q, event.name) for p, q in plants):
            continue
        found += [(event.name, s, q) for s, q in specs if not allows(s, q, event.name)]
    return found


def allows(automaton: Automaton, state: int, event: str) -> bool:
    """Return whether ``automaton`` can do ``event`` in ``state``, or has no say in it."""
    return event not in automaton.alphabet or automaton.step(state, event) is not None
