"""Kernels over int arrays; masks are (n,) uint8, automata compressed sparse rows as in thenar.model."""

from collections.abc import Callable, Sequence
from typing import overload

import numpy as np
from numpy.typing import NDArray

class Ticker:
    """Limits of one computation, and what it calls a few times a second with (states, transitions) found so far.

    The computation raises LimitReached at a limit, and whatever the callback raises.  ``spent``: seconds of the limit
    that are gone already.
    """

    def __init__(
        self,
        states: int | None = None,
        transitions: int | None = None,
        bytes: int | None = None,
        seconds: float | None = None,
        progress: Callable[[int, int], object] | None = None,
        spent: float = 0.0,
    ) -> None: ...
    def look(self, states: int, transitions: int) -> None:
        """Do what a kernel does now and then: stop at a limit, call back when it is time."""

class Component:
    """One automaton of a product; ``own`` (n_events,) says which events of the product it takes part in."""

    def __init__(
        self,
        offsets: NDArray[np.int64],
        events: NDArray[np.int32],
        targets: NDArray[np.int32],
        marked: NDArray[np.uint8],
        own: NDArray[np.uint8],
        initial: int,
        plant: bool,
    ) -> None: ...

class Exploration:
    """The reachable part of a product; states that the plants can leave illegally are not expanded."""

    @property
    def n_states(self) -> int: ...
    @property
    def n_transitions(self) -> int: ...
    @property
    def layout(self) -> tuple[list[int], list[int], list[int]]: ...
    @property
    def bytes(self) -> int:
        """What the kernel holds for it."""

    def keys(self, states: NDArray[np.int64]) -> NDArray[np.uint64]:
        """The states of the components in each of ``states``, packed as ``layout`` says: (len(states), words)."""

    @property
    def illegal(self) -> NDArray[np.uint8]: ...
    @property
    def rank(self) -> NDArray[np.int32]: ...
    @property
    def reason(self) -> NDArray[np.uint8]: ...
    def fixpoint(self, ticker: Ticker) -> None: ...
    def extract(
        self, ticker: Ticker
    ) -> tuple[
        NDArray[np.int64],
        NDArray[np.int32],
        NDArray[np.int32],
        NDArray[np.uint8],
        NDArray[np.int64],
        NDArray[np.int64],
        NDArray[np.int32],
    ]:
        """Offsets, events, targets, marked, product state of each state; disabled offsets and events."""

    def conflict(self, ticker: Ticker) -> NDArray[np.uint8]:
        """For each component whether the proof that nothing survives needs it; the plants are not counted."""

    def row(self, state: int) -> list[tuple[int, int]]: ...
    def path(
        self,
        start: int,
        goal: NDArray[np.uint8],
        inside: NDArray[np.uint8],
        uncontrollable_only: bool,
        ticker: Ticker,
    ) -> tuple[list[int], list[int]] | None: ...

def explore(components: Sequence[Component], uncontrollable: NDArray[np.uint8], ticker: Ticker) -> Exploration: ...
def distance_to(
    offsets: NDArray[np.int64],
    events: NDArray[np.int32],
    targets: NDArray[np.int32],
    goal: NDArray[np.uint8],
    ticker: Ticker,
) -> NDArray[np.int32]: ...
def shortest_path(
    offsets: NDArray[np.int64],
    events: NDArray[np.int32],
    targets: NDArray[np.int32],
    initial: int,
    goal: NDArray[np.uint8],
    ticker: Ticker,
) -> list[int] | None: ...
def minimize(
    offsets: NDArray[np.int64],
    events: NDArray[np.int32],
    targets: NDArray[np.int32],
    n_events: int,
    marked: NDArray[np.uint8],
    ticker: Ticker,
) -> NDArray[np.int32]: ...
def words(text: NDArray[np.uint8]) -> tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]:
    """Return the number of each word of ``text``, and where each distinct word begins and ends first.

    Words are what ASCII white space separates; they are numbered as they are first met.
    """

def project(
    offsets: NDArray[np.int64],
    events: NDArray[np.int32],
    targets: NDArray[np.int32],
    n_events: int,
    initial: int,
    marked: NDArray[np.uint8],
    hidden: NDArray[np.uint8],
    ticker: Ticker,
) -> tuple[
    NDArray[np.int64], NDArray[np.int32], NDArray[np.int32], NDArray[np.uint8], NDArray[np.int64], NDArray[np.int64]
]:
    """Offsets, events, targets, marked; member offsets and members of each subset."""

def reduce(
    offsets: NDArray[np.int64],
    events: NDArray[np.int32],
    targets: NDArray[np.int32],
    n_events: int,
    disabled_offsets: NDArray[np.int64],
    disabled: NDArray[np.int32],
    mark: NDArray[np.uint8],
    ticker: Ticker,
) -> tuple[NDArray[np.int32], int]:
    """The cell of each state in a small control cover, and how many cells any has at least.

    All states are reachable from the first; ``mark`` is 1 for one that must be marked, 2 for one that must not be.
    """

def random_reads(n_words: int, n_reads: int, ticker: Ticker) -> float:
    """Independent random reads a second over a table of at least ``n_words`` 8-byte words."""

def stream(n_words: int, ticker: Ticker) -> tuple[float, float]:
    """Bytes a second: written to fresh memory, and read in order."""

