"""The scenarios: what is done to the hand and its object, what that provokes, and how the run ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from thenar.errors import UnknownName
from thenar.hand.hand import HandSetup
from thenar.hand.objects import Block
from thenar.hand.world import World

__all__ = ["SCENARIOS", "Disturbance", "Scenario", "scenario"]

Disturbance = Callable[[World, str | None], None]
"""What a scenario does to the world in each period, given the skill under way."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """A block, a setup of the hand, and what happens to them on the way.

    ``provokes`` is the event that the cause brings about, ``ends`` how the supervised run of the paper's task
    ends.  A ``hole`` is a scenario that the paper's alphabet has no word for: there ``provokes`` is an event of the
    extended variant.

    >>> scenario("heavy").provokes, scenario("heavy").ends
    ('incip_slip*', 'complete')
    """

    name: str
    says: str
    provokes: str
    ends: str
    block: Block | None = None
    setup: HandSetup = field(default_factory=HandSetup)
    disturbance: Callable[[], Disturbance] | None = None
    obstacle: bool = False
    glued: bool = False
    missing: bool = False
    hole: bool = False

    def world(self, block: Block, hand: type[World] = World) -> World:
        """Return the physics of this scenario around ``block``."""
        return hand(block, obstacle=self.obstacle, glued=self.glued, missing=self.missing)


def shaking(seconds: float) -> Callable[[], Disturbance]:
    """Return a lateral force of 12 N at 60 Hz on the block, from the first contact of both fingers on."""

    def make() -> Disturbance:
        begun: float | None = None

        def disturb(world: World, doing: str | None) -> None:
            nonlocal begun
            if begun is None and doing is not None and doing.startswith("suppress_vib"):
                begun = world.time_s
            on = begun is not None and world.time_s - begun < seconds
            world.push(12.0 * math.sin(2 * math.pi * 60.0 * world.time_s) if on else 0.0, 0.0)

        return disturb

    return make


def pulled_out(during: str) -> Callable[[], Disturbance]:
    """Return a pull of 80 N downwards, 0.2 s long, that begins 0.3 s after the skill ``during``."""

    def make() -> Disturbance:
        begun: float | None = None

        def disturb(world: World, doing: str | None) -> None:
            nonlocal begun
            if begun is None and doing == during:
                begun = world.time_s
            after = world.time_s - begun if begun is not None else 0.0
            world.push(0.0, -80.0 if 0.3 <= after < 0.5 else 0.0)

        return disturb

    return make


def table_gone(during: str) -> Callable[[], Disturbance]:
    """Return a table that is taken away once the skill ``during`` is under way."""

    def make() -> Disturbance:
        gone = False

        def disturb(world: World, doing: str | None) -> None:
            nonlocal gone
            if not gone and doing == during:
                gone = True
                world.drop_table()

        return disturb

    return make


_ALL = (
    Scenario("nominal", "nothing goes wrong", "", "complete"),
    Scenario(
        "misaligned", "finger 2 arrives 3 mm too high", "detect_misalignment*", "complete", setup=HandSetup(0.003)
    ),
    Scenario(
        "misaligned-thrice",
        "finger 2 arrives 3 mm too high, and its re-alignment corrects a fifth of that",
        "detect_misalignment*",
        "gave_up",
        setup=HandSetup(0.003, realign_gain=0.2),
    ),
    Scenario("tilted", "the faces lean by 0.10 rad", "", "complete", Block(face_tilt_rad=0.10)),
    Scenario(
        "tilted-too-far", "the faces lean by 0.14 rad", "finger_1_obj_misalign", "gave_up", Block(face_tilt_rad=0.14)
    ),
    Scenario(
        "shaken",
        "12 N at 60 Hz shake the block sideways for 1 s",
        "unstable_contact_1",
        "complete",
        disturbance=shaking(1.0),
    ),
    Scenario(
        "shaken-for-ever",
        "12 N at 60 Hz shake the block sideways and do not stop",
        "unstable_contact_1",
        "gave_up",
        disturbance=shaking(math.inf),
    ),
    Scenario("heavy", "1.2 kg at mu 0.5", "incip_slip*", "complete", Block(mass_kg=1.2, mu=0.5)),
    Scenario("slippery", "0.3 kg at mu 0.12", "incip_slip*", "complete", Block(mass_kg=0.3, mu=0.12)),
    Scenario("too-heavy", "1.2 kg at mu 0.25", "incip_slip*", "gave_up", Block(mass_kg=1.2, mu=0.25)),
    Scenario("glued", "the block is glued to the table", "incip_slip*", "gave_up", glued=True),
    Scenario("high-table", "the table is 5 mm too high", "", "complete", Block(table_height_m=0.005)),
    Scenario("low-table", "the table is 8 mm too low", "", "complete", Block(table_height_m=-0.008)),
    Scenario("off-centre", "the block stands 20 mm aside", "", "complete", Block(x_m=0.02)),
    Scenario(
        "soft",
        "a block of 600 N/m",
        "",
        "complete",
        Block(stiffness_1_n_per_m=600.0, stiffness_2_n_per_m=600.0),
    ),
    Scenario(
        "pulled-while-squeezing",
        "the block is pulled out of the grasp while it is squeezed",
        "obj_dropped*",
        "complete",
        disturbance=pulled_out("stiffness_EP*"),
        hole=True,
    ),
    Scenario(
        "pulled-while-moving",
        "the block is pulled out of the grasp while it is lifted to Z",
        "obj_dropped*",
        "complete",
        disturbance=pulled_out("move_to_Z*"),
        hole=True,
    ),
    Scenario("missing", "there is no block", "timeout_1", "stopped", missing=True, hole=True),
    Scenario(
        "table-gone",
        "the table is taken away while the block is in the air",
        "timeout_1",
        "stopped",
        disturbance=table_gone("stiffness_EP*"),
        hole=True,
    ),
    Scenario(
        "collision",
        "something stands in the way of finger 1",
        "unexpected_contact_1",
        "gave_up",
        obstacle=True,
        hole=True,
    ),
)

SCENARIOS = {s.name: s for s in _ALL}


def scenario(name: str) -> Scenario:
    """Return the scenario called ``name``; raise UnknownName with the nearest if there is none.

    >>> scenario("tiltet")
    Traceback (most recent call last):
    thenar.errors.UnknownName: unknown scenario 'tiltet'; did you mean 'tilted'?
    """
    if name not in SCENARIOS:
        raise UnknownName("scenario", name, SCENARIOS)
    return SCENARIOS[name]
