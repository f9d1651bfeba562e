"""The skills: what two fingers do for each controllable event, one generator a skill, one ``yield`` a millisecond.

A skill returns when it has achieved what its event stands for.  What it moves are the references of the servo; so
when it is not advanced (the slip reflex) or closed (an abort) everything stands still where it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from thenar.hand.estimates import Mean
from thenar.hand.motions import (
    GRIP_RATE,
    average,
    come_to_rest,
    grip_to,
    lift,
    move,
    pause,
    raise_by,
    smooth,
    tare,
    weigh,
)
from thenar.hand.servo import CLOSING_STIFFNESS
from thenar.hand.touch import VIBRATION_LIMIT
from thenar.hand.world import FACE, PERIOD_S
from thenar.runtime.driver import Skill

if TYPE_CHECKING:
    from thenar.hand.hand import Hand

__all__ = ["SKILLS", "Routine", "routines"]

GRASP_HEIGHT = 0.030  # m above the expected table: above the middle of the block, so that it hangs straight
GUARDED_SPEED = 0.03  # m/s
CONTACT_N = 0.12  # N, ten times the filtered noise
TOUCH_N = 0.7  # N that both fingers press with while they orient: aligns a pad, moves no block
FIRST_GRIP_N = 4.0
TABLE_GRIP_RATE = 10.0  # N/s on the table: the softer side gives way more quickly, and that must not push a light block
GRIP_FACTOR = 2.4  # 4 N, 9.6 N, 23 N: two increments must do for all that a hand like this can lift
MOST_GRIP_N = 34.0  # a squeeze on top stays within what the pads are calibrated for
SAFETY = 1.6  # grip over what the measured friction needs at least
LIFT_SPEED = 0.004  # m/s: the load rises by 16 N/s
CLEARANCE = 0.001  # m that the object hangs above the table after lift-off
LIFT_HEIGHT = 0.03  # m, the Z of move_to_Z
MOVE_SPEED = 0.06  # m/s
LOWER_SPEED = 0.015  # m/s
GRIP_DECAY = 2.0  # 1/s
SQUEEZE_N = 6.0
LEAST_WIDTH = 0.008  # m between the fingertips, where they have no stroke left: a softer block is squeezed less
LEAST_SQUEEZE_N = 1.0  # N below which a squeeze says nothing
SETTLE_S = 0.15
SHARING_S = 0.04  # s in which what finger 2 carries too much falls to a third
STILL_S = 0.25  # s of holding still before the grip is loosened

Routine = Callable[["Hand"], Iterator[None]]


@dataclass(frozen=True, slots=True)
class HandSkill:
    """A skill of the hand: its plan for the runtime, its routine, its precondition, the detectors that it arms."""

    plan: Skill
    routine: Routine
    not_ready: Callable[[Hand], str | None]
    arms: tuple[str, ...] = ()


def approach(i: int) -> Routine:
    """Return the way from rest to the proposed contact location; achieved when the finger is there."""

    def run(hand: Hand) -> Iterator[None]:
        yield from tare(hand, 0.4)
        error = hand.setup.height_error_2_m if i == 1 else 0.0
        yield from move(hand, i, -(FACE + hand.geometry.gap), GRASP_HEIGHT + error, 0.6)
        yield from pause(0.05)

    return run


def retract(i: int) -> Routine:
    """Return the way back to rest of a finger that touches nothing; achieved when it is there."""

    def run(hand: Hand) -> Iterator[None]:
        hand.servo.hold_closing(i)
        yield from move(hand, i, *hand.rest(i), 0.6)
        yield from pause(0.05)

    return run


def align(hand: Hand) -> Iterator[None]:
    """Take finger 2's contact location from finger 1; achieved when both heights have agreed for a while."""
    agreed = 0
    while agreed < 60:
        agreed = agreed + 1 if abs(hand.touch.height_m[1] - hand.touch.height_m[0]) < 1e-3 else 0
        yield


