"""What the exploratory procedures find out: friction, weight and stiffness, each with an uncertainty.

Beside each better estimate stands the paper's own formula (section 3): mu = F_t / F_n at the first sign of slip,
W = 2 mu F_g with that mu, K = dF / dx of the fingertips.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["Estimate", "Estimates", "Mean"]

ELEMENT_NOISE_N = 4e-4  # N, of the filtered normal force of an element
LIMIT_SHARE = 4e-3  # of mu, that an element may stay below its limit when slip is caught
# Filtered samples are correlated: the standard error of their mean is larger by sqrt(2 tau / T).
FORCE_CORRELATION = math.sqrt(12.0)
POSITION_CORRELATION = math.sqrt(2.0)
DRIFT_N = 1.4e-3  # N per root second, of the sum of two tares, from the sensors' data sheet
PAD_M = 5e-7  # m of uncertainty of a pad's calibrated compression


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and its standard uncertainty, in the same unit.

    >>> print(Estimate(0.5, 0.004))
    0.500 ± 0.004
    """

    value: float
    uncertainty: float

    def __str__(self) -> str:
        if not 0 < self.uncertainty < math.inf:
            return f"{self.value:.4g}"
        digits = max(0, -math.floor(math.log10(self.uncertainty)))
        return f"{self.value:.{digits}f} ± {self.uncertainty:.{digits}f}"


@dataclass(slots=True)
class Mean:
    """A running mean with the standard error of it (Welford's recurrence).

    >>> mean = Mean()
    >>> for x in (1.0, 2.0, 3.0):
    ...     mean.add(x)
    >>> mean.value, round(mean.error, 3)
    (2.0, 0.577)
    """

    n: int = 0
    value: float = 0.0
    squares: float = 0.0

    def add(self, x: float) -> None:
        """Take ``x`` into the mean."""
        self.n += 1
        change = x - self.value
        self.value += change / self.n
        self.squares += change * (x - self.value)

    @property
    def error(self) -> float:
        """Return the standard error of the mean; infinite below two samples."""
        return math.sqrt(self.squares / (self.n - 1) / self.n) if self.n > 1 else math.inf


@dataclass(slots=True)
class Estimates:
    """What is known of the object so far; None where nothing is.

    ``mu`` comes from the elements that slip (each is at its friction limit), ``mu_paper`` from the whole pad, most
    of which still sticks: it reads low.  ``weight_n`` is the load held still, ``weight_paper_n`` is 2 mu F_g.
    ``stiffness_n_per_m`` takes the pads' own compliance off, ``stiffness_paper_n_per_m`` does not.
    """

    mu: Estimate | None = None
    mu_paper: float | None = None
    weight_n: Estimate | None = None
    weight_paper_n: float | None = None
    stiffness_n_per_m: Estimate | None = None
    stiffness_paper_n_per_m: float | None = None
    load: Mean = field(default_factory=Mean)

    def slipped(self, limits: NDArray[np.float64], normal: NDArray[np.float64], load_n: float, grip_n: float) -> None:
        """Learn from a slip: each slipping element's friction limit and normal force (N), and F_t, F_n of the pad.

        The latest slip counts: the one that the friction procedure provokes is slower than one under a rising load.
        """
        weight = np.maximum(normal, 1e-3)
        weight = weight / weight.sum()
        mu = float(limits @ weight)
        spread = math.sqrt(float(weight @ (limits - mu) ** 2) / max(len(limits) - 1, 1))
        noise = ELEMENT_NOISE_N / float(np.maximum(normal, 1e-3).sum()) * math.sqrt(len(limits))
        self.mu = Estimate(mu, math.hypot(spread, mu * noise, mu * LIMIT_SHARE))
        self.mu_paper = load_n / grip_n
        self.weight_paper_n = 2 * load_n  # 2 mu F_g with that mu: the grip cancels

    def held(self, load_n: float, tared: int, since_s: float) -> None:
        """Learn from one period in which the object is held still in the air.

        The tare is a mean of ``tared`` periods like this one, ``since_s`` seconds ago.
        """
        mean = self.load
        mean.add(load_n)
        if mean.n > 1:
            noise = FORCE_CORRELATION * mean.error
            tare = noise * math.sqrt(mean.n / max(tared, 1))
            self.weight_n = Estimate(mean.value, math.hypot(noise, tare, DRIFT_N * math.sqrt(max(since_s, 0.0))))

    def squeezed(
        self,
        before: tuple[Mean, Mean, Mean],
        after: tuple[Mean, Mean, Mean],
        compression_m: Callable[[float], float],
    ) -> None:
        """Learn from a squeeze: grip (N) and both closing coordinates (m), each before and after it.

        ``compression_m`` is how far one pad gives way under a grip force, measured on a reference block.
        """
        force = after[0].value - before[0].value
        moved = [after[k].value - before[k].value for k in (1, 2)]
        self.stiffness_paper_n_per_m = sum(force / m for m in moved if m > 0) / 2 if min(moved) > 0 else None
        pads = compression_m(after[0].value) - compression_m(before[0].value)
        deformation = sum(moved) / 2 - pads
        if deformation <= 0 or force <= 0:
            return
        noise = POSITION_CORRELATION * math.hypot(*(m.error for m in (*before[1:], *after[1:]))) / 2
        pressed = FORCE_CORRELATION * math.hypot(before[0].error, after[0].error)
        relative = math.hypot(math.hypot(noise, PAD_M) / deformation, pressed / force)
        value = force / deformation
        self.stiffness_n_per_m = Estimate(value, value * relative)
