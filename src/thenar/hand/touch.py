"""What the hand feels: readings filtered, tared and turned into the terms of a grasp."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from thenar.hand.world import CHANNELS, ELEMENTS, PERIOD_S

__all__ = ["VIBRATION_LIMIT", "Touch"]

SMOOTHING_S = {"force": 6e-3, "acceleration": 0.0, "position": 1e-3, "pitch": 1e-3, "normal": 4e-3, "shear": 4e-3}
VIBRATION_S = 40e-3  # s of memory of the vibration's strength
CLOSING_S = 8e-3  # s of memory of the closing rate
VIBRATION_LIMIT = 1.0  # m/s² rms that is no quiet contact: twenty times the noise
LEVEL_S = 0.1  # s; what is slower than this is no vibration


class Touch:
    """The state of both fingers as their sensors tell it; index 0 is finger 1.

    ``closing_m`` grows as a finger moves towards the other one (0: the middle), ``height_m`` and ``pitch_rad`` are
    as the encoders say; ``grip_n`` is what the finger presses, ``load_n`` what it carries, both in the world's
    frame and filtered; ``shear_n`` is the force along the pad.  ``closing_rate`` is how quickly the fingers come
    together, m/s.  ``vibration`` is the strength of the lateral acceleration, m/s² rms.  ``tared`` periods, the
    last at ``tared_s``, made the tare.
    ``normal`` and ``shear``: (7,) float64, N, of the elements of finger 1's pad, filtered.
    """

    __slots__ = (
        "_alpha",
        "_filtered",
        "_level",
        "_power",
        "_tare",
        "_tare_sum",
        "_width",
        "closing_m",
        "closing_rate",
        "grip_n",
        "height_m",
        "load_n",
        "normal",
        "pitch_rad",
        "shear",
        "shear_n",
        "tared",
        "tared_s",
        "time_s",
        "values",
        "vibration",
    )

    def __init__(self) -> None:
        smoothing = [SMOOTHING_S[name.split("_")[0]] for name in CHANNELS]
        self._alpha = np.array([PERIOD_S / (PERIOD_S + s) for s in smoothing])
        self._filtered: NDArray[np.float64] = np.zeros(len(CHANNELS))
        self._tare = np.zeros(len(CHANNELS))
        self._tare_sum = np.zeros(len(CHANNELS))
        self.tared, self.tared_s = 0, 0.0
        self.values = np.zeros(len(CHANNELS))
        self.normal = self._filtered[-2 * ELEMENTS : -ELEMENTS]
        self.shear = self._filtered[-ELEMENTS:]
        self.time_s = 0.0
        self._width, self.closing_rate = 0.0, 0.0
        self._level, self._power = [0.0, 0.0], [0.0, 0.0]
        self.closing_m, self.height_m, self.pitch_rad = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]
        self.grip_n, self.load_n, self.shear_n, self.vibration = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]

    def update(self, values: NDArray[np.float64], time_s: float) -> None:
        """Take in the readings of one period."""
        self.values = values
        filtered = self._filtered
        if not self.time_s:
            filtered[:] = values
        self.time_s = time_s
        change = values - self._tare
        change -= filtered
        change *= self._alpha
        filtered += change
        first = not any(self.closing_m)
        v = filtered.tolist()
        for i, sign in ((0, 1.0), (1, -1.0)):
            x, z, pitch = v[8 + 3 * i : 11 + 3 * i]
            # the force sensor turns with the fingertip: 0.01 rad are 1-2 % of a weight
            cos, sin = math.cos(pitch), math.sin(pitch)
            fx, fz = v[2 * i], v[2 * i + 1]
            self.closing_m[i] = sign * x
            self.height_m[i] = z
            self.pitch_rad[i] = pitch
            self.grip_n[i] = sign * (fx * cos + fz * sin)
            self.load_n[i] = fz * cos - fx * sin
            self.shear_n[i] = fz
            lateral = v[4 + 2 * i]
            self._level[i] += (lateral - self._level[i]) * (PERIOD_S / LEVEL_S)
            swing = lateral - self._level[i]
            self._power[i] += (swing * swing - self._power[i]) * (PERIOD_S / VIBRATION_S)
            self.vibration[i] = math.sqrt(self._power[i])
        width = self.width_m
        rate = 0.0 if first else (self._width - width) / PERIOD_S
        self._width = width
        self.closing_rate += (rate - self.closing_rate) * (PERIOD_S / CLOSING_S)

    def tare(self) -> None:
        """Take one more period of free fingers into the mean that forces are measured from."""
        raw = self.values.copy()
        raw[4:14] = 0.0  # accelerations and positions have no tare
        self._tare_sum += raw
        self.tared += 1
        self.tared_s = self.time_s
        new = self._tare_sum / self.tared
        self._filtered += self._tare - new
        self._tare = new

    @property
    def middle_m(self) -> float:
        """Return where the middle between both fingertips is, to the right of the expected one."""
        return (self.closing_m[0] - self.closing_m[1]) / 2

    @property
    def mean_height_m(self) -> float:
        """Return the mean height of both fingers."""
        return (self.height_m[0] + self.height_m[1]) / 2

    @property
    def width_m(self) -> float:
        """Return the distance between the fingertips."""
        return -(self.closing_m[0] + self.closing_m[1])

    @property
    def total_load_n(self) -> float:
        """Return what both fingers carry."""
        return self.load_n[0] + self.load_n[1]
