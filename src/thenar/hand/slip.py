"""The slip sensor: which elements of a pad have stopped to follow the finger.

A sticking element is stretched exactly as far as the finger moves over the object, so the shear of all sticking
elements changes alike.  An element slips when its shear lags that of the fastest one; the crowned pad lets the
outer ones go first, and that is *incipient* slip: the object is still held.

When all elements slip at once none lags another.  But then each is at its friction limit, and its shear is in
proportion to its normal force, which the crown makes unequal; in a pad that sticks the shear is even.
"""

from __future__ import annotations

import numpy as np

from thenar.hand.touch import Touch
from thenar.hand.world import ELEMENTS

__all__ = ["SLIP_FRACTION", "SlipSensor"]

SLIP_FRACTION = 0.25  # share of the elements; at 0.7 slip runs away before it is confirmed
LAG_N = 2.5e-3  # N that an element's shear must lag: six times the filtered noise of one
UNEVEN_SHARE = 0.03  # spread of the shears, over their mean, below which they count as even
GROSS_SHARE = 0.25  # how much smaller the spread of the ratios to the normal forces must be
TOUCHING_N = 0.02  # N of normal force below which the noise makes a ratio meaningless
LAG_SHARE = 0.01  # of the mean shear: heavy objects shake more


class SlipSensor:
    """Watches the elements of finger 1's pad from the moment that it is armed.

    ``fraction`` is the share of the elements that slip, ``slipping`` says which: (7,) bool;
    ``gross`` that all of them do.  ``ratio``: (7,)
    float64, the highest shear over normal force that each element has reached: never more than mu, and mu for one
    that slides, while a moment later it sticks below its limit again.
    """

    def __init__(self, touch: Touch) -> None:
        self._touch = touch
        self._origin = np.zeros(ELEMENTS)
        self.slipping = np.zeros(ELEMENTS, dtype=bool)
        self.fraction, self.gross = 0.0, False
        self.watching = False
        self.ratio = np.zeros(ELEMENTS)

    def arm(self) -> None:
        """Begin anew: what has slipped so far counts as sticking where it is now."""
        self._origin = self._touch.shear.copy()
        self.slipping = np.zeros(ELEMENTS, dtype=bool)
        self.ratio = np.zeros(ELEMENTS)
        self.fraction, self.gross = 0.0, False
        self.watching = True

    def disarm(self) -> None:
        """Look no more."""
        self.watching = False
        self.fraction, self.gross = 0.0, False

    def update(self) -> None:
        """Look at the elements once; called in every period while armed."""
        touch = self._touch
        moved = touch.shear - self._origin
        lag = moved.max() - moved
        self.slipping = lag > LAG_N + LAG_SHARE * abs(float(touch.shear.mean()))
        if self.gross:
            self.slipping = np.ones(ELEMENTS, dtype=bool)
        self.fraction = np.count_nonzero(self.slipping) / ELEMENTS
        self.study()

    def look_for_gross_slip(self) -> bool:
        """Return whether the whole pad slides, to be asked when the fingers rise and the load does not.

        Then either the object has left the table, or the shear of the elements is a multiple of the normal force.
        """
        shear, normal = self._touch.shear, np.maximum(self._touch.normal, TOUCHING_N)
        ratio = shear / normal
        uneven, disproportionate = (float(x.std() / max(abs(x.mean()), 1e-9)) for x in (shear, ratio))
        self.gross = uneven > UNEVEN_SHARE and disproportionate < GROSS_SHARE * uneven
        return self.gross

    def study(self) -> None:
        """Look for the highest shear over normal force of each element: that is its friction limit."""
        ratio = np.abs(self._touch.shear) / np.maximum(self._touch.normal, TOUCHING_N)
        np.maximum(self.ratio, ratio, out=self.ratio)
