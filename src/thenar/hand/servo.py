"""The servo below every skill: position or force control of two fingers, 1 kHz."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from thenar.hand.geometry import PLANAR, Geometry
from thenar.hand.touch import Touch
from thenar.hand.world import FINGER_DAMPING, PERIOD_S

__all__ = ["Servo"]

CLOSING_STIFFNESS = 1500.0  # N/m
LIFT_STIFFNESS = 2000.0  # N/m a finger: the load rises by this for each metre that the reference leads
WRIST_STIFFNESS = 2.0  # Nm/rad: 0.7 of critical damping
CENTRING = 800.0  # N/m that pull both gripping fingers, together, to where the object stands
UNEVEN = 1.05  # times finger 1's shear that finger 2's may be: that one feels slip well before a pad slips as a whole
MOST_N = 60.0  # what a motor can do


class Servo:
    """References of both fingers, and the motor forces that follow from them; index 0 is finger 1.

    A finger's closing axis is under position control, or under force control (``gripping``) towards ``grip_n``.
    While the object stands on the table that says where the centre of the grasp is; in the air (``carrying``) the
    fingers hold it.
    """

    def __init__(self, touch: Touch, geometry: Geometry = PLANAR) -> None:
        self._touch, self._linked = touch, geometry.linked
        closing, height = geometry.home
        self.closing_m = [closing, closing]
        self.closing_speed = [0.0, 0.0]
        self.height_m = [height, height]
        self.height_speed = [0.0, 0.0]
        self.pitch_rad = [0.0, 0.0]
        self.pitch_free = [False, False]
        self.gripping = False
        self.grip_n = 0.0
        self.carrying = False
        self.centre_m = 0.0
        self.centre_per_n = 0.0  # m/N: how the centre moves with the grip when one side is softer
        self._carried_at_n = 0.0

    def grip(self, force_n: float) -> None:
        """Change both fingers to force control."""
        self.gripping, self.grip_n = True, force_n

    def carry(self) -> None:
        """Hold the centre of the grasp where it is: the object has left the table."""
        if not self.carrying:
            self.carrying, self._carried_at_n, self.centre_m = True, self.grip_n, self._touch.middle_m

    def set_down(self) -> None:
        """Hold the centre of the grasp no more: the object stands on the table."""
        self.carrying = False

    def hold_closing(self, i: int | None = None) -> None:
        """Change finger ``i``, or both, to position control where they are; a grip ends for both."""
        both = self.gripping or i is None
        self.gripping = self.carrying = False
        for k in (0, 1):
            if not both and k != i:
                continue
            self.closing_m[k], self.closing_speed[k] = self._touch.closing_m[k], 0.0

    def set_height(self, i: int, height_m: float, speed: float = 0.0) -> None:
        """Set the height reference of finger ``i``, and of the other one if they share a slide."""
        for k in (0, 1) if self._linked else (i,):
            self.height_m[k], self.height_speed[k] = height_m, speed

    def relieve_finger_2(self, seconds: float) -> None:
        """Shift load from finger 2 to finger 1 while its pad is sheared more; evened out within ``seconds``.

        Shear is what makes a pad slip; on leaning faces that is not the load, part of which the grip carries.
        """
        excess = self._touch.shear_n[1] - UNEVEN * self._touch.shear_n[0]
        if excess > 0 and not self._linked:
            step = excess / (2 * LIFT_STIFFNESS) * (PERIOD_S / seconds)
            self.height_m[0] += step
            self.height_m[1] -= step

    def stand_still(self) -> None:
        """Stop every reference where it is."""
        self.closing_speed[:] = self.height_speed[:] = (0.0, 0.0)

    def drive(self, ctrl: NDArray[np.float64]) -> None:
        """Write the motor forces of this period into ``ctrl``."""
        touch = self._touch
        centring = 0.0
        if self.carrying:
            aim = self.centre_m + self.centre_per_n * (self.grip_n - self._carried_at_n)
            centring = CENTRING * (aim - touch.middle_m)
        forces = []
        for i, sign in ((0, 1.0), (1, -1.0)):
            if self.gripping:
                force = sign * self.grip_n + centring
            else:
                error = self.closing_m[i] - touch.closing_m[i]
                force = sign * (CLOSING_STIFFNESS * error + FINGER_DAMPING * self.closing_speed[i])
            forces.append(min(max(force, -MOST_N), MOST_N))
            lift = self.height_m[i] - touch.height_m[i]
            forces.append(LIFT_STIFFNESS * lift + FINGER_DAMPING * self.height_speed[i])
            if self.pitch_free[i]:
                self.pitch_rad[i] = touch.pitch_rad[i]
            forces.append(WRIST_STIFFNESS * (self.pitch_rad[i] - touch.pitch_rad[i]))
        ctrl[:] = forces
