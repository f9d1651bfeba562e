"""Following the loop: where the plant and the supervisor are, and what may happen there."""

from __future__ import annotations

from typing import Any

from thenar.errors import InputError
from thenar.explicit.forcing import ForcingSupervisor
from thenar.explicit.timed import TICK
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor

__all__ = ["Follower"]


class Follower:
    """The closed loop S/G, one event at a time.  Events are positions in the supervisor's alphabet.

    A row of the loop is looked up once a state, O(|Σ|); nothing of the product is built.  An event that the
    plant has not is one that it does not hinder.

    Raises InputError if no supervisor exists, or the plant has an event that the supervisor does not know;
    AlphabetClash if an event has two meanings.

    >>> from thenar.explicit.products import sync
    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> problem = small_factory()
    >>> loop = Follower(synthesize(problem).supervisor, sync(*problem.plants))
    >>> loop.step(loop.alphabet.index("start_1"))
    >>> loop.names(loop.enabled), loop.supervisor_state, loop.plant_state
    (['finish_1', 'break_1'], 1, 1)
    """

    __slots__ = (
        "_at",
        "_rows",
        "alphabet",
        "clock",
        "controllable",
        "enabled",
        "events",
        "forced",
        "marked",
        "plant",
        "plant_row",
        "plant_state",
        "row",
        "supervisor",
        "supervisor_state",
        "uncontrollable",
    )

    def __init__(self, supervisor: Supervisor, plant: Automaton) -> None:
        self.supervisor, self.plant = supervisor, plant
        self.alphabet = supervisor.automaton.alphabet
        if supervisor.is_empty:
            raise InputError("there is nothing to execute: no supervisor exists for this problem")
        if plant.is_empty:
            raise InputError("there is nothing to execute: the plant has no states")
        _ = self.alphabet | plant.alphabet  # an event has one meaning
        unknown = [e.name for e in plant.alphabet if e.name not in self.alphabet]
        if unknown:
            raise InputError(f"the plant has events that the supervisor does not know: {', '.join(unknown)}")
        self.events = tuple(e.name for e in self.alphabet)
        self.controllable = tuple(e.controllable for e in self.alphabet)
        #: the event called tick, which comes when nothing else does
        self.clock = self.alphabet.index(TICK.name) if TICK.name in self.alphabet else None
        #: position in this alphabet of each of the plant's events
        self._at = tuple(self.alphabet.index(e) for e in plant.alphabet)
        self._enter(supervisor.automaton.initial, plant.initial)

    def _enter(self, supervisor_state: int, plant_state: int) -> None:
        S, G, offsets = self.supervisor.automaton, self.plant, self.supervisor.disabled_offsets
        self.supervisor_state, self.plant_state = supervisor_state, plant_state
        #: what the plant can do, with where it leads; an event that it has not leaves it where it is
        self.plant_row = {self._at[e]: t for e, t in G.row(plant_state)}
        disabled = self.supervisor.disabled[offsets[supervisor_state] : offsets[supervisor_state + 1]].tolist()
        #: what the supervisor follows and lets happen, with where it leads
        self.row = {e: t for e, t in S.row(supervisor_state) if e not in disabled}
        self.enabled = [e for e in self.row if self.possible(e)]
        self.uncontrollable = [e for e in self.enabled if not self.controllable[e]]
        #: of what is enabled, the events one of which must be started at once; none where nothing is forced
        self.forced: list[int] = []
        if isinstance(self.supervisor, ForcingSupervisor) and self.supervisor.forcing[supervisor_state]:
            # no skill makes an uncontrollable event happen, though it may be forcible
            self.forced = [e for e in self.enabled if self.alphabet[e].forcible and self.controllable[e]]
        self.marked = bool(S.marked[supervisor_state] and G.marked[plant_state])

    def possible(self, event: int) -> bool:
        """Return whether the plant can do ``event`` now."""
        return event in self.plant_row or (event in self.row and self.events[event] not in self.plant.alphabet)

    @property
    def at(self) -> tuple[int, int]:
        """The states of supervisor and plant."""
        return self.supervisor_state, self.plant_state

    def after(self, event: int) -> tuple[int, int]:
        """Return the states of supervisor and plant after ``event``, which is enabled."""
        return self.row[event], self.plant_row.get(event, self.plant_state)

    def step(self, event: int) -> None:
        """Let ``event``, which is enabled, happen."""
        self._enter(*self.after(event))

    def names(self, events: list[int]) -> list[str]:
        """Return the names of ``events``."""
        return [self.events[e] for e in events]

    @property
    def plant_name(self) -> str:
        """The name of the plant's state."""
        return self.plant.states[self.plant_state]

    def describe(self) -> dict[str, Any]:
        """Return what a log says of where the loop is."""
        return {
            "plant": self.plant_name,
            "plant_state": self.plant_state,
            "supervisor_state": self.supervisor_state,
            "enabled": self.names(self.enabled),
        }
