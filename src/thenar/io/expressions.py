"""Expressions as texts of a model file: how long they may be, so that each that is written can be read."""

from __future__ import annotations

from thenar.errors import InputError, about
from thenar.model.expressions import MAX_DEPTH, Expression, Operation, Value, parse

__all__ = ["MAX_EXPRESSION", "MAX_TEXT", "read", "written"]

MAX_EXPRESSION = 100_000  # characters of one; a tenth of a second
MAX_TEXT = 5_000_000  # characters of all in a model; some ten seconds


def read(text: Value) -> Expression:
    """Return the expression that ``text`` writes; raise InputError for one that cannot be read or is too long.

    >>> print(read("stock < 3 and CUP.up"))
    stock < 3 and CUP.up
    """
    if isinstance(text, str) and len(text) > MAX_EXPRESSION:
        raise InputError(f"an expression of {len(text):,} characters; {MAX_EXPRESSION:,} are enough")
    return parse(text)


def written(expression: Expression, where: str) -> str:
    """Return the text that :func:`read` gives ``expression`` back from.

    Raises InputError, naming ``where``, for one that is too long or nested too deep: guards of a large supervisor
    may share parts, and are a thousand times as long written out.

    >>> written(Operation("not", (read("CUP.up"),)), "here")
    'not CUP.up'
    """
    size, depth = _measure(expression, {})
    if size > MAX_EXPRESSION // 2:  # a name and an operator at least
        raise InputError(f"{where}: an expression of {about(size)} names and operators is too long for a model file")
    if depth > MAX_DEPTH:
        raise InputError(f"{where}: an expression nested deeper than {MAX_DEPTH} cannot be read from a model file")
    text = str(expression)
    if len(text) > MAX_EXPRESSION:
        raise InputError(f"{where}: an expression of {len(text):,} characters is too long for a model file")
    return text


def _measure(expression: Expression, known: dict[int, tuple[int, int]]) -> tuple[int, int]:
    """Return how many names and operators ``expression`` has, and how deep it is; shared parts are looked at once."""
    todo = [expression]
    while todo:  # not recursive: it may be deeper than Python's stack
        x = todo[-1]
        if not isinstance(x, Operation):
            known[id(x)] = (1, 0)
        elif unknown := [part for part in x.operands if id(part) not in known]:
            todo += unknown
            continue
        else:
            inner = [known[id(part)] for part in x.operands]
            known[id(x)] = (
                max(1, len(inner) - 1) + sum(n for n, _ in inner),
                1 + max((d for _, d in inner), default=0),
            )
        todo.pop()
    return known[id(expression)]
