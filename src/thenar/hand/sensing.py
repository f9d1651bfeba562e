"""The sensor model: what noise, bias, quantisation, tare drift and drop-out make of the ideal readings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar.errors import Fault, UnknownName
from thenar.hand.world import CHANNELS, PERIOD_S

__all__ = ["PROFILES", "Profile", "SensorModel", "profile"]

BLOCK = 512  # periods whose noise is drawn at once


@dataclass(frozen=True, slots=True)
class Profile:
    """How good the sensors are.  Noise is the standard deviation of a sample at 1 kHz.

    ``bias`` of a force is a tare that is wrong when the run begins, ``drift`` a random walk of it per root second;
    ``dropout`` is how often in a second a sensor repeats its last value for 3 ms.

    >>> PROFILES["lab"].force_noise_n, PROFILES["lab"].position_noise_m, PROFILES["lab"].taxel_noise_n
    (0.05, 1e-05, 0.001)
    """

    force_noise_n: float
    position_noise_m: float
    taxel_noise_n: float  # shear and normal force of one element
    pitch_noise_rad: float
    acceleration_noise_m_per_s2: float
    bias: float  # in units of the noise
    drift: float  # in units of the noise, per root second
    quantum: float  # in units of the noise
    dropout_per_s: float


PROFILES = {
    "ideal": Profile(0, 0, 0, 0, 0, 0, 0, 0, 0),
    "lab": Profile(0.05, 1e-5, 1e-3, 2e-4, 0.05, bias=2, drift=0.02, quantum=0.1, dropout_per_s=0.05),
    "rough": Profile(0.1, 2e-5, 2e-3, 4e-4, 0.1, bias=4, drift=0.04, quantum=0.25, dropout_per_s=0.2),
}


def profile(name: str) -> Profile:
    """Return the profile called ``name``; raise UnknownName with the nearest if there is none."""
    if name not in PROFILES:
        raise UnknownName("sensor profile", name, PROFILES)
    return PROFILES[name]


class SensorModel:
    """Turns the ideal readings of one period after the other into what the hand gets.

    >>> sensors = SensorModel(PROFILES["ideal"], seed=1)
    >>> float(sensors.read(np.ones(len(CHANNELS))).mean())
    1.0
    """

    def __init__(self, profile: Profile, seed: int) -> None:
        self._rng = np.random.Generator(np.random.PCG64(seed))
        noise = {
            "force": profile.force_noise_n,
            "position": profile.position_noise_m,
            "normal": profile.taxel_noise_n,
            "shear": profile.taxel_noise_n,
            "pitch": profile.pitch_noise_rad,
            "acceleration": profile.acceleration_noise_m_per_s2,
        }
        kinds = [name.split("_")[0] for name in CHANNELS]
        self._sigma = np.array([noise[kind] for kind in kinds])
        drifts = np.array([kind in ("force", "normal", "shear") for kind in kinds])  # encoders do not drift
        self._walk = np.where(drifts, profile.drift * self._sigma * PERIOD_S**0.5, 0.0)
        self._bias = np.where(drifts, profile.bias * self._sigma * self._rng.standard_normal(len(CHANNELS)), 0.0)
        self._quantum = profile.quantum * self._sigma
        self._step = np.where(self._quantum > 0, self._quantum, 1.0)
        self._dropout = profile.dropout_per_s * PERIOD_S
        self._held = np.zeros(len(CHANNELS), dtype=np.int64)
        self._value = np.zeros(len(CHANNELS))
        self._exact = not self._sigma.any()
        self._row = BLOCK
        self._offsets: NDArray[np.float64] = np.zeros((BLOCK, len(CHANNELS)))
        self._lost: NDArray[np.bool_] = np.zeros((BLOCK, len(CHANNELS)), dtype=bool)
        self._drops = [False] * BLOCK

    def read(self, raw: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the readings (in place: the array is the model's own) for the ideal ones of this period."""
        if self._exact:
            self._value[:] = raw
            return self._value
        if self._row == BLOCK:
            self._draw()
        row = self._row
        self._row += 1
        if self._drops[row]:
            fresh = raw + self._offsets[row]
            self._held = np.where(self._lost[row], 3, np.maximum(self._held - 1, 0))
            np.copyto(self._value, np.rint(fresh / self._step) * self._step, where=self._held == 0)
            return self._value
        value: NDArray[np.float64] = np.add(raw, self._offsets[row], out=self._value)
        value /= self._step
        np.rint(value, out=value)
        value *= self._step
        return value

    def _draw(self) -> None:
        """Draw the noise of the next :data:`BLOCK` periods at once."""
        shape = (BLOCK, len(CHANNELS))
        walk = self._bias + np.cumsum(self._rng.standard_normal(shape) * self._walk, axis=0)
        self._bias = walk[-1]
        self._offsets = walk + self._rng.standard_normal(shape) * self._sigma
        self._lost[:] = self._rng.random(shape) < self._dropout
        lost = np.logical_or.reduce(self._lost, axis=1)
        # a period takes the slow way while any sensor holds its last value, also across the seam of two blocks
        near = lost.copy()
        for later in (1, 2, 3):
            near[later:] |= lost[:-later]
        near[:4] = True
        self._drops = near.tolist()
        self._row = 0


def check_finite(values: NDArray[np.float64], time_s: float) -> None:
    """Raise Fault that names the first channel whose reading is no finite number."""
    if not np.isfinite(values).all():
        channel = CHANNELS[int(np.flatnonzero(~np.isfinite(values))[0])]
        raise Fault(f"sensor {channel!r} reports {values[CHANNELS.index(channel)]} at {time_s:.3f} s")
