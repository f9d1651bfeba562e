"""The slip sensor: which elements of a pad have stopped to follow the finger.

A sticking element is stretched exactly as far as the finger moves over the object, so the shear of all sticking
elements changes alike.  An element slips when its shear lags that of the fastest one; the crowned pad lets the
outer ones go first, and that is *incipient* slip: the object is still held.
"""

from __future__ import annotations

import numpy as np

from thenar.hand.touch import Touch
from thenar.hand.world import ELEMENTS

__all__ = ["SLIP_FRACTION", "SlipSensor"]

SLIP_FRACTION = 0.25  # share of the elements; at 0.7 slip runs away before it is confirmed
LAG_N = 2.5e-3  # N that an element's shear must lag: six times the filtered noise of one
TOUCHING_N = 0.02  # N of normal force below which the noise makes a ratio meaningless
LAG_SHARE = 0.01  # of the mean shear: heavy objects shake more


class SlipSensor:
    """Watches the elements of finger 1's pad from the moment that it is armed.

    ``fraction`` is the share of the elements that slip, ``slipping`` says which: (7,) bool.  ``ratio``: (7,)
    float64, the highest shear over normal force that each element has reached: never more than mu, and mu for one
    that slides, while a moment later it sticks below its limit again.
    """

    def __init__(self, touch: Touch) -> None:
        self._touch = touch
        self._origin = np.zeros(ELEMENTS)
        self.slipping = np.zeros(ELEMENTS, dtype=bool)
        self.fraction = 0.0
        self.watching = False
        self.ratio = np.zeros(ELEMENTS)

    def arm(self) -> None:
        """Begin anew: what has slipped so far counts as sticking where it is now."""
        self._origin = self._touch.shear.copy()
        self.slipping = np.zeros(ELEMENTS, dtype=bool)
        self.ratio = np.zeros(ELEMENTS)
        self.fraction = 0.0
        self.watching = True

    def disarm(self) -> None:
        """Look no more."""
        self.watching = False
        self.fraction = 0.0

    def update(self) -> None:
        """Look at the elements once; called in every period while armed."""
        touch = self._touch
        moved = touch.shear - self._origin
        lag = moved.max() - moved
        self.slipping = lag > LAG_N + LAG_SHARE * abs(float(touch.shear.mean()))
        self.fraction = np.count_nonzero(self.slipping) / ELEMENTS
        self.study()

    def study(self) -> None:
        """Look for the highest shear over normal force of each element: that is its friction limit."""
        ratio = np.abs(self._touch.shear) / np.maximum(self._touch.normal, TOUCHING_N)
        np.maximum(self.ratio, ratio, out=self.ratio)
