"""The simulated hand as a driver of the runtime: physics, then sensors, then the hand, a thousand times a second."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from thenar.explicit.timed import TICK
from thenar.hand.hand import Hand
from thenar.hand.scenarios import Disturbance
from thenar.hand.sensing import SensorModel, check_finite
from thenar.hand.skills import SKILLS
from thenar.hand.world import CHANNELS, PERIOD_S, World
from thenar.runtime.driver import Detector, Signal, Skill

__all__ = ["COMMANDS", "TICK_S", "HandDriver"]

TICK_S = 2.0  # s without an event that a clock counts as one; an increase of the grip takes 1.4 s at most

COMMANDS = ("grip_command", "lift_command_1", "lift_command_2", "slip_fraction")


class HandDriver:
    """Drives a :class:`~thenar.hand.hand.Hand` in a :class:`~thenar.hand.world.World` through its sensors.

    The hand gets readings and gives motor forces; no object that it can reach knows the world.
    """

    period_s = PERIOD_S

    def __init__(self, world: World, sensors: SensorModel, hand: Hand, disturb: Disturbance | None = None) -> None:
        self.skills: Mapping[str, Skill] = {event: skill.plan for event, skill in SKILLS.items()}
        clock = Detector(TICK.name, odds=0.0, expected_s=TICK_S, limit_s=2 * TICK_S)
        self.detectors: Mapping[str, Detector] = {
            clock.event: clock,
            **{event: d.plan for event, d in hand.detectors.items()},
        }
        self.world, self.hand, self._sensors, self._disturb = world, hand, sensors, disturb
        self._rows = np.empty((4096, len(CHANNELS) + len(COMMANDS)))

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self.world.time_s

    @property
    def recording(self) -> NDArray[np.float64]:
        """What was measured, and what had been commanded by then.

        A row for each period; a column for each channel, then each command.
        """
        return self._rows[: self.world.ticks]

    def not_ready(self, event: str) -> str | None:
        """Return why the skill of ``event`` cannot start now."""
        return self.hand.not_ready(event)

    def start(self, event: str) -> None:
        """Start the skill of ``event``."""
        self.hand.start(event)

    def abort(self, event: str) -> None:
        """End the skill of ``event`` and stand still."""
        self.hand.stop()

    def stop(self) -> None:
        """Stand still, and hold what is held."""
        self.hand.stop()

    def tick(self) -> Sequence[Signal]:
        """Advance physics, sensors and hand by one period."""
        world, hand = self.world, self.hand
        if self._disturb is not None:
            self._disturb(world, hand.doing)
        world.step()
        values = self._sensors.read(world.raw)
        out = self._row()
        out[: len(CHANNELS)] = values
        servo = hand.servo
        commands = servo.grip_n if servo.gripping else 0.0, *servo.height_m, hand.slip.fraction
        out[len(CHANNELS) :] = commands
        if not np.isfinite(values.sum()):
            check_finite(values, world.time_s)
        signals = hand.tick(values, world.time_s)
        servo.drive(world.ctrl)
        return signals

    def _row(self) -> NDArray[np.float64]:
        """Return the row of this period, to be filled."""
        row = self.world.ticks - 1
        if row == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        found: NDArray[np.float64] = self._rows[row]
        return found

    def heartbeat(self, event: str) -> float:
        """Return when the detector of ``event`` last looked."""
        return self.hand.detectors[event].looked_s

    def snapshot(self) -> dict[str, float]:
        """Return what both fingers feel now."""
        touch = self.hand.touch
        felt = {
            "grip_n": touch.grip_n,
            "load_n": touch.load_n,
            "closing_m": touch.closing_m,
            "height_m": touch.height_m,
            "pitch_rad": touch.pitch_rad,
            "vibration": touch.vibration,
        }
        both = {f"{name}_{i + 1}": values[i] for name, values in felt.items() for i in (0, 1)}
        return {**both, "slip_fraction": self.hand.slip.fraction}
