"""The hands that the supervisor can drive, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from thenar.errors import InputError, UnknownName
from thenar.hand import panda
from thenar.hand.calibration import compression_m
from thenar.hand.hand import HandSetup
from thenar.hand.objects import Block
from thenar.hand.panda import PandaWorld
from thenar.hand.world import World

__all__ = ["HANDS", "HandModel", "hand_named"]


@dataclass(frozen=True, slots=True)
class HandModel:
    """A hand: its physics, how far its pads give way under a grip force (N -> m), and what it is not built for."""

    name: str
    says: str
    world: type[World]
    compression_m: Callable[[float], float]

    def check(self, block: Block, setup: HandSetup) -> None:
        """Raise InputError, before anything moves, if this hand is not built for the block or cannot be so set up.

        >>> HANDS["panda"].check(Block(x_m=0.02), HandSetup())
        Traceback (most recent call last):
        thenar.errors.InputError: hand 'panda': a block 20 mm aside is out of reach; at most 12 mm
        """
        geometry = self.world.geometry
        if geometry.linked and setup.height_error_2_m:
            raise InputError(
                f"hand {self.name!r}: both fingers share one slide, so finger 2 cannot arrive "
                f"{1e3 * setup.height_error_2_m:g} mm too high"
            )
        if abs(block.x_m) > geometry.gap:
            raise InputError(
                f"hand {self.name!r}: a block {1e3 * abs(block.x_m):g} mm aside is out of reach; "
                f"at most {1e3 * geometry.gap:g} mm"
            )


_ALL = (
    HandModel("planar", "two fingers in a plane, each with x, z and a wrist", World, compression_m),
    HandModel(
        "panda",
        "the Franka Panda gripper on a vertical slide (its model comes with robosuite)",
        PandaWorld,
        partial(compression_m, measured_um=panda.COMPRESSION_UM),
    ),
)

HANDS = {hand.name: hand for hand in _ALL}


def hand_named(name: str) -> HandModel:
    """Return the hand called ``name``; raise UnknownName with the nearest if there is none.

    >>> hand_named("pandas")
    Traceback (most recent call last):
    thenar.errors.UnknownName: unknown hand 'pandas'; did you mean 'panda'?
    """
    if name not in HANDS:
        raise UnknownName("hand", name, HANDS)
    return HANDS[name]
