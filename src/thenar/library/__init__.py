"""Ready models as functions that return a Problem: the paper's task, and the textbooks'."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping

from thenar.errors import InputError, UnknownName
from thenar.library import classics, glr
from thenar.model.problem import Problem

__all__ = ["MODELS", "classics", "glr", "model"]

MODELS: Mapping[str, Callable[..., Problem]] = {
    "glr": glr.problem,
    **{name: getattr(classics, name) for name in sorted(classics.__all__)},
}


def model(text: str) -> Problem:
    """Return the library model that ``text`` names, as in Python: ``"glr"``, ``"dining(5)"``.

    Raises UnknownName for a model that does not exist, InputError for arguments it does not take.

    >>> model("dining(3)").name
    'dining(3)'
    """
    match = re.fullmatch(r"\s*(\w+)\s*(?:\(([\s\d,]*)\))?\s*", text)
    if match is None or match[1] not in MODELS:
        raise UnknownName("model", text, MODELS)
    function = MODELS[match[1]]
    arguments = [int(word) for word in (match[2] or "").replace(",", " ").split()]
    most = sum(p.kind is not p.KEYWORD_ONLY for p in inspect.signature(function).parameters.values())
    if len(arguments) > most:
        takes = "no argument" if most == 0 else f"at most {most} argument{'s' * (most > 1)}"
        raise InputError(f"model {match[1]!r} takes {takes}: {match[1]}{inspect.signature(function)}")
    try:
        return function(*arguments)
    except TypeError:
        raise InputError(f"model {match[1]!r} needs arguments: {match[1]}{inspect.signature(function)}") from None
