"""Supervisor reduction: a small supervisor that controls alike, for the whole plant or for each of its parts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import InputError, counted
from thenar.explicit.control import followed, obeyed
from thenar.explicit.exploration import Automata, Exploration, as_tuple, common_alphabet, ticker
from thenar.explicit.rows import kept, row_offsets, sources
from thenar.model.automaton import Automaton
from thenar.model.limits import Limits, Progress
from thenar.model.names import Numbered
from thenar.model.supervisor import Supervisor

__all__ = ["Reduction", "localize", "supreduce"]

EITHER, MARKED, UNMARKED = 0, 1, 2  # what the closed loop asks of a state
MOST_BYTES = 4 << 30  # that a reduction takes if its limits do not say; enough for 130 000 states


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Reduction(Supervisor):
    """A supervisor whose states stand for *cells* of the states of another one, and how few there could be.

    * ``cells``: (n,) int32, the state that stands for each state of the other one; -1 where the plant never gets it
    * ``lower_bound``: no control cover of the other one has fewer cells

    A :class:`Supervisor` like any other: its feedback map says what it disables in the closed loop.

    >>> from thenar.library.classics import transfer_line
    >>> from thenar.synthesis.api import synthesize
    >>> problem = transfer_line()
    >>> small = supreduce(problem.plants, synthesize(problem).supervisor)
    >>> small, small.is_smallest
    (Reduction: 8 states (at least 8), 31 transitions, 11 disablements, True)
    """

    cells: NDArray[np.int32]
    lower_bound: int

    def __post_init__(self) -> None:
        for array in (self.disabled_offsets, self.disabled, self.cells):
            array.flags.writeable = False

    @property
    def is_smallest(self) -> bool:
        """True if ``lower_bound`` proves that no control cover has fewer cells; False if that is not known."""
        return self.n_states == self.lower_bound

    def __repr__(self) -> str:
        if self.is_empty:
            return "Reduction: no supervisor exists"
        sizes = f"{counted(self.n_states, 'state')} (at least {self.lower_bound:,})"
        moves = counted(self.n_transitions, "transition")
        return f"Reduction: {sizes}, {moves}, {counted(len(self.disabled), 'disablement')}"


def supreduce(
    plant: Automata,
    supervisor: Supervisor | Automaton,
    *,
    name: str = "",
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Reduction:
    """Return a supervisor with few states that controls ``plant`` exactly as ``supervisor`` does.

    L(R) ∩ L(G) = L(S) ∩ L(G), and likewise for Lm.  What is known about where the plant is, and was built into the
    supervisor, is forgotten as far as it makes no difference to what must be disabled.

    Two states are *consistent* if neither enables an event that the other one must disable, and if not one must be
    marked and the other one must not.  A *control cover* is a set of cells of states, consistent pairwise, each event
    leading from all states of a cell into one cell.  To find one with the fewest cells is NP-hard; cells are merged
    greedily, breadth-first as in TCT; then in other orders, until the lower bound is met or, if that takes longer than
    some tenths of a second, sixteen times the work of the first is done.

    The lower bound is the size of a set of states of which no two fit into one cell.  If each state of the supervisor
    goes with one state of the plant, as in what :func:`supcon` returns, it holds for every automaton that controls
    alike.

    Memory n²/4 bytes for n states of the supervisor, at most 4 GiB unless ``limits`` allow more; time mostly O(n²|Σ|).
    Raises InputError if the supervisor would have to disable an uncontrollable event, AlphabetClash if an event has
    two meanings, LimitReached at a limit.
    [Su and Wonham, Discrete Event Dynamic Systems 14(1), 2004; Vaz and Wonham, Int. J. Control 44(2), 1986]

    >>> from thenar.explicit.control import closed_loop, supcon
    >>> from thenar.library.classics import small_factory
    >>> problem = small_factory()
    >>> small = supreduce(problem.plants, supcon(problem.plants, problem.specs))
    >>> small.n_states, small.lower_bound, closed_loop(problem.plants, small).n_states
    (2, 2, 12)
    """
    automaton = obeyed(supervisor) if isinstance(supervisor, Supervisor) else supervisor
    plants = as_tuple(plant)
    tick = _ticker(limits, progress)
    if automaton.is_empty or any(p.is_empty for p in plants):
        return _nothing(automaton, name or automaton.name)
    return _merged(_Duties.of(plants, automaton, tick), name or automaton.name, tick)


def localize(
    plants: Automata,
    supervisor: Supervisor | Automaton,
    *,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> tuple[Reduction, ...]:
    """Return one local controller for each of ``plants``, which together control as ``supervisor`` does.

    L(G) ∩ L(R1) ∩ ... ∩ L(Rn) = L(S) ∩ L(G), and likewise for Lm.  A controllable event belongs to the first plant that
    has it, and only the controller of that plant ever disables it.  Each is found as in :func:`supreduce`, where only
    its own events count as disabled.  What its own plant does and what it has to be told by others is its
    alphabet: events that never move it, and that it never disables, are left out.

    Cost and errors as for :func:`supreduce`, once for each plant; InputError as well for a disabled event that no
    plant has.   [Cai and Wonham, IEEE TAC 55(3), 2010; Cai and Wonham, Supervisor Localization, 2016]

    >>> from thenar.explicit.control import supcon
    >>> from thenar.library.classics import small_factory
    >>> problem = small_factory()
    >>> for controller in localize(problem.plants, supcon(problem.plants, problem.specs)):
    ...     print(controller.automaton.name, controller.n_states, *controller.automaton.alphabet.names)
    LOC_MACHINE1 2 start_1 finish_1 start_2
    LOC_MACHINE2 2 finish_1 start_2
    """
    automaton = obeyed(supervisor) if isinstance(supervisor, Supervisor) else supervisor
    parts = as_tuple(plants)
    names = [f"LOC_{p.name}" for p in parts]
    if automaton.is_empty or any(p.is_empty for p in parts):
        return tuple(_nothing(automaton, name) for name in names)
    tick = _ticker(limits, progress)
    duties = _Duties.of(parts, automaton, tick)
    alphabet = automaton.alphabet
    owner = np.array([next((k for k, p in enumerate(parts) if e in p.alphabet), -1) for e in alphabet.names], np.int64)
    owners = owner[duties.disabled]
    if (owners < 0).any():
        stray = alphabet[int(duties.disabled[np.argmin(owners)])].name
        raise InputError(f"localize: {stray!r}, which {automaton.name!r} disables, is in no plant; add one that has it")
    return tuple(
        _listening(_merged(duties.only(owners == k), name, tick), own=owner == k) for k, name in enumerate(names)
    )


@dataclass(frozen=True, slots=True)
class _Duties:
    """What the closed loop asks of a supervisor: in each state, numbered breadth-first, what must happen and what not.

    * ``moves``: the transitions that happen in the closed loop
    * ``origin``: (n_states,) int64, what the supervisor calls the state
    * ``n_origins``: how many states the supervisor has
    * ``disabled_offsets``, ``disabled``: as in :class:`Supervisor`
    * ``mark``: (n_states,) uint8, EITHER where the plant is never marked
    """

    moves: Automaton
    origin: NDArray[np.int64]
    n_origins: int
    disabled_offsets: NDArray[np.int64]
    disabled: NDArray[np.int32]
    mark: NDArray[np.uint8]

    @staticmethod
    def of(plants: tuple[Automaton, ...], supervisor: Automaton, tick: kernel.Ticker) -> _Duties:
        """Return what the closed loop of ``plants`` asks of ``supervisor``."""
        alphabet, own = common_alphabet((*plants, supervisor)), supervisor.alphabet
        exploration, loop = followed(plants, supervisor, alphabet, tick)
        *at, x = exploration.coordinates(loop.origin).T
        place = np.array([own.index(e) if e in own else -1 for e in alphabet.names], np.int64)
        event = place[loop.automaton.events]
        happens = (x[sources(loop.automaton)] * len(own) + event)[event >= 0]
        moves = kept(supervisor, np.isin(sources(supervisor) * len(own) + supervisor.events, happens))
        marked = np.all([p.marked[q] for p, q in zip(plants, at, strict=True)], axis=0)
        mark = np.full(supervisor.n_states, EITHER, np.uint8)
        mark[x[marked]] = np.where(supervisor.marked[x[marked]], MARKED, UNMARKED)
        part, origin = _breadth_first(moves, tick)
        number = np.empty(supervisor.n_states, np.int64)
        number[origin] = np.arange(len(origin))
        source = number[np.repeat(x, np.diff(loop.disabled_offsets))]
        offsets, disabled = _rows(source, place[loop.disabled], part)
        return _Duties(part, origin, supervisor.n_states, offsets, disabled, mark[origin])

    def only(self, which: NDArray[np.bool_]) -> _Duties:
        """Return these duties with only ``which``, (len(disabled),) bool, of the events disabled."""
        source = np.repeat(np.arange(self.moves.n_states), np.diff(self.disabled_offsets))
        offsets, disabled = _rows(source[which], self.disabled[which], self.moves)
        return replace(self, disabled_offsets=offsets, disabled=disabled)


def _merged(duties: _Duties, name: str, tick: kernel.Ticker) -> Reduction:
    """Return the quotient by a small control cover, numbered breadth-first."""
    moves, width = duties.moves, len(duties.moves.alphabet)
    cell, lower_bound = kernel.reduce(
        moves.offsets,
        moves.events,
        moves.targets,
        width,
        duties.disabled_offsets,
        duties.disabled,
        duties.mark,
        tick,
    )
    n = int(cell.max()) + 1
    keys, edge = np.unique(cell[sources(moves)] * np.int64(width) + moves.events, return_index=True)
    marked = np.zeros(n, np.bool_)
    marked[cell[duties.mark == MARKED]] = True
    quotient = Automaton(
        name,
        moves.alphabet,
        int(cell[0]),
        row_offsets(np.bincount(keys // max(width, 1), minlength=n)),
        moves.events[edge],
        cell[moves.targets[edge]],
        marked,
        Numbered(np.arange(n)),
    )
    small, before = _breadth_first(quotient, tick)
    number = np.empty(n, np.int32)
    number[before] = np.arange(n)
    cells = np.full(duties.n_origins, -1, np.int32)
    cells[duties.origin] = number[cell]
    source = number[cell[np.repeat(np.arange(moves.n_states), np.diff(duties.disabled_offsets))]]
    offsets, disabled = _rows(source, duties.disabled, small)
    return Reduction(replace(small, states=Numbered(np.arange(n))), offsets, disabled, cells, lower_bound)


def _listening(controller: Reduction, own: NDArray[np.bool_]) -> Reduction:
    """Return ``controller`` so that it hinders nothing else than it disables, over the events that concern it.

    What the closed loop never does in a state is looped there; then events that are looped in all states are left out.
    """
    a = controller.automaton
    n, width = a.n_states, len(a.alphabet)
    every = np.arange(n)[:, None]
    table = np.repeat(every, width, axis=1).astype(np.int32)
    disabled_in = np.repeat(np.arange(n), np.diff(controller.disabled_offsets))
    table[disabled_in, controller.disabled] = -1
    table[sources(a), a.events] = a.targets
    heard = np.flatnonzero((table != every).any(axis=0))
    alphabet = a.alphabet.restrict(a.alphabet[int(e)].name for e in heard)
    source, event = np.nonzero(table[:, heard] >= 0)
    place = np.cumsum(np.isin(np.arange(width), heard)) - 1
    local = replace(
        a,
        alphabet=alphabet,
        offsets=row_offsets(np.bincount(source, minlength=n)),
        events=event.astype(np.int32),
        targets=table[source, heard[event]],
    )
    return replace(controller, automaton=local, disabled=place[controller.disabled].astype(np.int32))


def _ticker(limits: Limits | None, progress: Progress | None) -> kernel.Ticker:
    """Start the clock of one reduction, whose memory grows with the square of its states."""
    limits = limits or Limits()
    return ticker(limits if limits.bytes is not None else replace(limits, bytes=MOST_BYTES), progress)


def _nothing(supervisor: Automaton, name: str) -> Reduction:
    """Return the reduction of what lets nothing happen, not even ε."""
    cells = np.full(supervisor.n_states, -1, np.int32)
    return Reduction(Automaton.empty(supervisor.alphabet, name), np.zeros(1, np.int64), np.zeros(0, np.int32), cells, 0)


def _rows(
    state: NDArray[np.integer], event: NDArray[np.integer], automaton: Automaton
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Return offsets and events, each once, of the rows that pairs (state, event) make over a state space."""
    width = max(len(automaton.alphabet), 1)
    keys = np.unique(state.astype(np.int64) * width + event)
    return row_offsets(np.bincount(keys // width, minlength=automaton.n_states)), (keys % width).astype(np.int32)


def _breadth_first(automaton: Automaton, tick: kernel.Ticker) -> tuple[Automaton, NDArray[np.int64]]:
    """Return the reachable part, numbered breadth-first, and the number that each of its states had before."""
    exploration = Exploration((automaton,), (), automaton.alphabet, tick)
    part = exploration.extract(automaton.name, tick)
    return part.automaton, exploration.coordinates(part.origin)[:, 0]
