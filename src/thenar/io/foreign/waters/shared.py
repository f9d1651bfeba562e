"""Variables that several components update: one automaton for each that does what all of them say together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from math import prod

from thenar.io.cif import terms
from thenar.io.cif.terms import Range, Term
from thenar.io.foreign.waters.expressions import Reader
from thenar.io.foreign.waters.graphs import Part, Step
from thenar.io.foreign.waters.looks import never_both
from thenar.io.foreign.xml import Element, fail
from thenar.model.expressions import Expression

__all__ = ["share"]

MAX_EDGES = 100_000  # of one automaton for a variable

Option = tuple[Term, Term | None]
"""Where a component takes part in an event, and the new value that it gives; None if it leaves the variable alone."""


def share(
    parts: Sequence[Part], is_plant: Callable[[Part], bool], reader: Reader, title: Callable[[str], str]
) -> list[Part]:
    """Take the updates of every variable that several of ``parts`` update out of them; return an automaton for each.

    The automaton has one node.  For an event by which the variable changes it has an edge for each way in which
    the components take part in it together: in which of their nodes they are, where their guards are true, the
    value that they agree on; if they do not agree, there is none.

    It is a plant unless all of them are specifications.  Then it does not hinder what the plants can do: where a
    specification forbids the event, it lets it happen.  That a specification gives a value that is out of range,
    or another than the plants or a specification before it, becomes a guard of the specification.

    Raises ModelError if a component chooses between two values for which nothing tells the edges apart.
    """
    writers: dict[str, list[Part]] = {}
    for part in parts:
        for name in dict.fromkeys(name for step in part.steps for name, _ in step.updates):
            writers.setdefault(name, []).append(part)
    return [_Shared(name, all_, is_plant, reader).part(title) for name, all_ in writers.items() if len(all_) > 1]


class _Shared:
    """One variable and the components that update it."""

    def __init__(self, name: str, writers: Sequence[Part], is_plant: Callable[[Part], bool], reader: Reader) -> None:
        self.name, self.writers, self.reader = name, writers, reader
        self.plants = [p for p in writers if is_plant(p)]
        self.specs = [p for p in writers if not is_plant(p)]

    def part(self, title: Callable[[str], str]) -> Part:
        """Return the automaton that updates the variable; the components do not any more."""
        kind, element = (self.plants or self.specs)[0].kind, self.writers[0].element
        made = Part(title(f"{self.name}.updates"), kind, element, ["*"], [0], [True])
        rivals: dict[tuple[str, str], list[Option]] = {}  # of a specification and an event: what has the say before it
        for event in dict.fromkeys(s.event for p in self.writers for s in p.steps if self._value(s) is not None):
            made.alphabet[event] = None
            for guard, value in self._ways(event, element, rivals):
                made.steps.append(Step(0, event, 0, guard, () if value is None else ((self.name, value),), element))
            if len(made.steps) > MAX_EDGES:
                fail(element, f"variable {self.name!r} is updated in more than {MAX_EDGES:,} ways")
        for part in self.writers:
            part.steps = [self._without(step, rivals.get((part.name, step.event))) for step in part.steps]
        return made

    def _value(self, step: Step) -> Term | None:
        return dict(step.updates).get(self.name)

    def _ways(self, event: str, element: Element, rivals: dict[tuple[str, str], list[Option]]) -> Iterator[Option]:
        """Yield the guards and new values of the automaton's edges for ``event``."""
        by_plants, by_specs = ([self._options(p, event) for p in side] for side in (self.plants, self.specs))
        if not self.plants:
            yield from self._agreeing([options for options in by_specs if options], element)
            return
        said = [option for options in by_plants for option in options]
        for part, options in zip(self.specs, by_specs, strict=True):
            rivals[part.name, event] = list(said)
            said += options
        lenient = [self._with_rest(options) for options in by_specs if options]
        for guard, value in self._agreeing([options for options in by_plants if options], element):
            if value is not None:
                yield guard, value
                continue
            for ways in self._together(lenient, element):
                new = next((v for _, v in ways if v is not None), None)
                where = terms.both(guard, *(w for w, _ in ways))
                if not where.never:
                    yield where, new

    def _agreeing(self, choices: Sequence[Sequence[Option]], element: Element) -> Iterator[Option]:
        """Yield the ways to choose one option each so that the values given are equal."""
        for ways in self._together(choices, element):
            values = list({v.expression: v for _, v in ways if v is not None}.values())
            equal = [self.reader.equal(values[0], other) for other in values[1:]]
            guard = terms.both(*(where for where, _ in ways), *equal)
            if not guard.never:
                yield guard, values[0] if values else None

    def _together(self, choices: Sequence[Sequence[Option]], element: Element) -> Iterator[tuple[Option, ...]]:
        if prod(len(options) for options in choices) > MAX_EDGES:
            fail(element, f"variable {self.name!r} is updated in more than {MAX_EDGES:,} ways together")
        return product(*choices)

    def _options(self, part: Part, event: str) -> list[Option]:
        """Return what ``part`` does by ``event``, if it updates the variable then; no two options are open at once."""
        steps = [s for s in part.steps if s.event == event]
        groups: dict[Expression | None, list[Step]] = {}
        for step in steps:
            value = self._value(step)
            groups.setdefault(None if value is None else value.expression, []).append(step)
        if all(value is None for value in groups):
            return []
        _check_apart(part, self.name, list(groups.values()), self.reader)
        options = []
        for group in groups.values():
            where = terms.either(*(terms.both(part.here(s.source), s.guard) for s in group))
            options.append((where, self._value(group[0])))
        return [option for option in options if not option[0].never]

    def _with_rest(self, options: Sequence[Option]) -> list[Option]:
        """Return the options of a specification, and one for where it forbids the event."""
        able = [
            (where if value is None else terms.both(where, _fits(value, self.name, self.reader)), value)
            for where, value in options
        ]
        return [*able, (terms.negate(terms.either(*(where for where, _ in able))), None)]

    def _without(self, step: Step, rivals: Sequence[Option] | None) -> Step:
        """Return ``step`` without its update of the variable; a specification's with what that asks for as a guard."""
        value = self._value(step)
        if value is None:
            return step
        asked = [] if rivals is None else [_fits(value, self.name, self.reader)]
        for where, other in rivals or ():
            if other is not None:
                asked.append(terms.either(terms.negate(where), self.reader.equal(value, other)))
        rest = tuple((v, x) for v, x in step.updates if v != self.name)
        return Step(step.source, step.event, step.target, terms.both(step.guard, *asked), rest, step.element)


def _fits(value: Term, name: str, reader: Reader) -> Term:
    """Return the term that is true where ``value`` is in the range of the variable."""
    kind = reader.variables[name].type
    if not isinstance(kind, Range) or not isinstance(value.type, Range):
        return terms.truth(True)
    fits = []
    if value.type.low < kind.low:
        fits.append(terms.apply(">=", value, terms.number(kind.low)))
    if value.type.high > kind.high:
        fits.append(terms.apply("<=", value, terms.number(kind.high)))
    return terms.both(*fits)


def _check_apart(part: Part, name: str, groups: Sequence[Sequence[Step]], reader: Reader) -> None:
    """Fail unless the steps of different groups that leave one node have guards that are never true together."""
    leaving: dict[int, list[tuple[int, Step]]] = {}
    for k, group in enumerate(groups):
        for step in group:
            leaving.setdefault(step.source, []).append((k, step))
    for steps in leaving.values():
        if not never_both([(k, step.guard.expression) for k, step in steps], reader.written):
            what = f"variable {name!r} is updated by other components too, and {part.name!r} may choose"
            fail(steps[-1][1].element, f"{what} here what it becomes; add guards of which one is true")
