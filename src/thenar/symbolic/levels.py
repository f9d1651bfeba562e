"""Levels of decision diagrams: what each stands for, in which order they are, and what predicates say of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from thenar._native import kernel
from thenar.errors import InputError
from thenar.model.automaton import Automaton
from thenar.model.expressions import FALSE, TRUE, At, Constant, Expression, Name, Operation, Value, evaluate, leaves
from thenar.model.extended import ExtendedAutomaton, Variable
from thenar.model.limits import Limits
from thenar.model.names import Listed, StateNames
from thenar.symbolic.order import find_order

__all__ = ["MAX_TABLE", "Levels", "Part", "automaton_part", "code", "variable_part"]

MAX_TABLE = 1 << 22  # combinations of values that one comparison or update may have
CACHE_BYTES = 1 << 29  # at most, for results of operations on diagrams
COLLECT_AT = 1 << 16  # nodes


@dataclass(frozen=True, slots=True)
class Part:
    """What one level stands for: an automaton, its ``labels`` the states, or a variable with its ``values``."""

    name: str
    labels: StateNames
    values: tuple[Value, ...]
    initial: NDArray[np.bool_]
    marked: NDArray[np.bool_]

    @property
    def size(self) -> int:
        """How many values it has."""
        return len(self.initial)


class Levels:
    """A forest of decision diagrams with a level for each of ``parts``.

    ``order`` (n_parts,) lists the parts from the top level down, and whether its reverse may be as good is
    ``reversible``; ``level`` (n_parts,) is the level of each.
    """

    def __init__(self, parts: Sequence[Part], tick: kernel.Ticker) -> None:
        self.parts, self.tick = list(parts), tick
        self.number = {p.name: k for k, p in enumerate(self.parts)}
        self._coded: dict[int, NDArray[np.generic]] = {}
        self._places: dict[int, dict[int | bool, int]] = {}

    def arrange(self, edges: Sequence[Sequence[int]], order: str | Sequence[str], limits: Limits | None) -> None:
        """Put the parts in ``order``; a heuristic keeps those together that are in one of ``edges``."""
        self.order, self.reversible = self._order(order, edges)
        n = len(self.parts)
        self.level = np.empty(n, np.int64)
        self.level[self.order] = np.arange(n, 0, -1)
        most = _most_bytes(limits)
        sizes = np.array([self.parts[k].size for k in self.order[::-1]], np.uint32)
        self.forest = kernel.Forest(sizes, most, min(CACHE_BYTES, most), COLLECT_AT)
        self.forest.watched_by(self.tick)
        self._sets: dict[Expression, kernel.Set] = {TRUE: self.forest.everything, FALSE: self.forest.nothing}

    def bound(self, limits: Limits | None) -> None:
        """Let the diagrams grow as large as ``limits`` say from now on."""
        self.forest.max_bytes = _most_bytes(limits)

    def at_leisure(self) -> None:
        """Let nothing but Ctrl-C stop what is asked from now on."""
        self.tick = kernel.Ticker()
        self.forest.watched_by(self.tick)
        self.bound(None)

    def _order(self, order: str | Sequence[str], edges: Sequence[Sequence[int]]) -> tuple[NDArray[np.uint32], bool]:
        if isinstance(order, str):
            return find_order(len(self.parts), edges, order, self.tick)
        if sorted(order) != sorted(self.number):
            missing = sorted(set(self.number) ^ set(order))[:5]
            raise InputError(
                f"an order lists every automaton and variable once; look at {', '.join(missing) or 'repetitions'}"
            )
        return np.array([self.number[name] for name in order], np.uint32), False

    def literal(self, part: int, mask: NDArray[np.bool_]) -> kernel.Set:
        """Return the states in which ``part`` has one of the values with ``mask[value]``."""
        return self.forest.literal(int(self.level[part]), mask.astype(np.uint8))

    def first(self, states: kernel.Set) -> tuple[int, ...]:
        """Return the first of ``states``: the value of each part."""
        levels = states.vectors(1)
        row = np.empty_like(levels)
        row[self.order] = levels
        return tuple(row.tolist())

    def only(self, row: Sequence[int]) -> kernel.Set:
        """Return the set of this one state."""
        masks = [self.literal(k, np.arange(self.parts[k].size) == v) for k, v in enumerate(row)]
        return self.forest.all_of(masks, self.tick)

    def support(self, expression: Expression) -> set[int]:
        """Return the parts that ``expression`` speaks of."""
        return {
            self.number[leaf.automaton if isinstance(leaf, At) else leaf.name]
            for leaf in leaves(expression)
            if not isinstance(leaf, Constant)
        }

    def predicate(self, expression: Expression) -> kernel.Set:
        """Return the states in which ``expression`` is true."""
        found = self._sets.get(expression)
        if found is None:
            found = self._sets[expression] = self._predicate(expression)
        return found

    def _predicate(self, expression: Expression) -> kernel.Set:
        if isinstance(expression, At):
            part = self.number[expression.automaton]
            return self.literal(part, self._at(part, expression.state))
        if isinstance(expression, Operation) and expression.operator in ("and", "or"):
            sets = [self.predicate(x) for x in expression.operands]
            fold = self.forest.all_of if expression.operator == "and" else self.forest.any_of
            return fold(sets, self.tick)
        if isinstance(expression, Operation) and expression.operator == "not":
            return ~self.predicate(expression.operands[0])
        parts = self.falling(self.support(expression))
        truth = np.broadcast_to(self.table_of(expression, parts), [self.parts[p].size for p in parts])
        return self.forest.table([int(self.level[p]) for p in parts], truth.astype(np.uint8).ravel())

    def _at(self, part: int, state: str) -> NDArray[np.bool_]:
        labels = self.parts[part].labels
        return np.array([labels[q] == state for q in range(len(labels))], np.bool_)

    def _codes(self, part: int) -> NDArray[np.generic]:
        if part not in self._coded:
            self._coded[part] = np.array([code(v) for v in self.parts[part].values])
        return self._coded[part]

    def place(self, part: int) -> dict[int | bool, int]:
        """Return which value of ``part`` has each code."""
        if part not in self._places:
            self._places[part] = {c: k for k, c in enumerate(self._codes(part).tolist())}
        return self._places[part]

    def falling(self, parts: Iterable[int]) -> list[int]:
        """Sort ``parts`` from the top level down."""
        return sorted(parts, key=lambda p: -self.level[p])

    def table_of(self, expression: Expression, parts: Sequence[int]) -> NDArray[np.generic]:
        """Return the value of ``expression`` for all values of ``parts``, an axis each."""
        sizes = [self.parts[p].size for p in parts]
        if prod(sizes) > MAX_TABLE:
            names = ", ".join(self.parts[p].name for p in parts)
            raise InputError(
                f"expression {expression}: {prod(sizes):,} combinations of {names}; {MAX_TABLE:,} are the most"
            )
        axis = {p: k for k, p in enumerate(parts)}

        def value(leaf: Constant | Name | At) -> NDArray[np.generic]:
            if isinstance(leaf, Constant):
                return np.asarray(code(leaf.value))
            part = self.number[leaf.automaton if isinstance(leaf, At) else leaf.name]
            row = self._at(part, leaf.state) if isinstance(leaf, At) else self._codes(part)
            shape = [1] * len(parts)
            shape[axis[part]] = len(row)
            return row.reshape(shape)

        result: NDArray[np.generic] = np.asarray(evaluate(expression, value))
        return result


def _most_bytes(limits: Limits | None) -> int:
    bound = (limits or Limits()).bytes
    return (1 << 63) - 1 if bound is None else bound


def automaton_part(automaton: Automaton | ExtendedAutomaton) -> Part:
    """Return the part that an automaton is; without states it has one value, in which nothing begins."""
    if not len(automaton.states):
        nowhere = np.zeros(1, np.bool_)
        return Part(automaton.name, Listed(("nowhere",)), (), nowhere, nowhere)
    if isinstance(automaton, ExtendedAutomaton):
        masks = (np.array(mask, np.bool_) for mask in (automaton.initial, automaton.marked))
        return Part(automaton.name, Listed(automaton.states), (), *masks)
    initial = np.zeros(automaton.n_states, np.bool_)
    initial[automaton.initial] = True
    return Part(automaton.name, automaton.states, (), initial, automaton.marked)


def variable_part(variable: Variable) -> Part:
    """Return the part that a variable is."""
    masks = (np.array([v in chosen for v in variable.values]) for chosen in (variable.initial, variable.marked))
    return Part(variable.name, Listed(tuple(map(_written, variable.values))), variable.values, *masks)


def _written(value: Value) -> str:
    return str(Constant(value))


def code(value: Value) -> int | bool:
    """Return a number for ``value``; different names get different numbers."""
    return _CODES.setdefault(value, len(_CODES)) if isinstance(value, str) else value


_CODES: dict[str, int] = {}
