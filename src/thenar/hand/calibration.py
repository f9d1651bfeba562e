"""The pads' own compliance, measured by squeezing a reference block of known stiffness."""

from __future__ import annotations

from functools import cache

import numpy as np

from thenar.hand.hand import Hand, HandSetup
from thenar.hand.motions import grip_to, pause
from thenar.hand.objects import Block
from thenar.hand.sensing import PROFILES, SensorModel
from thenar.hand.world import World

__all__ = ["REFERENCE", "compression_m", "measure"]

REFERENCE = Block(mass_kg=0.5, mu=0.8, stiffness_1_n_per_m=1e5, stiffness_2_n_per_m=1e5)
FORCES_N = (0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15, 18, 22, 26, 30, 35, 40)
"""Grip forces at which the pads are measured."""

# What ``measure`` finds, in micrometres: a test repeats it.
COMPRESSION_UM = (
    0.0, 26.42, 52.34, 75.25, 112.17, 148.95, 185.56, 221.98, 294.21, 365.65, 436.37, 541.34, 645.24, 782.57, 919.08,
    1055.11, 1224.65, 1393.78,
)  # fmt: skip


def compression_m(force_n: float, measured_um: tuple[float, ...] = COMPRESSION_UM) -> float:
    """Return how far one pad gives way under a grip force: piecewise linear through the measured points.

    ``measured_um`` is what :func:`measure` found for the hand, the planar one by default.

    >>> 0 < compression_m(4.0) < compression_m(8.0) < 0.001
    True
    """
    return float(np.interp(force_n, FORCES_N, measured_um)) * 1e-6


@cache
def measure(profile: str = "ideal", hand_world: type[World] = World) -> tuple[float, ...]:
    """Squeeze the reference block with the hand's own skills; return each pad's compression in µm at FORCES_N.

    The reference's own stiffness is known and taken off; the zero is the width at no force, which drops out of
    every difference.
    """
    world = hand_world(REFERENCE)
    sensors = SensorModel(PROFILES[profile], seed=1)
    hand = Hand(HandSetup(), lambda force: 0.0, frozenset(), world.geometry)

    def advance() -> None:
        world.step()
        hand.tick(sensors.read(world.raw), world.time_s)
        hand.servo.drive(world.ctrl)

    for event in ("approach_1", "approach_2", "prox_make_C1", "prox_make_C2", "orient_normal1", "orient_normal2"):
        hand.start(event)
        while hand.doing is not None:
            advance()
    found = []
    for force in FORCES_N:
        for routine in (grip_to(hand, force), pause(0.2)):
            for _ in routine:
                advance()
        width = grip = 0.0
        for _ in range(200):
            advance()
            width += hand.touch.width_m / 200
            grip += sum(hand.touch.grip_n) / 400
        own = grip / REFERENCE.stiffness_n_per_m
        found.append((-width / 2 - own) * 1e6)
    return tuple(round(x - found[0], 2) for x in found)
