"""Variables with finitely many values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from thenar.errors import Mistake, ModelError, did_you_mean
from thenar.model.expressions import Value, is_writable

__all__ = ["Variable"]

MAX_VALUES = 1_000_000  # a tuple of them is held for each variable
_WORD = 2**63  # whole numbers are evaluated in 64 bits


@dataclass(frozen=True, slots=True, init=False)
class Variable:
    """A variable with finitely many values: whole numbers, False and True, or the literals of an enumeration.

    ``initial`` are the values that it may have at first (one, or several of which any may be the first; by
    default the first of its values), ``marked`` those that it may have in a marked state (by default all).

    Raises ModelError with all mistakes at once.

    >>> Variable("stock", range(4)), Variable("lamp", ["red", "green"], initial="green").initial
    (Variable(name='stock', values=(0, 1, 2, 3), initial=(0,), marked=(0, 1, 2, 3)), ('green',))
    """

    name: str
    values: tuple[Value, ...]
    initial: tuple[Value, ...]
    marked: tuple[Value, ...]

    def __init__(
        self,
        name: str,
        values: Iterable[Value],
        initial: Value | Iterable[Value] | None = None,
        marked: Value | Iterable[Value] | None = None,
    ) -> None:
        domain = _listed(values)
        first = domain[:1] if initial is None else _listed(initial)
        last = domain if marked is None else _listed(marked)
        wrong = [] if is_writable(name) else [_NAME]
        if isinstance(values, (str, int)):
            wrong.append(f"its values are a list, not {values!r}")
        else:
            wrong += _wrong_values(domain)
        if not wrong:
            wrong += _wrong_choice("initial", first, domain)
            wrong += _wrong_choice("marked", last, domain)
        if not first and domain:
            wrong.append("no initial value")
        if wrong:
            raise ModelError([Mistake(f"variable {name!r}", what) for what in wrong])
        for attribute, value in (("name", name), ("values", domain), ("initial", first), ("marked", last)):
            object.__setattr__(self, attribute, value)


_NAME = "a name is made of letters, digits, _ and dots, begins with a letter, and is no word of Python or true or false"


def _listed(values: Value | Iterable[Value]) -> tuple[Value, ...]:
    """Return ``values`` as Python's own, at most one more than there may be."""
    one = isinstance(values, (str, int, np.generic))
    several: Iterable[Value] = (values,) if one else values  # type: ignore[assignment]
    return tuple(v.item() if isinstance(v, np.generic) else v for v in islice(several, MAX_VALUES + 1))


def _wrong_values(domain: Sequence[Value]) -> list[str]:
    if not domain:
        return ["no value to take"]
    if len(domain) > MAX_VALUES:
        return [f"more than {MAX_VALUES:,} values"]
    kinds = {type(v) for v in domain}
    if len(kinds) > 1 or not kinds <= {bool, int, str}:
        return ["its values must be all whole numbers, all truths or all names"]
    if len(set(domain)) < len(domain):
        seen: set[Value] = set()
        twice = next(v for v in domain if v in seen or seen.add(v))  # type: ignore[func-returns-value]
        return [f"value {twice!r} is listed twice"]
    if kinds == {int} and not all(-_WORD <= v < _WORD for v in domain):  # type: ignore[operator]
        return ["its values do not fit into 64 bits"]
    return []


def _wrong_choice(what: str, chosen: Sequence[Value], domain: Sequence[Value]) -> list[str]:
    known = {(type(v), v) for v in domain}
    wrong = []
    for v in chosen:
        if (type(v), v) not in known:
            hint = did_you_mean(v, [str(d) for d in domain]) if isinstance(v, str) else ""
            wrong.append(f"its {what} value {v!r} is none of its values{hint}")
    if len(set(chosen)) < len(chosen) and not wrong:
        wrong.append(f"an {what} value is listed twice" if what == "initial" else f"a {what} value is listed twice")
    return wrong
