"""The event bus: what was reported in one tick, checked and put into one total order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from thenar.errors import Fault
from thenar.model.events import Alphabet
from thenar.runtime.binding import TIMEOUT
from thenar.runtime.driver import Driver, Signal

__all__ = ["MAX_DELAY_S", "EventBus"]

MAX_DELAY_S = 0.005  # five control periods at 1 kHz; what is older says little of how things stand
_FUTURE_S = 1e-9  # rounding of a driver that counts its time up


class EventBus:
    """Puts the signals of a tick in order, and trusts none that was lost, doubled, late or overtaken.

    The order is total: tick, uncontrollable events before completions, priority, finger, name.  Every signal
    that comes in goes out: the bus drops nothing.  ``alarms`` are the watchdogs' uncontrollable events.

    >>> from thenar.model.events import Event
    >>> from thenar.runtime.driver import Detector
    >>> bus = EventBus(Alphabet(["lift", Event("slip", controllable=False)]))
    >>> [s.event for s in bus.arrange([Signal("lift", 0.5, 0), Signal("slip", 0.5, 0)], 0.5)]
    ['slip', 'lift']
    >>> bus.arrange([Signal("slip", 0.6, 2)], 0.6)
    Traceback (most recent call last):
    thenar.errors.Fault: 'slip': number 1 is missing (number 2 came at 0.600 s)
    """

    __slots__ = ("_keys", "_last", "_latest_s", "_max_delay_s")

    def __init__(self, alphabet: Alphabet, driver: Driver | None = None, *, max_delay_s: float = MAX_DELAY_S) -> None:
        self._max_delay_s = max_delay_s
        self._last: dict[str, int] = {}
        self._latest_s = float("-inf")
        self._keys: dict[str, tuple[bool, int, int, str]] = {
            e.name: (e.controllable, 0, _finger_of(e.name), e.name) for e in alphabet
        }
        if driver is not None:
            self._keys |= {name: (True, 0, s.finger, name) for name, s in driver.skills.items()}
            self._keys |= {name: (False, d.priority, d.finger, name) for name, d in driver.detectors.items()}

    def arrange(self, signals: Iterable[Signal], now_s: float, alarms: Sequence[str] = ()) -> list[Signal]:
        """Return ``signals`` and ``alarms`` in the order in which they are to be handled.

        Raises Fault for a signal that is no one's, doubled, missing its predecessor, from the future, delivered
        more than ``max_delay_s`` late, or older than a signal of an earlier tick.
        """
        checked = [self._checked(signal, now_s) for signal in signals]
        if checked:
            self._latest_s = max(self._latest_s, *(s.time_s for s in checked))
        checked += [Signal(event, now_s, -1) for event in alarms]
        return sorted(checked, key=lambda s: self._keys[s.event])

    def _checked(self, signal: Signal, now_s: float) -> Signal:
        event, time_s, number = signal.event, signal.time_s, signal.number
        if event not in self._keys:
            raise Fault(f"{event!r} was reported at {now_s:.3f} s: no skill and no detector has that name")
        expected = self._last.get(event, -1) + 1
        if number < expected:
            raise Fault(f"{event!r} was delivered twice (number {number}), again at {now_s:.3f} s")
        if number > expected:
            raise Fault(f"{event!r}: number {expected} is missing (number {number} came at {now_s:.3f} s)")
        self._last[event] = number
        late = now_s - time_s
        if not late >= -_FUTURE_S:  # so that no NaN passes either
            raise Fault(f"{event!r} is dated {time_s:.3f} s, but it is only {now_s:.3f} s")
        wrong = []
        if late > self._max_delay_s + _FUTURE_S:
            wrong.append(f"was delivered {1e3 * late:.0f} ms late")
        if time_s < self._latest_s:
            wrong.append(f"came out of order (dated {time_s:.4f} s, after an event of {self._latest_s:.4f} s)")
        if wrong:
            raise Fault(f"{event!r} {' and '.join(wrong)}, at {now_s:.3f} s")
        return signal


def _finger_of(event: str) -> int:
    """Return the finger of a watchdog's event, ``timeout_2``; 0 for any other."""
    tail = event.removeprefix(TIMEOUT)
    return int(tail) if tail != event and tail.isdecimal() else 0
