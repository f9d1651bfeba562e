"""The cat and the mouse in the maze: two animals that must never meet, and a door that cannot be shut."""

from __future__ import annotations

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem

__all__ = ["cat_and_mouse"]

# doorway: the room that it leads from, and the one that it leads to
CAT_DOORS = {"c1": (0, 1), "c2": (1, 2), "c3": (2, 0), "c4": (0, 3), "c5": (3, 4), "c6": (4, 0)}
MOUSE_DOORS = {"m1": (0, 2), "m2": (2, 1), "m3": (1, 0), "m4": (0, 4), "m5": (4, 3), "m6": (3, 0)}
MOVES = {
    "cat": [*((a, door, b) for door, (a, b) in CAT_DOORS.items()), (1, "c7", 3), (3, "c7", 1)],
    "mouse": [(a, door, b) for door, (a, b) in MOUSE_DOORS.items()],
}
START = {"cat": 2, "mouse": 4}


def cat_and_mouse() -> Problem:
    """Return the cat and the mouse in a maze of five rooms.

    The cat has the doorways c1 to c7 for itself, the mouse m1 to m6.  A doorway leads one way, only c7,
    between rooms 1 and 3, leads both ways, and it is always open.  The cat starts in room 2, the mouse in
    room 4.  They must never be in the same room, and must always be able to return to where they started.

    There is one specification for each room: it is free, or the cat is in it, or the mouse.  The supervisor
    has 6 states and 9 transitions.   [Wonham and Ramadge 1987, SIAM J. Control Optim. 25(3), sec. 7.3]

    >>> cat_and_mouse()
    Problem 'cat_and_mouse': 2 plants, 5 specs, 13 events (1 uncontrollable)
    """
    events = Alphabet(
        [
            *(Event(door, meaning=f"the cat goes from room {a} to room {b}") for door, (a, b) in CAT_DOORS.items()),
            Event("c7", controllable=False, meaning="the cat goes from room 1 to room 3 or back; this door is open"),
            *(Event(door, meaning=f"the mouse goes from room {a} to room {b}") for door, (a, b) in MOUSE_DOORS.items()),
        ]
    )
    return Problem(
        [_animal("cat", events), _animal("mouse", events)],
        [_room(room, events) for room in range(5)],
        name="cat_and_mouse",
        alphabet=events,
        description="A cat and a mouse must never be in the same room, and always be able to return.",
    )


def _animal(name: str, events: Alphabet) -> Automaton:
    start = f"room_{START[name]}"
    return Automaton.from_transitions(
        [(f"room_{a}", door, f"room_{b}") for a, door, b in MOVES[name]],
        initial=start,
        marked=[start],
        events=events,
        name=name.upper(),
    )


def _room(room: int, events: Alphabet) -> Automaton:
    """Return the specification of one room, which animals enter and leave; it does not restrict who leaves."""
    changes = [("free", door, who) for who, moves in MOVES.items() for _, door, b in moves if b == room]
    changes += [(who, door, "free") for who, moves in MOVES.items() for a, door, _ in moves if a == room]
    return Automaton.from_transitions(
        changes,
        initial=next((who for who, start in START.items() if start == room), "free"),
        marked=["free", "cat", "mouse"],
        events=events,
        name=f"ROOM{room}",
        meaning=f"cat and mouse are never both in room {room}",
    )
