"""Guards and actions of one edge: when it is possible, and what becomes of the variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from thenar.io.cif import terms
from thenar.io.cif.terms import Term, TermError
from thenar.io.foreign.waters.expressions import ATOMS, Reader, chain, in_waters, primed_names
from thenar.io.foreign.waters.module import Bindings, expressions
from thenar.io.foreign.xml import Element, fail
from thenar.model.expressions import Value

__all__ = ["ALWAYS", "Case", "cases"]

MAX_CASES = 10_000  # next values that one guard leaves open


@dataclass(frozen=True, slots=True)
class Case:
    """A way to take an edge: where ``guard`` is true, and then doing ``updates``, by the names of the file."""

    guard: Term
    updates: tuple[tuple[str, Term], ...] = ()


ALWAYS = (Case(terms.truth(True)),)
_CHANGES = {"+=": "+", "-=": "-", "*=": "*", "/=": "/", "%=": "%", "&=": "&", "|=": "|"}


def cases(blocks: Sequence[Element], bindings: Bindings, reader: Reader) -> Sequence[Case]:
    """Return the cases of an edge with the guard and action ``blocks``.

    Actions are read together, over the values before.  A guard with next values ``x'`` is a relation: ``x' == e``
    is the action ``x = e``; for any other, each value that x may have afterwards is a case of its own.
    """
    guards = [g for block in blocks for tag in block.all("Guards", "Guard") for g in expressions(tag)]
    actions = [a for block in blocks for tag in block.all("Actions", "Action") for a in expressions(tag)]
    if not guards and not actions:
        return ALWAYS
    updates: dict[str, Term] = {}
    conditions: list[Term] = []
    for action in actions:
        name, value = _action(action, bindings, reader)
        if name in updates:  # both hold, as of two components that update a variable
            conditions.append(reader.equal(updates[name], value))
        else:
            updates[name] = value
    parts = [part for guard in guards for part in _conjuncts(guard)]
    asked = list(dict.fromkeys(name for part in parts for name in primed_names(part, bindings, reader.module)))
    if not asked:
        conditions += [reader.truth(part, bindings) for part in parts]
        return _case(conditions, updates, reader)
    parts = [part for part in parts if not _determines(part, bindings, reader, updates)]
    for name in asked:
        if name not in reader.variables:
            fail(guards[0], f"unknown variable {name!r}")
    opened = [name for name in asked if name not in updates]
    count = 1
    for name in opened:
        count *= len(reader.domains[name])
    if count > MAX_CASES:
        names = ", ".join(f"{name}'" for name in opened)
        fail(guards[0], f"the guard leaves {names} more than {MAX_CASES:,} values; write an action")
    reader.module.open(guards[0], count)
    found: list[Case] = []
    for values in product(*(reader.domains[name] for name in opened)):
        chosen = updates | {name: _constant(v) for name, v in zip(opened, values, strict=True)}
        found += _case([*conditions, *(reader.truth(part, bindings, chosen) for part in parts)], chosen, reader)
    return found


def _case(conditions: Sequence[Term], updates: dict[str, Term], reader: Reader) -> list[Case]:
    """Return the case, or none if it never comes true."""
    fitting = {name: reader.narrowed(name, value) for name, value in updates.items()}
    guard = terms.both(*conditions, *(where for where, _ in fitting.values()))
    return [] if guard.never else [Case(guard, tuple((name, value) for name, (_, value) in fitting.items()))]


def _constant(value: Value) -> Term:
    return terms.word(value, ATOMS) if isinstance(value, str) else terms.number(value)


def _action(element: Element, bindings: Bindings, reader: Reader) -> tuple[str, Term]:
    """Return the variable that an action assigns to, and its new value."""
    operator, sides = element.attributes.get("Operator", ""), expressions(element)
    if element.tag != "BinaryExpression" or len(sides) != 2 or (operator != "=" and operator not in _CHANGES):
        fail(element, f"an action is x = VALUE, or one of {' '.join(_CHANGES)}")
    name = reader.assigned(sides[0], bindings)
    if operator == "=":
        return name, reader.new_value(name, sides[1], bindings)
    before, value = reader.variables[name], reader.term(sides[1], bindings)
    try:
        new = reader.combined(_CHANGES[operator], before, value)
    except TermError as error:
        fail(element, in_waters(error))
    return name, reader.fitted(name, new, element)


def _conjuncts(guard: Element) -> list[Element]:
    is_and = guard.tag == "BinaryExpression" and guard.attributes.get("Operator") == "&"
    return chain(guard) if is_and else [guard]


def _determines(part: Element, bindings: Bindings, reader: Reader, updates: dict[str, Term]) -> bool:
    """Return whether ``part`` is x' == VALUE for an x without a new value so far; it has that one then."""
    if part.tag != "BinaryExpression" or part.attributes.get("Operator") != "==":
        return False
    sides = expressions(part)
    for one, other in (sides, sides[::-1]) if len(sides) == 2 else ():
        inner = expressions(one)
        if one.tag == "UnaryExpression" and one.attributes.get("Operator") == "'" and inner:
            name = reader.assigned(inner[0], bindings)
            if name not in updates and not primed_names(other, bindings, reader.module):
                updates[name] = reader.new_value(name, other, bindings)
                return True
    return False
