"""Five automated guided vehicles that serve a workcell on crossing routes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem

__all__ = ["agv"]


@dataclass(frozen=True)
class Leg:
    """One leg of a vehicle's tour: the event, its label in the book (odd: controllable), the place it ends at."""

    event: str
    label: int
    place: str
    meaning: str


# Each tour starts and ends in the parking place.  A place is a zone with the direction of travel, or a station.
TOURS = {
    1: [
        Leg("leave_park", 11, "Z1_empty", "leaves its park and enters zone 1"),
        Leg("load_IPS1", 10, "IPS1", "leaves zone 1 and loads a part of type 1 at input station 1"),
        Leg("enter_Z1", 13, "Z1_loaded", "leaves the input station and enters zone 1 again"),
        Leg("unload_WS2", 12, "parked", "leaves zone 1, unloads at workstation 2 and parks"),
    ],
    2: [
        Leg("leave_park", 21, "Z3_empty", "leaves its park and enters zone 3"),
        Leg("Z3_to_Z2", 18, "Z2_empty", "goes from zone 3 to zone 2"),
        Leg("Z2_to_Z1", 20, "Z1_empty", "goes from zone 2 to zone 1"),
        Leg("load_IPS2", 22, "IPS2", "leaves zone 1 and loads a part of type 2 at input station 2"),
        Leg("enter_Z1", 23, "Z1_loaded", "leaves the input station and enters zone 1 again"),
        Leg("Z1_to_Z2", 24, "Z2_loaded", "goes from zone 1 back to zone 2"),
        Leg("Z2_to_Z3", 26, "Z3_loaded", "goes from zone 2 back to zone 3"),
        Leg("unload_WS3", 28, "parked", "leaves zone 3, unloads at workstation 3 and parks"),
    ],
    3: [
        Leg("leave_park", 33, "Z2_empty", "leaves its park and enters zone 2"),
        Leg("load_WS2", 34, "WS2", "leaves zone 2 and loads at workstation 2"),
        Leg("enter_Z2", 31, "Z2_loaded", "leaves the workstation and enters zone 2 again"),
        Leg("unload_WS1", 32, "parked", "leaves zone 2, unloads at workstation 1 and parks"),
    ],
    4: [
        Leg("leave_park", 41, "Z3_empty", "leaves its park and enters zone 3"),
        Leg("Z3_to_Z4", 40, "Z4_empty", "goes from zone 3 to zone 4"),
        Leg("load_WS3", 42, "WS3", "leaves zone 4 and loads at workstation 3"),
        Leg("enter_Z4", 43, "Z4_loaded", "leaves the workstation and enters zone 4 again"),
        Leg("Z4_to_Z3", 44, "Z3_loaded", "goes from zone 4 back to zone 3"),
        Leg("unload_WS1", 46, "parked", "leaves zone 3, unloads at workstation 1 and parks"),
    ],
    5: [
        Leg("leave_park", 51, "Z4_empty", "leaves its park and enters zone 4"),
        Leg("load_WS1", 50, "WS1", "leaves zone 4 and loads a finished product at workstation 1"),
        Leg("enter_Z4", 53, "Z4_loaded", "leaves the workstation and enters zone 4 again"),
        Leg("deliver_CPS", 52, "parked", "leaves zone 4, delivers at the completed parts station and parks"),
    ],
}