def realign(hand: Hand) -> Iterator[None]:
    """Move finger 2 to a position opposite to finger 1; achieved when the motion is done."""
    servo = hand.servo
    error = hand.touch.height_m[0] - hand.touch.height_m[1]
    yield from move(hand, 1, servo.closing_m[1], servo.height_m[1] + hand.setup.realign_gain * error, 0.3)
    yield from pause(0.05)


def make_contact(i: int) -> Routine:
    """Return a guarded move: inwards until the pad feels the object; achieved at the contact."""

    def run(hand: Hand) -> Iterator[None]:
        servo, touch = hand.servo, hand.touch
        end = servo.closing_m[i] + hand.geometry.travel
        servo.closing_speed[i] = GUARDED_SPEED
        felt = 0
        while felt < 3:
            felt = felt + 1 if touch.grip_n[i] > CONTACT_N else 0
            if servo.closing_m[i] < end:
                servo.closing_m[i] += GUARDED_SPEED * PERIOD_S
            else:
                servo.closing_speed[i] = 0.0
            yield
        servo.closing_speed[i] = 0.0
        servo.closing_m[i] = touch.closing_m[i] + CONTACT_N / CLOSING_STIFFNESS
        hand.in_contact[i] = True

    return run


def suppress_vibration(i: int) -> Routine:
    """Return a wait at the contact; achieved when the pad has been quiet for 60 ms."""

    def run(hand: Hand) -> Iterator[None]:
        quiet = 0
        while quiet < 60:
            quiet = quiet + 1 if hand.touch.vibration[i] < VIBRATION_LIMIT else 0
            yield

    return run


def orient(i: int) -> Routine:
    """Return the turn of a freed wrist that both fingers press flat; achieved when the wrist has come to rest."""

    def run(hand: Hand) -> Iterator[None]:
        servo, touch = hand.servo, hand.touch
        yield from grip_to(hand, TOUCH_N, 5.0)
        servo.pitch_free[i] = True
        yield from pause(0.1)
        start, still = touch.pitch_rad[i], 0
        while still < 80:
            yield
            if abs(touch.pitch_rad[i] - start) < 1.5e-3:
                still += 1
            else:
                start, still = touch.pitch_rad[i], 0
        servo.pitch_free[i] = False

    return run


def apply_grip(hand: Hand) -> Iterator[None]:
    """Press from both sides; achieved when the first grip force is felt."""
    servo, touch = hand.servo, hand.touch
    yield from pause(0.05)
    low, middle = servo.grip_n, touch.middle_m
    yield from grip_to(hand, FIRST_GRIP_N, 8.0)
    yield from pause(0.05)
    # the table holds the block, so that this is how unlike its two sides give way
    if servo.grip_n > low:
        servo.centre_per_n = (touch.middle_m - middle) / (servo.grip_n - low)


def apply_load(hand: Hand) -> Iterator[None]:
    """Begin to pull upwards: a command, it occurs at once."""
    hand.begin_load()
    yield from raise_by(hand, 0.0005, LIFT_SPEED)


def increase_grip(hand: Hand) -> Iterator[None]:
    """Press more in response to slip; achieved when the increased force is felt.

    While the friction is unknown the grip grows by a factor; a known friction says how much is needed.
    """
    yield from hand.study_slip()
    servo = hand.servo
    wanted = servo.grip_n * GRIP_FACTOR
    if servo.carrying and hand.estimates.mu is not None:
        needed = hand.held_load_n / 2 / hand.estimates.mu.value
        wanted = max(SAFETY * needed, servo.grip_n * 1.2)
    yield from grip_to(hand, min(wanted, MOST_GRIP_N), GRIP_RATE if servo.carrying else TABLE_GRIP_RATE)


def break_remote(hand: Hand) -> Iterator[None]:
    """Raise the load until the object leaves the table; achieved when the fingers rise and the load does not."""
    hand.begin_load()
    window: list[float] = []
    confirmed = 0
    while confirmed < 5:
        lift(hand, LIFT_SPEED * PERIOD_S)
        window.append(hand.touch.mean_height_m)
        if len(window) > 25:
            rise = window[-1] - window.pop(0)
            confirmed = confirmed + 1 if rise > 0.6 * LIFT_SPEED * 0.025 else 0
        if confirmed == 5 and hand.slip.look_for_gross_slip():
            confirmed = 0  # the fingers rise, the object does not: the slip detector takes it from here
        yield
    hand.lifted()