class Set:
    """A set of value vectors over the levels of a forest; level n is the top, level 1 the bottom."""

    def __and__(self, other: Set) -> Set: ...
    def __or__(self, other: Set) -> Set: ...
    def __sub__(self, other: Set) -> Set: ...
    def __invert__(self) -> Set: ...
    def __bool__(self) -> bool: ...
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def is_everything(self) -> bool: ...
    @property
    def n_nodes(self) -> int: ...
    @property
    def level(self) -> int: ...
    def count(self) -> int:
        """Size of the set over all levels, exactly."""

    def support(self) -> list[int]:
        """Levels that the set depends on, the top one first."""

    def child(self, value: int) -> Set: ...
    def simplify(self, care: Set) -> Set:
        """A set with few nodes that agrees with this one within ``care``."""

    def forget(self, levels: NDArray[np.uint8]) -> Set:
        """The set with each level k for which ``levels[k]`` is not 0 free to take any value."""

    def factors(self) -> list[Set]:
        """Sets over separate levels whose intersection is this one, the topmost first."""

    def products(self, high: Set, limit: int) -> list[list[tuple[int, list[int]]]] | None:
        """A sum of few products between this set and ``high``: lists of (level, values); None beyond ``limit``."""

    def vectors(self, limit: int) -> NDArray[np.uint32]:
        """At most ``limit`` members in lexicographic order, one after the other, top level first."""

    def dump(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Level of each node from the bottom up, and its children; 0 is nothing, 1 everything, 2 the first node."""

class Saturation:
    """A fixed set of relations, applied until nothing new is found."""

    @overload
    def __call__(self, start: Set, within: Set, ticker: Ticker) -> Set: ...
    @overload
    def __call__(self, start: Set, within: Set, ticker: Ticker, steps: int | None) -> Set | None:
        """What the relations lead to from ``start`` within ``within``; None if ``steps`` are not enough to find out."""

class Forest:
    """Decision diagrams over levels 1 .. len(sizes) with ``sizes[k - 1]`` values at level k.

    Garbage is looked for from ``collect_at`` nodes on.  A relation is a number; 0 never happens, 1 changes
    nothing; a level that it does not mention keeps its value.
    """

    def __init__(self, sizes: NDArray[np.uint32], max_bytes: int, cache_bytes: int, collect_at: int) -> None: ...
    @property
    def nothing(self) -> Set: ...
    @property
    def everything(self) -> Set: ...
    @property
    def n_nodes(self) -> int: ...
    @property
    def peak(self) -> int: ...
    @property
    def collections(self) -> int: ...
    @property
    def work(self) -> int:
        """Steps taken so far: operations on nodes whose result was not known."""

    @property
    def bytes(self) -> int: ...
    max_bytes: int
    def watched_by(self, ticker: Ticker) -> None:
        """Let ``ticker`` stop operations that are given none, if they are long."""

    def collect(self) -> None: ...
    def literal(self, level: int, mask: NDArray[np.uint8]) -> Set: ...
    def table(self, levels: Sequence[int], truth: NDArray[np.uint8]) -> Set:
        """The set over ``levels`` (falling) with characteristic function ``truth`` in row-major order."""

    def any_of(self, sets: Sequence[Set], ticker: Ticker) -> Set: ...
    def all_of(self, sets: Sequence[Set], ticker: Ticker, within: Set | None = None) -> Set: ...
    def shift(self, level: int, source: NDArray[np.uint32], target: NDArray[np.uint32], next: int) -> int:
        """The relation that takes ``source[k]`` to ``target[k]`` at ``level`` and does ``next`` below."""

    def rows(self, levels: Sequence[int], before_after: NDArray[np.uint32]) -> int:
        """The relation of the rows (before, after) of each of ``levels`` (falling), one row after the other."""

    def join(self, a: int, b: int) -> int: ...
    def either(self, a: int, b: int) -> int: ...
    def restrict(self, relation: int, before: Set) -> int: ...
    def inverse(self, relation: int) -> int: ...
    def relation_support(self, relation: int) -> list[int]:
        """Levels that the relation reads or writes, the top one first."""

    def domain(self, relation: int) -> Set: ...
    def image(self, set: Set, relation: int) -> Set: ...
    def count_steps(self, set: Set, relations: Sequence[int], ticker: Ticker) -> int:
        """How many steps the relations have within ``set``, all together and exactly."""

    def contains(self, state: NDArray[np.uint32], sets: Sequence[Set]) -> NDArray[np.uint8]:
        """Which of ``sets`` have this state in them: the value of each level, the top one first."""

    def lead_into(self, set: Set, state: NDArray[np.uint32], relations: Sequence[int]) -> NDArray[np.uint8]:
        """Which of ``relations`` have a step from this state into ``set``."""

    def steps(self, set: Set, part: Set, relation: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Sources and targets of the steps from ``part`` (of ``set``) to ``set``, numbered as ``set.vectors`` are."""

    def saturation(self, relations: Sequence[int]) -> Saturation: ...

def order(
    n: int,
    offsets: NDArray[np.int64],
    members: NDArray[np.uint32],
    method: str,
    start: NDArray[np.uint32],
    ticker: Ticker,
) -> tuple[NDArray[np.uint32], float, float]:
    """An order of n vertices with little distance within each edge; total span, weighted span."""
