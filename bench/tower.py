"""The cat and mouse tower: storeys of the cat and mouse maze, with stairs between them.   [Ma and Wonham 2008]

As CIF's benchmark writes it (version 1): a counter for each room and kind of animal, with as many states as there are
animals and one more.
"""

from collections.abc import Iterator

from thenar.model.events import Alphabet, Event
from thenar.model.extended import Condition, ExtendedAutomaton, ExtendedProblem, invariant

ROOMS = 5
DOORS = {  # of one storey; all can be shut but the cats' between rooms 2 and 4
    "cat": [(1, 3), (2, 1), (3, 2), (3, 4), (4, 5), (5, 3), (2, 4), (4, 2)],
    "mouse": [(1, 2), (2, 3), (3, 1), (3, 5), (4, 3), (5, 4)],
}
OPEN = [("cat", 2, 4), ("cat", 4, 2)]

Room = tuple[int, int]  # storey, number


def tower(levels: int, animals: int) -> ExtendedProblem:
    """Return the tower with ``animals`` cats in its first room and as many mice in its last one.

    Between storeys k and k + 1 there are stairs, up and down, from room k to room k; from storey 6 on, it starts again
    with room 1.  A cat and a mouse must never be in one room, and all must always be able to return.
    """
    moves = {kind: list(_moves(kind, levels)) for kind in DOORS}
    events = Alphabet(
        Event(_name(kind, a, b), controllable=a[0] != b[0] or (kind, a[1], b[1]) not in OPEN)
        for kind in DOORS
        for a, b in moves[kind]
    )
    rooms = [(level, room) for level in range(1, levels + 1) for room in range(1, ROOMS + 1)]
    start = {"cat": rooms[0], "mouse": rooms[-1]}
    counters = [
        _counter(kind, room, moves[kind], animals, animals if room == start[kind] else 0, events)
        for kind in DOORS
        for room in rooms
    ]
    return ExtendedProblem(
        counters, [_apart(room) for room in rooms], name=f"tower({levels},{animals})", alphabet=events
    )


def _moves(kind: str, levels: int) -> Iterator[tuple[Room, Room]]:
    for level in range(1, levels + 1):
        yield from (((level, a), (level, b)) for a, b in DOORS[kind])
    for level in range(1, levels):
        stairs = (level - 1) % ROOMS + 1
        yield (level, stairs), (level + 1, stairs)
        yield (level + 1, stairs), (level, stairs)


def _name(kind: str, a: Room, b: Room) -> str:
    return f"{kind}_L{a[0]}R{a[1]}_to_L{b[0]}R{b[1]}"


def _place(kind: str, room: Room) -> str:
    return f"L{room[0]}R{room[1]}_{kind}"


def _counter(
    kind: str, room: Room, moves: list[tuple[Room, Room]], animals: int, initial: int, events: Alphabet
) -> ExtendedAutomaton:
    """Return how many animals of a kind are in ``room``."""
    edges: list[tuple[str, str, str]] = []
    for a, b in moves:
        if room in (a, b):
            by = 1 if room == b else -1
            counts = range(animals) if by > 0 else range(1, animals + 1)
            edges += [(f"n{n}", _name(kind, a, b), f"n{n + by}") for n in counts]
    return ExtendedAutomaton.from_edges(
        _place(kind, room),
        edges,
        initial=f"n{initial}",
        marked=[f"n{initial}"],
        states=[f"n{n}" for n in range(animals + 1)],
        events=events,
    )


def _apart(room: Room) -> Condition:
    return invariant(f"{_place('cat', room)}.n0 or {_place('mouse', room)}.n0")
