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
    """Return the library model that ``text`` names, as in Python: ``"glr"``, ``"dining(5)"``, ``"glr(fingers=3)"``.

    A value is a whole number, True, False or a word; the words need no quotes.  The name of each library model is a
    text that gives it.

    Raises UnknownName for a model that does not exist, InputError for arguments it does not take.

    >>> [model(text).name for text in ("dining(3)", "glr(extended)", "glr(paper, fingers=3)")]
    ['dining(3)', 'glr(extended)', 'glr(fingers=3)']
    """
    match = re.fullmatch(r"\s*(\w+)\s*(?:\(([^()]*)\))?\s*", text)
    if match is None or match[1] not in MODELS:
        raise UnknownName("model", text, MODELS)
    function = MODELS[match[1]]
    signature = inspect.signature(function)
    try:
        values, named = _arguments(match[2] or "", signature)
        signature.bind(*values, **named)
    except TypeError as error:
        takes = signature.replace(return_annotation=inspect.Signature.empty)
        raise InputError(f"model {text!r}: {error}; it is {match[1]}{takes}") from None
    try:
        return function(*values, **named)
    except UnknownName as error:  # the model is known, what it is to be is not
        raise InputError(f"model {text!r}: {error}") from None


def _arguments(text: str, signature: inspect.Signature) -> tuple[list[object], dict[str, object]]:
    """Read what stands between the parentheses; raise TypeError, as a call would, for what no call can be."""
    pieces = [piece.strip() for piece in text.split(",")]
    if not pieces[-1]:  # nothing at all, or after the last comma
        pieces.pop()
    values: list[object] = []
    named: dict[str, object] = {}
    for piece in pieces:
        match = re.fullmatch(r"(?:(\w+)\s*=\s*)?(\w+)", piece)
        if match is None:
            raise TypeError(f"an argument is a value or name=value, not {piece!r}")
        name, value = match[1], _value(match[2])
        if name is None:
            if named:
                raise TypeError(f"the value {piece!r} comes after {next(iter(named))!r}; values with a name come last")
            values.append(value)
            continue
        if name not in signature.parameters:
            raise TypeError(f"it takes no {name!r}")
        if name in named:
            raise TypeError(f"{name!r} is given twice")
        # any word is true to Python, also one that is meant to say no
        if isinstance(signature.parameters[name].default, bool) and not isinstance(value, bool):
            raise TypeError(f"{name!r} is True or False, not {value!r}")
        named[name] = value
    return values, named


def _value(word: str) -> object:
    if word in ("True", "False"):
        return word == "True"
    if not word.isdecimal():
        return word
    if len(word) > 9:
        raise TypeError("no model has that many parts")
    return int(word)
