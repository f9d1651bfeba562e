"""Guards: for each controllable event a predicate that says where the supervisor enables it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from thenar._native import kernel
from thenar.model.expressions import FALSE, TRUE, At, Constant, Expression, Name, Operation, conjunction
from thenar.model.extended import ExtendedProblem, needs
from thenar.symbolic.encode import Encoding, EventRelation
from thenar.symbolic.levels import Part
from thenar.symbolic.synthesis import SymbolicSupervisor

__all__ = ["Guards", "expanded", "guards", "supervised"]

READABLE = 12  # terms that a guard may have and still be read


@dataclass(frozen=True, slots=True)
class Guards(Mapping[str, Expression]):
    """Guards by controllable event, in the order of the alphabet.

    A guard of more than a dozen terms is written as decisions; what guards share stands in ``definitions`` by a
    name, each after those that it uses.

    >>> from thenar.model.expressions import parse
    >>> print(Guards({"start": parse("BUFFER.empty and d1")}, {"d1": parse("n < 3")}))
    d1 := n < 3
    start if BUFFER.empty and d1
    """

    predicates: Mapping[str, Expression]
    definitions: Mapping[str, Expression]

    def __getitem__(self, event: str) -> Expression:
        return self.predicates[event]

    def __iter__(self) -> Iterator[str]:
        return iter(self.predicates)

    def __len__(self) -> int:
        return len(self.predicates)

    def __str__(self) -> str:
        lines = [f"{name} := {predicate}" for name, predicate in self.definitions.items()]
        return "\n".join([*lines, *(f"{event} if {guard}" for event, guard in self.predicates.items())])


def guards(supervisor: SymbolicSupervisor) -> Guards:
    """Return for each controllable event the predicate under which ``supervisor`` enables it.

    The supervised system is the plants and the specifications that are automata, synchronised, each controllable
    event with its guard besides.  A guard says ``true`` if it has nothing to add to these, ``false`` if its event
    never happens, and otherwise is simplified with respect to what they reach: it may say anything where they
    cannot do the event anyway.

    >>> from thenar.library.classics import cat_and_mouse
    >>> from thenar.synthesis.api import synthesize
    >>> found = guards(synthesize(cat_and_mouse(), "symbolic").symbolic)
    >>> print(found["c1"], "|", found["c3"])
    true | ROOM4.mouse
    """
    encoding = supervisor.encoding
    enabling = _Enabling(supervisor)
    sets = {e.name: enabling(e) for e in encoding.events if e.controllable}
    everything = encoding.forest.everything
    writer = _Writer(encoding)
    predicates = {e.name: writer.write(sets.get(e.name, everything)) for e in encoding.alphabet if e.controllable}
    return Guards(predicates, writer.definitions)


def supervised(supervisor: SymbolicSupervisor) -> ExtendedProblem:
    """Return the supervised system as automata and guards: a plant that by itself does just what it may.

    Plants and specifications that are automata are its plants, guards its conditions; if only some initial states
    survive, its ``initial`` predicate says which.

    >>> from thenar.library.classics import cat_and_mouse
    >>> from thenar.synthesis.api import synthesize
    >>> supervised(synthesize(cat_and_mouse(), "symbolic").symbolic).plant_conditions[0].event
    'c3'
    """
    encoding, found = supervisor.encoding, guards(supervisor)
    problem = ExtendedProblem.of(encoding.problem)
    whole = {e: expanded(guard, found.definitions) for e, guard in found.items()}
    kept = supervisor.controlled & encoding.initial
    starts = _Writer(encoding)
    narrowed = expanded(starts.write(kept.simplify(encoding.initial) if kept else kept), starts.definitions)
    return ExtendedProblem(
        [
            *problem.plants,
            *problem.specs,
            *problem.plant_conditions,
            *(needs(e, g) for e, g in whole.items() if g != TRUE),
        ],
        variables=problem.variables,
        initial=conjunction([problem.initial, narrowed]),
        marked=problem.marked,
        name=f"{problem.name} supervised".strip(),
        alphabet=problem.alphabet,
        description=problem.description,
    )


def expanded(predicate: Expression, definitions: Mapping[str, Expression]) -> Expression:
    """Return ``predicate`` with the definitions put in that it uses; shared parts stay shared in memory."""
    known: dict[str, Expression] = {}

    def put(x: Expression) -> Expression:
        if isinstance(x, Name):
            return known.get(x.name, x)
        return Operation(x.operator, tuple(put(p) for p in x.operands)) if isinstance(x, Operation) else x

    for name, definition in definitions.items():  # each after those that it uses
        known[name] = put(definition)
    return put(predicate)


class _Enabling:
    """Finds small sets that hold, of the states offering an event, just those that may do it.

    The states that are safe, and those that are controlled, are each the intersection of sets over separate levels; for
    an event only those count that it touches: of the others none can become unsafe.
    """

    def __init__(self, supervisor: SymbolicSupervisor) -> None:
        self.forest = supervisor.encoding.forest
        self.safe = _Factors(supervisor.safe.simplify(supervisor.reachable))
        self.controlled = _Factors(supervisor.controlled)
        self.tick, self.invariant = supervisor.encoding.tick, supervisor.encoding.invariant
        self.is_empty = supervisor.is_empty

    def __call__(self, event: EventRelation) -> kernel.Set:
        if self.is_empty:
            return self.forest.nothing
        touched = set(self.forest.relation_support(event.relation))
        back = self.forest.inverse(event.relation)
        # a step that would break an invariant of the plant is none, and so leads to nothing unsafe
        lost = [self.forest.image(self.invariant - f, back) & event.offered for f in self.safe(touched)]
        harmful = self.forest.any_of([event.offered - event.allowed, *lost], self.tick)
        if not harmful:
            return self.forest.everything
        spoken_of = touched.union(harmful.support(), event.offered.support())
        within = self.controlled(spoken_of)
        off = self.forest.all_of(within, self.tick, harmful)
        if not off:
            return self.forest.everything
        may = self.forest.all_of(within, self.tick, event.offered)
        return (may - off).simplify(may)


class _Factors:
    """Sets over separate levels whose intersection is a given one."""

    def __init__(self, states: kernel.Set) -> None:
        self.factors = states.factors()
        self.at = {level: k for k, f in enumerate(self.factors) for level in f.support()}

    def __call__(self, levels: Iterable[int]) -> list[kernel.Set]:
        """Return those that speak of one of ``levels``."""
        return [self.factors[k] for k in sorted({self.at[level] for level in levels if level in self.at})]


class _Writer:
    """Turns sets into predicates; what large ones share gets a name."""

    def __init__(self, encoding: Encoding) -> None:
        self.encoding = encoding
        self.definitions: dict[str, Expression] = {}
        self._written: list[Expression] = [FALSE, TRUE]  # by number of a node
        self._numbers: dict[tuple[int, tuple[int, ...]], int] = {}  # of its level and children
        self._literals: dict[tuple[int, tuple[int, ...]], _Literal] = {}

    def write(self, states: kernel.Set) -> Expression:
        """Return a predicate that is true exactly in ``states``."""
        positive = self._sum(states)
        negative = self._sum(~states)
        if negative is not None and (positive is None or _terms(negative) < _terms(positive)):
            return _all([_any([literal.negated for literal in product]) for product in negative])
        if positive is None:
            return self._decide(states)
        return _any([_all([literal.positive for literal in product]) for product in positive])

    def _sum(self, states: kernel.Set) -> list[list[_Literal]] | None:
        """Return products of literals, one of which holds exactly in ``states``; None if it takes many."""
        products = states.products(states, READABLE)
        if products is None:
            return None
        return [[self._literal(level, tuple(vs)) for level, vs in product] for product in products]

    def _literal(self, level: int, values: tuple[int, ...]) -> _Literal:
        found = self._literals.get((level, values))
        if found is None:
            positive = _literal(self._part(level), values)
            found = self._literals[level, values] = _Literal(positive, _opposite(positive), _size(positive))
        return found

    def _part(self, level: int) -> Part:
        return self.encoding.parts[int(self.encoding.order[len(self.encoding.order) - level])]

    def _decide(self, states: kernel.Set) -> Expression:
        """Write a diagram as it is, from the bottom up: for each value what else must hold."""
        levels, kids = (x.tolist() for x in states.dump())
        numbers, first = [0, 1], 0
        for level in levels:
            part = self._part(level)
            own = tuple(numbers[kid] for kid in kids[first : first + part.size])
            first += part.size
            if (level, own) not in self._numbers:
                self._numbers[level, own] = len(self._written)
                self._written.append(self._named(level, own))
            numbers.append(self._numbers[level, own])
        return self._written[numbers[-1]]

    def _named(self, level: int, kids: tuple[int, ...]) -> Expression:
        by_kid: dict[int, list[int]] = {}
        for value, kid in enumerate(kids):
            by_kid.setdefault(kid, []).append(value)
        predicate = _any(
            [
                _all([self._literal(level, tuple(values)).positive, self._written[kid]])
                for kid, values in by_kid.items()
                if kid
            ]
        )
        if _size(predicate) == 1:
            return predicate
        name = f"d{len(self.definitions) + 1}"
        self.definitions[name] = predicate
        return Name(name)


class _Literal(NamedTuple):
    """That a part has one of some values, or none of them; how many terms it takes to say so."""

    positive: Expression
    negated: Expression
    size: int


def _terms(products: Sequence[Sequence[_Literal]]) -> int:
    return sum(literal.size for product in products for literal in product)


def _literal(part: Part, values: Sequence[int]) -> Expression:
    """Say that ``part`` has one of ``values``, in few words."""
    others = [v for v in range(part.size) if v not in set(values)]
    if not part.values:
        if len(values) <= len(others):
            return _any([At(part.name, part.labels[v]) for v in values])
        return _all([Operation("not", (At(part.name, part.labels[v]),)) for v in others])
    name, domain = Name(part.name), part.values
    if isinstance(domain[0], bool):
        return name if domain[values[0]] else Operation("not", (name,))
    if isinstance(domain[0], int) and len(values) > 1 and list(domain) == sorted(domain):
        lo, hi = values[0], values[-1]
        if hi - lo + 1 == len(values):
            low = [] if lo == 0 else [Operation(">=", (name, Constant(domain[lo])))]
            high = [] if hi == len(domain) - 1 else [Operation("<=", (name, Constant(domain[hi])))]
            return _all([*low, *high])
    if len(values) <= len(others):
        return _any([Operation("==", (name, Constant(domain[v]))) for v in values])
    return _all([Operation("!=", (name, Constant(domain[v]))) for v in others])


def _join(operator: str, unit: Expression, parts: Sequence[Expression]) -> Expression:
    flat: list[Expression] = []
    for p in parts:
        if isinstance(p, Operation) and p.operator == operator:
            flat.extend(p.operands)
        elif not isinstance(p, Constant) or p != unit:
            flat.append(p)
    return unit if not flat else flat[0] if len(flat) == 1 else Operation(operator, tuple(flat))


def _all(parts: Sequence[Expression]) -> Expression:
    return _join("and", TRUE, parts)


def _any(parts: Sequence[Expression]) -> Expression:
    return _join("or", FALSE, parts)


_MIRROR = {"==": "!=", "!=": "==", "<=": ">", ">=": "<", "<": ">=", ">": "<="}


def _opposite(predicate: Expression) -> Expression:
    """Return the negation, pushed inwards."""
    if isinstance(predicate, Operation):
        if predicate.operator == "not":
            return predicate.operands[0]
        if predicate.operator in ("and", "or"):
            dual, unit = ("or", FALSE) if predicate.operator == "and" else ("and", TRUE)
            return _join(dual, unit, [_opposite(p) for p in predicate.operands])
        if predicate.operator in _MIRROR:
            return Operation(_MIRROR[predicate.operator], predicate.operands)
    if isinstance(predicate, Constant):
        return Constant(not predicate.value)
    return Operation("not", (predicate,))


def _size(predicate: Expression) -> int:
    if isinstance(predicate, Operation):
        return sum(map(_size, predicate.operands))
    return 1
