"""Kernels over int arrays; masks are (n,) uint8, automata compressed sparse rows as in thenar.model."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

class Ticker:
    """Limits of one computation, and what it calls a few times a second with (states, transitions) found so far.

    The computation raises LimitReached at a limit, and whatever the callback raises.
    """

    def __init__(
        self,
        states: int | None = None,
        transitions: int | None = None,
        bytes: int | None = None,
        seconds: float | None = None,
        progress: Callable[[int, int], object] | None = None,
    ) -> None: ...

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
    def keys(self) -> NDArray[np.uint64]: ...
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