def agv() -> Problem:
    """Return Wonham's workcell that five automated guided vehicles serve on fixed circular routes.

    Vehicles 1 and 2 fetch parts from the input stations IPS1 and IPS2 and bring them to workstations WS2 and
    WS3; vehicles 3 and 4 bring them on to WS1, which joins one of each type; vehicle 5 delivers the product
    to the completed parts station CPS.  The routes cross in four zones::

        zone      Z1     Z2     Z3     Z4
        vehicles  1, 2   2, 3   2, 4   4, 5

    Only when a vehicle leaves its park or a station can it be held back.  No two vehicles may be in a zone at
    once; WS1 needs a part of each type before its product is fetched; WS2 and WS3 are loaded and unloaded in
    turn; and the input stations share an area in which there is room for one vehicle.

    The supervisor has 4406 states and 11338 transitions.  The events have the order of their labels in the
    book, which are part of their meaning.   [Wonham and Cai 2019, sec. 4.7]

    >>> agv()
    Problem 'agv': 5 plants, 8 specs, 26 events (16 uncontrollable)
    >>> for transition in agv().automaton("AGV5").transitions():
    ...     print(*transition)
    parked A5_leave_park Z4_empty
    Z4_empty A5_load_WS1 WS1
    WS1 A5_enter_Z4 Z4_loaded
    Z4_loaded A5_deliver_CPS parked
    """
    legs = sorted(((leg.label, i, leg) for i, tour in TOURS.items() for leg in tour), key=lambda entry: entry[0])
    events = Alphabet(
        Event(
            f"A{i}_{leg.event}",
            controllable=label % 2 == 1,
            meaning=f"vehicle {i} {leg.meaning} (book: {label})",
        )
        for label, i, leg in legs
    )
    vehicles = [
        Automaton.from_transitions(
            [(start.place, f"A{i}_{leg.event}", leg.place) for start, leg in pairwise([tour[-1], *tour])],
            initial="parked",
            marked=["parked"],
            events=events,
            name=f"AGV{i}",
        )
        for i, tour in TOURS.items()
    ]
    return Problem(
        vehicles,
        [
            *(_zone(k, events) for k in range(1, 5)),
            _workstation_1(events),
            _workstation(2, "A1_unload_WS2", "A3_load_WS2", events),
            _workstation(3, "A2_unload_WS3", "A4_load_WS3", events),
            _input_area(events),
        ],
        name="agv",
        alphabet=events,
        description="Five automated guided vehicles serve a workcell on crossing routes.",
    )


def _zone(k: int, events: Alphabet) -> Automaton:
    """Return the specification that at most one vehicle is in zone ``k``, from the tours through it."""
    transitions, users = [], []
    for i, tour in TOURS.items():
        for start, leg in pairwise([tour[-1], *tour]):
            if leg.place.startswith(f"Z{k}"):
                transitions.append(("free", f"A{i}_{leg.event}", f"AGV{i}"))
                users.append(f"AGV{i}")
            elif start.place.startswith(f"Z{k}"):
                transitions.append((f"AGV{i}", f"A{i}_{leg.event}", "free"))
    states = dict.fromkeys(["free", *users])
    return _spec(f"ZONE{k}", transitions, states, f"at most one vehicle is in zone {k}", events)


def _workstation_1(events: Alphabet) -> Automaton:
    arrows = [
        "empty -A3_unload_WS1-> has_type_1 -A4_unload_WS1-> has_both",
        "empty -A4_unload_WS1-> has_type_2 -A3_unload_WS1-> has_both",
        "has_both -A5_load_WS1-> empty",
    ]
    states = ["empty", "has_type_1", "has_type_2", "has_both"]
    return _spec("WS1", arrows, states, "a product is fetched when one part of each type has been unloaded", events)


def _workstation(k: int, unload: str, load: str, events: Alphabet) -> Automaton:
    arrows = [f"empty -{unload}-> full -{load}-> empty"]
    return _spec(f"WS{k}", arrows, ["empty", "full"], f"workstation {k} is loaded and unloaded in turn", events)


def _input_area(events: Alphabet) -> Automaton:
    arrows = ["free -A1_load_IPS1-> AGV1 -A1_enter_Z1-> free", "free -A2_load_IPS2-> AGV2 -A2_enter_Z1-> free"]
    return _spec("IPS", arrows, ["free", "AGV1", "AGV2"], "at most one vehicle is at the input stations", events)


def _spec(
    name: str,
    transitions: Sequence[str] | Sequence[tuple[str, str, str]],
    states: Iterable[str],
    meaning: str,
    events: Alphabet,
) -> Automaton:
    """Return a specification that starts in the first of ``states`` and may be in any when the work is done."""
    return Automaton.from_transitions(
        transitions,
        initial=next(iter(states)),
        marked=states,
        states=states,
        events=events,
        name=name,
        meaning=meaning,
    )
