"""Expressions looked at for all values of what they ask for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod

import numpy as np
from numpy.typing import NDArray

from thenar.model.expressions import At, Constant, Expression, Name, Value, evaluate, leaves

__all__ = ["asked_by", "holding", "never_both", "true_for"]

MAX_LOOKS = 1_000_000  # values of variables for which guards are compared
MAX_WORK = 100_000_000  # the same, all guards together


def asked_by(expression: Expression) -> list[At | Name]:
    """Return the states and variables that ``expression`` is about, each once."""
    return [leaf for leaf in dict.fromkeys(leaves(expression)) if not isinstance(leaf, Constant)]


def true_for(predicate: Expression, asked: Sequence[At | Name], values: Sequence[Sequence[Value]]) -> NDArray[np.bool_]:
    """Return where ``predicate`` is true, for all ``values`` of what it asks for; those of the last change fastest.

    >>> from thenar.model.expressions import parse
    >>> true_for(parse("n == m"), [Name("n"), Name("m")], [(0, 1), (1, 2)]).tolist()
    [False, False, True, False]
    """
    codes: dict[str, int] = {}

    def coded(value: Value) -> int:
        return codes.setdefault(value, len(codes)) if isinstance(value, str) else value

    arrays = [np.array([coded(v) for v in given]) for given in values]
    axes = [len(given) for given in arrays if len(given) != 1]  # NumPy has 64 at most
    columns = iter(np.meshgrid(*(given for given in arrays if len(given) != 1), indexing="ij"))
    place = {leaf: given[0] if len(given) == 1 else next(columns) for leaf, given in zip(asked, arrays, strict=True)}

    def known(leaf: Constant | Name | At) -> object:
        return coded(leaf.value) if isinstance(leaf, Constant) else place[leaf]

    result = np.asarray(evaluate(predicate, known), np.bool_)
    return np.broadcast_to(result, axes).ravel()


def holding(values: Sequence[Value], predicate: Expression) -> list[Value]:
    """Return those of the ``values`` of a variable for which ``predicate``, about no other, is true."""
    asked = asked_by(predicate) or [Name("")]
    return [v for v, keep in zip(values, true_for(predicate, asked, [values]).tolist(), strict=True) if keep]


def never_both(guards: Sequence[tuple[int, Expression]], domains: Mapping[str, Sequence[Value]]) -> bool:
    """Return whether no two guards of different kinds are ever true together.

    Each of ``guards`` is its kind, a number, and the guard; ``domains`` are the values of the variables.  What is
    asked of automata may be true or false.  O(guards x values of all variables that they ask for); False also if
    that is too much to look at.

    >>> from thenar.model.expressions import TRUE, parse
    >>> low, high = (1, parse("n < 2")), (2, parse("n > 1"))
    >>> never_both([low, high], {"n": range(4)}), never_both([low, (1, TRUE), high], {"n": range(4)})
    (True, False)
    """
    if len({kind for kind, _ in guards}) < 2:
        return True
    asked = list(dict.fromkeys(leaf for _, guard in guards for leaf in asked_by(guard)))
    values = [(False, True) if isinstance(leaf, At) else domains[leaf.name] for leaf in asked]
    looks = prod(map(len, values))
    if looks > MAX_LOOKS or looks * len(guards) > MAX_WORK:
        return False
    owner = np.full(looks, -1)
    for kind, guard in guards:
        true = true_for(guard, asked, values)
        if (true & (owner >= 0) & (owner != kind)).any():
            return False
        owner[true] = kind
    return True
