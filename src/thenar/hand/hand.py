"""The hand: what it feels, what it does, and what it has found out.  It knows nothing of the world but its sensors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thenar.hand.detectors import HandDetector, detectors
from thenar.hand.estimates import Estimates
from thenar.hand.geometry import PLANAR, Geometry
from thenar.hand.servo import Servo
from thenar.hand.skills import SKILLS, HandSkill
from thenar.hand.slip import SLIP_FRACTION, SlipSensor
from thenar.hand.touch import Touch
from thenar.runtime.driver import Signal

__all__ = ["Hand", "HandSetup"]

PAD_SHEAR_STIFFNESS = 3.0e4  # N/m: seven elements side by side
STUDY_MS = 8  # ms that elements go on sliding, and are averaged, once slip has been caught; then they stick again
HEARTBEAT_MS = 10


@dataclass(frozen=True, slots=True)
class HandSetup:
    """How well the hand itself is set up: where its second finger goes, and how well it corrects that.

    >>> HandSetup(height_error_2_m=0.003).realign_gain
    1.0
    """

    height_error_2_m: float = 0.0
    realign_gain: float = 1.0


class Hand:
    """Two fingers with their servo, skills and detectors; :meth:`tick` turns one period's readings into signals.

    ``compression_m`` is how far a pad gives way under a grip force, from a calibration on a reference block.
    """

    def __init__(
        self,
        setup: HandSetup,
        compression_m: Callable[[float], float],
        events: frozenset[str],
        geometry: Geometry = PLANAR,
    ) -> None:
        self.setup, self.geometry = setup, geometry
        self.compression_m = compression_m
        self.touch = Touch()
        self.servo = Servo(self.touch, geometry)
        self.slip = SlipSensor(self.touch)
        self.estimates = Estimates()
        self.detectors = {name: d for name, d in detectors().items() if name in events}
        self.in_contact = [False, False]
        self.doing: str | None = None
        self._routine: Iterator[None] | None = None
        self._armed: tuple[HandDetector, ...] = ()
        self._numbers: dict[str, int] = {}
        self._load_height: float | None = None
        self._lift_load_n = 0.0
        self._slip_seen: tuple[NDArray[np.bool_], float, float] | None = None
        self._ticks = 0

    # what the skills remember and share

    @property
    def height_m(self) -> float:
        """Return how high the object hangs above the table, as far as the fingers know."""
        if self._load_height is None:
            return 0.0
        stretched = self.held_load_n / (2 * PAD_SHEAR_STIFFNESS)
        return self.touch.mean_height_m - self._load_height - stretched

    @property
    def held_load_n(self) -> float:
        """Return the load of the object in the air: its mean, once it was held still."""
        mean = self.estimates.load
        return mean.value if mean.n >= 100 else self._lift_load_n

    def rest(self, i: int) -> tuple[float, float]:
        """Return where finger ``i`` goes to rest: on a shared slide it stays down while the other finger touches."""
        closing, height = self.geometry.home
        if self.geometry.linked and self.in_contact[1 - i]:
            height = self.servo.height_m[i]
        return closing, height

    def begin_load(self) -> None:
        """Remember where the fingers were when they began to pull."""
        if self._load_height is None:
            self._load_height = self.touch.mean_height_m

    def lifted(self) -> None:
        """The object has left the table."""
        self._lift_load_n = self.touch.total_load_n
        self.servo.carry()
        self.servo.stand_still()

    def set_down(self) -> None:
        """The object is on the table again."""
        self._load_height = None
        self.servo.set_down()
        self.servo.stand_still()

    def weigh(self) -> None:
        """Count this period's load as the object's weight, held still."""
        if self.servo.carrying:
            touch = self.touch
            self.estimates.held(touch.total_load_n, touch.tared, touch.time_s - touch.tared_s)

    def study_slip(self) -> Iterator[None]:
        """Hold still and learn from the elements that slip."""
        if self._slip_seen is None:
            return
        slipping, load_n, grip_n = self._slip_seen
        self._slip_seen = None
        for _ in range(STUDY_MS):
            self.slip.study()
            yield
        self.estimates.slipped(self.slip.ratio[slipping], self.touch.normal[slipping], load_n, grip_n)

    # what the driver asks of it

    def not_ready(self, event: str) -> str | None:
        """Return why the skill of ``event`` cannot start."""
        return SKILLS[event].not_ready(self)

    def start(self, event: str) -> None:
        """Start a skill and arm its detectors."""
        skill: HandSkill = SKILLS[event]
        self.doing = event
        self._routine = skill.routine(self)
        self._armed = tuple(self.detectors[name] for name in skill.arms if name in self.detectors)
        for detector in self._armed:
            detector.arm()
        if "incip_slip*" in skill.arms:
            self.slip.arm()
        else:
            self.slip.disarm()

    def stop(self) -> None:
        """Stand still where the fingers are, holding what they hold."""
        self._routine, self.doing = None, None
        self.servo.stand_still()

    def tick(self, values: NDArray[np.float64], time_s: float) -> list[Signal]:
        """Take in one period's readings, move the references on, and return what happened."""
        self.touch.update(values, time_s)
        signals: list[Signal] = []
        slip = self.slip
        if slip.watching:
            slip.update()
        for detector in self._armed:
            if detector.look(self):
                signals.append(self._signal(detector.event))
                self._fired(detector.event)
        self._ticks += 1
        if self._ticks % HEARTBEAT_MS == 0:
            for detector in self.detectors.values():
                if detector not in self._armed:
                    detector.arm()  # one look is never enough to fire: it only shows that the detector is alive
                    detector.look(self)
        # the reflex: while the pad slips the skill is not advanced, whatever the supervisor makes of it
        if self._routine is not None and slip.fraction < SLIP_FRACTION:
            try:
                next(self._routine)
            except StopIteration:
                self._routine = None
                if self.doing is not None and SKILLS[self.doing].plan.commit == "achievement":
                    signals.append(self._signal(self.doing))
                self.doing = None
        elif self._routine is not None:
            self.servo.stand_still()
        return signals

    def _fired(self, event: str) -> None:
        if event == "incip_slip*":
            self._slip_seen = (self.slip.slipping.copy(), self.touch.shear_n[0], max(self.touch.grip_n[0], 1e-3))
        self.stop()

    def _signal(self, event: str) -> Signal:
        number = self._numbers.get(event, 0)
        self._numbers[event] = number + 1
        return Signal(event, self.touch.time_s, number)
