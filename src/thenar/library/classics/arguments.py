"""The one check that the model functions share: how many of the parts that a model repeats."""

from __future__ import annotations

from thenar.errors import InputError

__all__ = ["check_count"]


def check_count(model: str, name: str, value: object, *, least: int, things: str) -> None:
    """Raise InputError unless ``value`` is a whole number of at least ``least``.

    >>> check_count("dining", "n", 1, least=2, things="philosophers")
    Traceback (most recent call last):
    thenar.errors.InputError: dining: n must be a whole number of philosophers, at least 2, not 1
    """
    # True is an int to Python, but no count
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise InputError(f"{model}: {name} must be a whole number of {things}, at least {least}, not {value!r}")
