"""The exceptions of thenar: one tree, each error naming the thing, the place and the way out.

::

    ThenarError
    ├── InputError            what was given is wrong; the command line exits with 2
    │   ├── UnknownName       no event, state, automaton or model has that name
    │   ├── ModelError        a model cannot be built; ``mistakes`` lists every reason
    │   ├── AlphabetClash     one event, two meanings (controllable here, uncontrollable there)
    │   └── CertificateError  a file is not a certificate, or not a whole one
    ├── LimitReached          a computation stopped at one of its ``limits``; carries what was found out
    └── Fault                 a plant in the loop is not to be trusted any more; the run ends in a safe stop
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

__all__ = [
    "AlphabetClash",
    "CertificateError",
    "Fault",
    "InputError",
    "LimitReached",
    "Mistake",
    "ModelError",
    "ThenarError",
    "UnknownName",
    "did_you_mean",
]


class ThenarError(Exception):
    """Base of every exception that thenar raises on purpose.

    >>> issubclass(UnknownName, InputError) and issubclass(LimitReached, ThenarError)
    True
    """


class InputError(ThenarError):
    """What the caller gave is wrong; nothing was computed and nothing was written.

    >>> raise InputError("a problem needs a plant")
    Traceback (most recent call last):
    thenar.errors.InputError: a problem needs a plant
    """


class UnknownName(InputError, KeyError):
    """No ``kind`` is called ``name``; the message offers the nearest name that exists.

    >>> raise UnknownName("event", "aproach_1", ["approach_1", "approach_2"])
    Traceback (most recent call last):
    thenar.errors.UnknownName: unknown event 'aproach_1'; did you mean 'approach_1'?
    """

    def __init__(self, kind: str, name: object, known: Iterable[str], where: str = "") -> None:
        prefix = f"{where}: " if where else ""
        super().__init__(f"{prefix}unknown {kind} {name!r}{did_you_mean(str(name), known)}")

    def __reduce__(self) -> tuple[Any, ...]:
        return _revive, (type(self), self.args, self.__dict__)

    def __str__(self) -> str:  # KeyError would show the repr of the message
        return str(self.args[0])


@dataclass(frozen=True, slots=True)
class Mistake:
    """One thing that is wrong in a model: ``where`` it is (file and line, or a name) and ``what`` it is.

    >>> print(Mistake("hand.toml:3", "no initial state"))
    hand.toml:3: no initial state
    """

    where: str
    what: str

    def __str__(self) -> str:
        return f"{self.where}: {self.what}" if self.where else self.what


class ModelError(InputError):
    """A model cannot be built.  ``mistakes`` holds all that is wrong with it, in the order of the source.

    >>> raise ModelError([Mistake("hand.toml:3", "no initial state"), Mistake("hand.toml:9", "unknown event 'x'")])
    Traceback (most recent call last):
    thenar.errors.ModelError: hand.toml:3: no initial state   (1 of 2 problems)
    hand.toml:9: unknown event 'x'   (2 of 2 problems)
    """

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        self.mistakes = tuple(mistakes)
        n = len(self.mistakes)
        counted = [f"   ({k} of {n} problems)" if n > 1 else "" for k in range(1, n + 1)]
        super().__init__("\n".join(f"{m}{c}" for m, c in zip(self.mistakes, counted, strict=True)))

    def __reduce__(self) -> tuple[Any, ...]:
        return ModelError, (self.mistakes,)


class AlphabetClash(InputError):
    """The same event has different properties in two automata that are to be composed.

    >>> from thenar.model.events import Alphabet, Event
    >>> Alphabet([Event("slip")]) | Alphabet([Event("slip", controllable=False)])
    Traceback (most recent call last):
    thenar.errors.AlphabetClash: event 'slip' is controllable in automaton 1 and uncontrollable in automaton 2; ...
    """


class CertificateError(InputError):
    """A file is no certificate, or a damaged one.

    >>> from thenar.synthesis.verify import verify
    >>> verify("nowhere.cert")
    Traceback (most recent call last):
    thenar.errors.CertificateError: nowhere.cert: No such file or directory
    """


class LimitReached(ThenarError):
    """A computation stopped at one of its limits.

    ``limit`` names it (``"states"``, ``"transitions"``, ``"bytes"`` or ``"seconds"``); ``states`` and
    ``transitions`` are what had been found by then; ``found`` says it in words, for diagrams by their nodes.

    >>> raise LimitReached("states", 1000, 1007, 2311)
    Traceback (most recent call last):
    thenar.errors.LimitReached: stopped at the limit of 1,000 states: 1,007 states and 2,311 transitions found ...
    """

    def __init__(self, limit: str, bound: float, states: int, transitions: int, found: str = "") -> None:
        self.limit, self.bound, self.states, self.transitions = limit, bound, states, transitions
        self.found = found or f"{states:,} states and {transitions:,} transitions found so far"
        at = f"{bound:,.0f}" if bound == int(bound) else f"{bound:g}"
        way_out = "raise the limit or make the model smaller"
        super().__init__(f"stopped at the limit of {at} {limit}: {self.found}; {way_out}")

    def __reduce__(self) -> tuple[Any, ...]:
        return LimitReached, (self.limit, self.bound, self.states, self.transitions, self.found)


class Fault(ThenarError):
    """A plant in the loop is not to be trusted any more: the message names the part and what it did.

    >>> raise Fault("sensor 'force_1_x' reports nan at 1.250 s")
    Traceback (most recent call last):
    thenar.errors.Fault: sensor 'force_1_x' reports nan at 1.250 s
    """


def _revive(cls: type[UnknownName], args: tuple[Any, ...], fields: dict[str, Any]) -> UnknownName:
    """Make an UnknownName again after it was pickled; its message is kept, what it was made from is not."""
    error = cls.__new__(cls, *args)
    error.args = args
    error.__dict__.update(fields)
    return error


def counted(n: int, noun: str) -> str:
    """Return ``"1 state"``, ``"2,809 states"``."""
    return f"{n:,} {noun}{'s' * (n != 1)}"


_COMPARED = 60  # characters of a name for which the nearest is looked for; it takes the cube of them


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the known name nearest to ``name``; for none, and a long one, nothing."""
    if len(name) > _COMPARED:
        return ""
    near = get_close_matches(name, list(known), n=1, cutoff=0.6)
    return f"; did you mean {near[0]!r}?" if near else ""


def about(count: int) -> str:
    """Write ``count`` in full if it is short, else its first digits and its magnitude.

    >>> about(28 ** 4), about(28 ** 300)
    ('614,656', '1.40e434')
    """
    if count < 10**15:
        return f"{count:,}"
    digits = _decimal(count)
    return f"{digits[0]}.{digits[1:3]}e{len(digits) - 1}"


def _decimal(count: int) -> str:
    """Return the digits of ``count``, of which there may be more than ``str`` is willing to write."""
    pieces = []
    while count:
        count, piece = divmod(count, 10**4000)
        pieces.append(f"{piece:04000d}" if count else str(piece))
    return "".join(reversed(pieces))
