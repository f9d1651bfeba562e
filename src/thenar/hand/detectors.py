"""The detectors: what turns signals into uncontrollable events, each with a debounce, armed by the skill under way."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from thenar.hand.slip import SLIP_FRACTION
from thenar.hand.touch import VIBRATION_LIMIT
from thenar.runtime.driver import Detector

if TYPE_CHECKING:
    from thenar.hand.hand import Hand

__all__ = ["DETECTORS", "HandDetector"]

MISALIGNED_M = 1e-3  # m between the heights of the fingers: then the grip forces are not collinear
TILTED_RAD = 0.12  # rad beyond which a fingertip cannot be oriented
UNEXPECTED_N = 0.4  # N on a finger that should be free
DROPPED_SHARE = 0.4  # of the grip force, or of the load: less is felt when the object is gone
COLLAPSE_M_PER_S = 0.15  # of closing: fingers that hold something do not come together so quickly


class HandDetector:
    """A condition on what the hand feels; fires once when it has held for ``hold_ms``, until it is armed again.

    ``looked_s`` is when it last looked, armed or not; a detector that ``hangs`` looks no more.
    """

    __slots__ = ("_count", "_fired", "condition", "event", "hangs", "hold_ms", "looked_s", "plan")

    def __init__(self, plan: Detector, condition: Callable[[Hand], bool], hold_ms: int) -> None:
        self.plan, self.event, self.condition, self.hold_ms = plan, plan.event, condition, hold_ms
        self._count, self._fired, self.looked_s, self.hangs = 0, False, 0.0, False

    def arm(self) -> None:
        """Be ready to fire, from nothing."""
        self._count, self._fired = 0, False

    def look(self, hand: Hand) -> bool:
        """Look once; return whether it fires now."""
        if self.hangs:
            return False
        self.looked_s = hand.touch.time_s
        if self._fired or not self.condition(hand):
            self._count = 0
            return False
        self._count += 1
        self._fired = self._count >= self.hold_ms
        return self._fired


def detectors() -> dict[str, HandDetector]:
    """Return every detector of the hand by its event, as good as new."""
    found = [
        HandDetector(Detector("incip_slip*", odds=0.3, expected_s=0.7, limit_s=6.0), _slips, 5),
        HandDetector(Detector("detect_misalignment*", odds=0.05, expected_s=math.inf, limit_s=2.0), _misaligned, 20),
        HandDetector(Detector("obj_dropped*", odds=0.01, expected_s=math.inf, limit_s=5.0, priority=-1), _dropped, 8),
    ]
    for i in (1, 2):
        found += [
            HandDetector(
                Detector(f"unstable_contact_{i}", odds=0.05, expected_s=math.inf, limit_s=3.0, finger=i),
                _shaken(i - 1),
                150,
            ),
            HandDetector(
                Detector(f"finger_{i}_obj_misalign", odds=0.05, expected_s=math.inf, limit_s=3.0, finger=i),
                _tilted(i - 1),
                20,
            ),
            HandDetector(
                Detector(f"unexpected_contact_{i}", odds=0.01, expected_s=math.inf, limit_s=5.0, finger=i),
                _bumped(i - 1),
                5,
            ),
        ]
    return {detector.event: detector for detector in found}


def _slips(hand: Hand) -> bool:
    """A quarter of the pad's elements no longer follow the finger."""
    return hand.slip.fraction >= SLIP_FRACTION


def _misaligned(hand: Hand) -> bool:
    """The fingertips are at different heights."""
    return abs(hand.touch.height_m[1] - hand.touch.height_m[0]) > MISALIGNED_M


def _dropped(hand: Hand) -> bool:
    """The fingers press and feel nothing, come together, or carry nothing any more though they do not lower it."""
    servo, touch = hand.servo, hand.touch
    if not servo.gripping or servo.grip_n < 0.5:
        return False
    if min(touch.grip_n) < DROPPED_SHARE * servo.grip_n or touch.closing_rate > COLLAPSE_M_PER_S:
        return True
    lost = servo.carrying and touch.total_load_n < DROPPED_SHARE * hand.held_load_n
    return lost and hand.doing != "remote_makeC*"


def _shaken(i: int) -> Callable[[Hand], bool]:
    """The contact of a finger vibrates."""
    return lambda hand: hand.touch.vibration[i] > VIBRATION_LIMIT


def _tilted(i: int) -> Callable[[Hand], bool]:
    """The wrist has turned further than a fingertip can follow."""
    return lambda hand: abs(hand.touch.pitch_rad[i]) > TILTED_RAD


def _bumped(i: int) -> Callable[[Hand], bool]:
    """A finger that should be free feels a force."""
    return lambda hand: max(abs(hand.touch.grip_n[i]), abs(hand.touch.load_n[i])) > UNEXPECTED_N


DETECTORS = detectors()