def decrease_grip(hand: Hand) -> Iterator[None]:
    """Hold still, then loosen the grip until something happens: a command, it occurs at once."""
    servo = hand.servo
    yield from hold_clear(hand)
    hand.slip.arm()
    while True:
        if servo.grip_n > 0.1:
            servo.grip_n *= 1 - GRIP_DECAY * PERIOD_S
        yield


def hold_clear(hand: Hand) -> Iterator[None]:
    """Raise a lifted object clear of the table, see that finger 2 is not sheared more, hold still and weigh it.

    Only finger 1 feels slip: a finger 2 that carried more would slip first, and unnoticed.
    """
    if hand.height_m < CLEARANCE:
        yield from raise_by(hand, CLEARANCE - hand.height_m, 2 * LIFT_SPEED)
    for _ in pause(SETTLE_S):
        hand.servo.relieve_finger_2(SHARING_S)
        yield
    yield from weigh(hand, STILL_S)


def move_to_z(hand: Hand) -> Iterator[None]:
    """Lift the object to Z above the table; achieved when it is there and still."""
    servo = hand.servo
    yield from pause(0.05)
    start, way = list(servo.height_m), LIFT_HEIGHT - hand.height_m
    seconds = max(1.875 * abs(way) / MOVE_SPEED, 0.2)
    for s, rate in smooth(seconds):
        for i in (0, 1):
            servo.height_m[i], servo.height_speed[i] = start[i] + s * way, rate * way
        yield
    servo.stand_still()
    yield from pause(SETTLE_S)
    yield from weigh(hand, STILL_S)


def squeeze(hand: Hand) -> Iterator[None]:
    """Squeeze by a known force, as far as the stroke goes, and back; achieved when the grip is as before."""
    servo = hand.servo
    before = servo.grip_n
    rest, pressed = (Mean(), Mean(), Mean()), (Mean(), Mean(), Mean())
    yield from come_to_rest(hand)
    yield from average(hand, rest)
    while servo.grip_n < before + SQUEEZE_N and hand.touch.width_m > LEAST_WIDTH:
        servo.grip_n += GRIP_RATE * PERIOD_S
        yield
    yield from grip_to(hand, servo.grip_n)
    yield from come_to_rest(hand)
    yield from average(hand, pressed)
    yield from grip_to(hand, before)
    if servo.grip_n < pressed[0].value - LEAST_SQUEEZE_N:
        hand.estimates.squeezed(rest, pressed, hand.compression_m)


def make_remote(hand: Hand) -> Iterator[None]:
    """Lower the object until the table carries some of it; achieved when the load falls."""
    held, lowest = hand.held_load_n, hand.servo.height_m[0] - 2 * LIFT_HEIGHT
    enough = max(0.12 * held, 0.1)
    felt, speed = 0, 0.0
    while felt < 3:
        speed = min(speed + LOWER_SPEED * PERIOD_S / 0.1, LOWER_SPEED)
        lift(hand, -speed * PERIOD_S if hand.servo.height_m[0] > lowest else 0.0)
        yield
        felt = felt + 1 if hand.touch.total_load_n < held - enough else 0
    hand.set_down()


def break_contact(i: int) -> Routine:
    """Return the release: unload, loosen, then finger ``i`` opens and goes to rest; achieved when it is there."""

    def run(hand: Hand) -> Iterator[None]:
        servo = hand.servo
        if servo.gripping:
            yield from unload(hand)
        servo.hold_closing(i)
        servo.pitch_free[i] = hand.in_contact[i] = False
        yield from move(hand, i, -(FACE + hand.geometry.gap), servo.height_m[i], 0.4)
        servo.pitch_rad[i] = 0.0
        yield from move(hand, i, *hand.rest(i), 0.6)
        yield from pause(0.05)

    return run


