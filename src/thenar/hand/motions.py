"""The motions that skills are made of, one ``yield`` a millisecond: each moves references of the servo."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from thenar.hand.world import PERIOD_S

if TYPE_CHECKING:
    from thenar.hand.estimates import Mean
    from thenar.hand.hand import Hand

__all__ = [
    "GRIP_RATE",
    "average",
    "come_to_rest",
    "grip_to",
    "lift",
    "move",
    "pause",
    "raise_by",
    "smooth",
    "tare",
    "weigh",
]

GRIP_RATE = 20.0  # N/s
REST_MS, REST_ROUNDS = 50, 40  # ms that a width is averaged over, and how often at most
REST_M = 8e-6  # m between two such means: three times their noise
WATCH_S = 0.4  # s of averaging on each side of a squeeze


def smooth(seconds: float) -> Iterator[tuple[float, float]]:
    """Yield (s, ds/dt) of the minimum-jerk way from 0 to 1, one pair for each period."""
    n = max(round(seconds / PERIOD_S), 1)
    for k in range(1, n + 1):
        u = k / n
        yield u**3 * (10 - 15 * u + 6 * u * u), 30 * u * u * (1 - u) ** 2 / seconds


def pause(seconds: float) -> Iterator[None]:
    """Yield for ``seconds``."""
    for _ in range(round(seconds / PERIOD_S)):
        yield


def come_to_rest(hand: Hand) -> Iterator[None]:
    """Wait until the fingers move together no more: a soft block gives way slowly; two seconds at most."""
    before = math.inf
    for _ in range(REST_ROUNDS):
        width = 0.0
        for _ in range(REST_MS):
            width += hand.touch.width_m / REST_MS
            yield
        if abs(width - before) < REST_M:
            return
        before = width


def move(hand: Hand, i: int, closing: float, height: float, seconds: float) -> Iterator[None]:
    """Move finger ``i`` (0 or 1) smoothly to a place."""
    servo = hand.servo
    c, h = servo.closing_m[i], servo.height_m[i]
    for s, rate in smooth(seconds):
        servo.closing_m[i], servo.closing_speed[i] = c + s * (closing - c), rate * (closing - c)
        servo.set_height(i, h + s * (height - h), rate * (height - h))
        yield
    servo.closing_speed[i] = 0.0
    servo.set_height(i, servo.height_m[i])


def grip_to(hand: Hand, force_n: float, rate: float = GRIP_RATE) -> Iterator[None]:
    """Change the grip force steadily, and wait until it is felt."""
    servo = hand.servo
    servo.grip(servo.grip_n)
    while servo.grip_n != force_n:
        step = min(max(force_n - servo.grip_n, -rate * PERIOD_S), rate * PERIOD_S)
        servo.grip_n += step
        yield
    steady = 0
    while steady < 20:
        steady = steady + 1 if all(abs(g - force_n) < 0.05 * force_n + 0.1 for g in hand.touch.grip_n) else 0
        yield


def raise_by(hand: Hand, distance: float, speed: float) -> Iterator[None]:
    """Move both fingers up (or down) steadily."""
    servo = hand.servo
    step = speed * PERIOD_S * (1 if distance > 0 else -1)
    for _ in range(round(abs(distance) / (speed * PERIOD_S))):
        lift(hand, step)
        yield
    servo.height_speed[:] = (0.0, 0.0)


def lift(hand: Hand, step: float) -> None:
    """Raise both height references by one period's ``step``."""
    servo = hand.servo
    servo.height_m[0] += step
    servo.height_m[1] += step
    servo.height_speed[:] = (step / PERIOD_S, step / PERIOD_S)


def tare(hand: Hand, seconds: float) -> Iterator[None]:
    """Average what free fingers feel, as the zero of their force sensors."""
    free = not any(hand.in_contact)
    for _ in pause(seconds):
        if free:
            hand.touch.tare()
        yield


def weigh(hand: Hand, seconds: float) -> Iterator[None]:
    """Average the load while everything is still."""
    for _ in pause(seconds):
        hand.weigh()
        yield


def average(hand: Hand, means: tuple[Mean, Mean, Mean]) -> Iterator[None]:
    """Average the grip force and both closing coordinates."""
    touch = hand.touch
    for _ in pause(WATCH_S):
        means[0].add((touch.grip_n[0] + touch.grip_n[1]) / 2)
        means[1].add(touch.closing_m[0])
        means[2].add(touch.closing_m[1])
        hand.weigh()
        yield
