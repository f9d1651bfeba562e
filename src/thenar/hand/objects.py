"""The object to be grasped: a block with sprung side plates, as data."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, fields

from thenar.errors import InputError

__all__ = ["Block"]

# What a block may be: outside of it the hand's motors, pads and strokes are the limit, not the task.
BOUNDS = {
    "mass_kg": (0.05, 3.0),  # a lighter one is pushed away by the first touch
    "mu": (0.05, 2.0),
    "stiffness_1_n_per_m": (600.0, 2e5),
    "stiffness_2_n_per_m": (600.0, 2e5),
    "x_m": (-0.02, 0.02),
    "face_tilt_rad": (-0.3, 0.3),
    "table_height_m": (-0.02, 0.02),
}
HARDEST_PER_KG = 2.2e5  # N/m a kg of block: a lighter plate on a harder spring is quicker than the simulator's step


@dataclass(frozen=True, slots=True)
class Block:
    """A block of two side plates on springs, one for each finger.

    ``mu`` is the Coulomb coefficient between pads and plates.  ``x_m`` is how far the block stands from where the
    hand expects it, ``face_tilt_rad`` the angle of its faces to the vertical, ``table_height_m`` the height of the
    table above the expected one.  Raises InputError for a value that no block can have.

    >>> Block(mass_kg=0.3, mu=0.5).weight_n
    2.943
    >>> Block(mass_kg=-1)
    Traceback (most recent call last):
    thenar.errors.InputError: mass_kg must be between 0.05 and 3, not -1
    """

    mass_kg: float = 0.3
    mu: float = 0.5
    stiffness_1_n_per_m: float = 4000.0
    stiffness_2_n_per_m: float = 4000.0
    x_m: float = 0.0
    face_tilt_rad: float = 0.0
    table_height_m: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value, (least, most) = getattr(self, field.name), BOUNDS[field.name]
            if not (isinstance(value, int | float) and math.isfinite(value) and least <= value <= most):
                raise InputError(f"{field.name} must be between {least:g} and {most:g}, not {value!r}")
        hardest = HARDEST_PER_KG * self.mass_kg
        for name in ("stiffness_1_n_per_m", "stiffness_2_n_per_m"):
            if getattr(self, name) > hardest:
                raise InputError(
                    f"{name} must be at most {hardest:.0f} for a block of {self.mass_kg:g} kg, not "
                    f"{getattr(self, name):g}: a light plate on a harder spring is quicker than the simulator's step"
                )

    @property
    def weight_n(self) -> float:
        """W = m g."""
        return round(self.mass_kg * 9.81, 12)

    @property
    def stiffness_n_per_m(self) -> float:
        """Return the harmonic mean 2 / (1/K1 + 1/K2): all that two fingers can feel of an object in the air."""
        return 2 / (1 / self.stiffness_1_n_per_m + 1 / self.stiffness_2_n_per_m)

    @classmethod
    def random(cls, rng: random.Random) -> Block:
        """Return a block of 0.08-0.6 kg, mu 0.25-1 and 1-12 kN/m a side, each drawn evenly; a few mm and mrad off.

        >>> Block.random(random.Random(7)) == Block.random(random.Random(7))
        True
        """
        return cls(
            mass_kg=round(rng.uniform(0.08, 0.6), 4),
            mu=round(rng.uniform(0.25, 1.0), 4),
            stiffness_1_n_per_m=round(rng.uniform(1000, 12000), 1),
            stiffness_2_n_per_m=round(rng.uniform(1000, 12000), 1),
            x_m=round(rng.uniform(-0.005, 0.005), 5),
            face_tilt_rad=round(rng.uniform(-0.03, 0.03), 4),
            table_height_m=round(rng.uniform(-0.002, 0.002), 5),
        )