def unload(hand: Hand) -> Iterator[None]:
    """Put down what is held, carry nothing, press no more."""
    servo, touch = hand.servo, hand.touch
    if servo.carrying:
        lowest = servo.height_m[0] - max(hand.height_m, 0.0) - 0.002
        while servo.height_m[0] > lowest and touch.total_load_n > 0.5 * hand.held_load_n:
            lift(hand, -LOWER_SPEED * PERIOD_S)
            yield
        hand.set_down()
    start = list(servo.height_m)
    for s, _ in smooth(0.2):
        for k in (0, 1):
            servo.set_height(k, start[k] + s * (touch.height_m[k] - start[k]), servo.height_speed[k])
        yield
    while servo.grip_n > 0.3:
        servo.grip_n = max(servo.grip_n - GRIP_RATE * PERIOD_S, 0.3)
        yield
    servo.hold_closing()


def _always(hand: Hand) -> str | None:
    return None


def _both_touch(hand: Hand) -> str | None:
    for i in (0, 1):
        if not hand.in_contact[i]:
            return f"finger {i + 1} does not touch the object yet"
    return None


def _gripping(hand: Hand) -> str | None:
    return None if hand.servo.gripping else "nothing is gripped"


def _carrying(hand: Hand) -> str | None:
    return None if hand.servo.carrying else "nothing is held in the air"


SLIP, MISALIGNED = "incip_slip*", "detect_misalignment*"
DROPPED = "obj_dropped*"


def routines() -> dict[str, HandSkill]:
    """Return every skill of the hand by the event that it is for."""
    skills: list[HandSkill] = []

    def add(
        event: str,
        routine: Routine,
        expected_s: float,
        limit_s: float,
        *arms: str,
        finger: int = 0,
        ready: Callable[[Hand], str | None] = _always,
        command: bool = False,
    ) -> None:
        commit = "command" if command else "achievement"
        plan = Skill(event, commit, expected_s, limit_s, finger)  # type: ignore[arg-type]
        skills.append(HandSkill(plan, routine, ready, arms))

    for i in (1, 2):
        bump = f"unexpected_contact_{i}"
        add(f"approach_{i}", approach(i - 1), 1.05, 3.0, bump, finger=i)
        add(f"retract_finger_{i}", retract(i - 1), 0.65, 2.0, finger=i)
        add(f"prox_make_C{i}", make_contact(i - 1), 0.9, 4.0, finger=i)
        add(f"suppress_vib{i}", suppress_vibration(i - 1), 0.1, 2.0, f"unstable_contact_{i}", finger=i)
        add(
            f"orient_normal{i}",
            orient(i - 1),
            0.4,
            4.0,
            f"finger_{i}_obj_misalign",
            f"unstable_contact_{i}",
            finger=i,
            ready=_both_touch,
        )
        add(f"prox_breakC_{i}", break_contact(i - 1), 1.6, 6.0, finger=i)
    add("align_finger2*", align, 0.06, 2.0, MISALIGNED)
    add("re-align_with_finger1*", realign, 0.35, 2.0)
    add("apply_gripF*", apply_grip, 0.6, 4.0, ready=_both_touch)
    add("apply_loadF*", apply_load, 0.0, 2.0, SLIP, DROPPED, ready=_gripping, command=True)
    add("inc_gripF*", increase_grip, 0.4, 5.0, DROPPED, ready=_gripping)
    add("remote_breakC*", break_remote, 0.4, 8.0, SLIP, DROPPED, ready=_gripping)
    add("dec_gripF*", decrease_grip, 0.0, 10.0, SLIP, DROPPED, ready=_carrying, command=True)
    add("move_to_Z*", move_to_z, 1.5, 5.0, DROPPED, ready=_carrying)
    add("stiffness_EP*", squeeze, 1.7, 8.0, DROPPED, ready=_carrying)
    add("remote_makeC*", make_remote, 2.1, 8.0, DROPPED, ready=_carrying)
    return {skill.plan.event: skill for skill in skills}


SKILLS = routines()
