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
    """Return the library model that ``text`` names, as in Python: ``"glr"``, ``"dining(5)"``, ``"glr(extended)"``.

    Raises UnknownName for a model that does not exist, InputError for arguments it does not take.

    >>> model("dining(3)").name, model("glr(extended)").name
    ('dining(3)', 'glr(extended)')
    """
    match = re.fullmatch(r"\s*(\w+)\s*(?:\(([\s\w,]*)\))?\s*", text)
    if match is None or match[1] not in MODELS:
        raise UnknownName("model", text, MODELS)
    function = MODELS[match[1]]
    signature = inspect.signature(function)
    words = (match[2] or "").replace(",", " ").split()
    try:
        if any(word.isdecimal() and len(word) > 9 for word in words):
            raise TypeError("no model has that many parts")
        arguments = [int(word) if word.isdecimal() else word for word in words]
        signature.bind(*arguments)
    except TypeError as error:
        takes = signature.replace(return_annotation=inspect.Signature.empty)
        raise InputError(f"model {text!r}: {error}; it is {match[1]}{takes}") from None
    try:
        return function(*arguments)
    except UnknownName as error:  # the model is known, what it is to be is not
        raise InputError(f"model {text!r}: {error}") from None
