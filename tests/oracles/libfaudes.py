"""libFAUDES (pip ``faudes``), taught our automata: what it answers, in our terms.

libFAUDES has explicit alphabets, and controllability by event, so little needs mapping.  Its synthesis wants
one alphabet for plant and specification: a specification is self-looped with the events that it does not know
(libFAUDES's inverse projection), and so is the plant with those that only specifications know.  An automaton
without states is a generator without initial state.  State numbers are libFAUDES's own, in no order to rely on.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from operator import or_
from typing import Any

import numpy as np
from tests.oracles.worker import isolate

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.extended import ExtendedAutomaton

Automata = Automaton | Iterable[Automaton]

isolated = isolate("faudes")


@isolated
def sync(*automata: Automaton) -> Automaton:
    """Return libFAUDES's parallel composition."""
    return _read(_parallel(automata), _alphabet(automata))


@isolated
def trim(automaton: Automaton) -> Automaton:
    """Return libFAUDES's trim."""
    generator = _create(automaton)
    library().Trim(generator)
    return _read(generator, automaton.alphabet)


@isolated
def supcon(plants: Automata, specs: Automata = ()) -> Automaton:
    """Return libFAUDES's SupCon."""
    plants, specs = _several(plants), _several(specs)
    alphabet = _alphabet([*plants, *specs])
    controllable = event_set(e.name for e in alphabet if e.controllable)
    result = library().Generator()
    library().SupCon(lifted(plants, alphabet), controllable, lifted(specs, alphabet), result)
    return _read(result, alphabet)


@isolated
def is_controllable(spec: Automaton, plants: Automata) -> bool:
    """Return libFAUDES's IsControllable."""
    plants = _several(plants)
    alphabet = _alphabet([*plants, spec])
    controllable = event_set(e.name for e in alphabet if e.controllable)
    return bool(library().IsControllable(lifted(plants, alphabet), controllable, lifted([spec], alphabet)))


@isolated
def is_nonconflicting(*automata: Automaton) -> bool:
    """Return whether libFAUDES finds the parallel composition nonblocking."""
    return bool(library().IsNonblocking(_parallel(automata)))


@isolated
def project(automaton: Automaton, events: Iterable[str]) -> Automaton:
    """Return libFAUDES's project."""
    seen = automaton.alphabet.restrict(events)
    result = library().Generator()
    library().Project(_create(automaton), event_set(seen.names), result)
    return _read(result, seen)


@isolated
def minimize(automaton: Automaton) -> Automaton:
    """Return libFAUDES's StateMin."""
    result = library().Generator()
    library().StateMin(_create(automaton), result)
    return _read(result, automaton.alphabet)


@isolated
def meet(a: Automaton, b: Automaton) -> Automaton:
    """Return libFAUDES's LanguageIntersection; what only one of them knows never happens."""
    return _of_two("LanguageIntersection", a, b)


@isolated
def union(a: Automaton, b: Automaton) -> Automaton:
    """Return libFAUDES's LanguageUnion."""
    return _of_two("LanguageUnion", a, b)


@isolated
def concatenation(a: Automaton, b: Automaton) -> Automaton:
    """Return libFAUDES's LanguageConcatenate."""
    return _of_two("LanguageConcatenate", a, b)


@isolated
def difference(a: Automaton, b: Automaton) -> Automaton:
    """Return libFAUDES's LanguageDifference."""
    return _of_two("LanguageDifference", a, b)


@isolated
def is_sublanguage(a: Automaton, b: Automaton) -> bool:
    """Return libFAUDES's LanguageInclusion, which compares the marked languages only."""
    return bool(library().LanguageInclusion(_create(a), _create(b)))


@isolated
def kleene_star(automaton: Automaton) -> Automaton:
    """Return libFAUDES's KleeneClosure."""
    result = library().Generator()
    library().KleeneClosure(_create(automaton), result)
    return _read(result, automaton.alphabet)


@isolated
def prefix_closure(automaton: Automaton) -> Automaton:
    """Return libFAUDES's PrefixClosure."""
    generator = _create(automaton)
    library().PrefixClosure(generator)
    return _read(generator, automaton.alphabet)


@isolated
def complement(automaton: Automaton) -> Automaton:
    """Return libFAUDES's LanguageComplement."""
    result = library().Generator()
    library().LanguageComplement(_create(automaton), result)
    return _read(result, automaton.alphabet)


@isolated
def selfloop(automaton: Automaton, events: Alphabet) -> Automaton:
    """Return libFAUDES's SelfLoop; the events are new."""
    generator = _create(automaton)
    library().SelfLoop(generator, event_set(events.names))
    return _read(generator, automaton.alphabet | events)


@isolated
def inverse_project(automaton: Automaton, events: Alphabet) -> Automaton:
    """Return libFAUDES's InvProject."""
    generator, alphabet = _create(automaton), automaton.alphabet | events
    library().InvProject(generator, event_set(alphabet.names))
    return _read(generator, alphabet)


@isolated
def determinise(automaton: ExtendedAutomaton, silent: Iterable[str] = ()) -> Automaton:
    """Return libFAUDES's Deterministic, after its ProjectNonDet if events are ``silent``."""
    generator, names = library().Generator(), automaton.alphabet.names
    for e in names:
        generator.InsEvent(e)
    index = [generator.EventIndex(e) for e in names]
    number = [generator.InsState() for _ in automaton.states]
    for edge in automaton.edges:
        generator.SetTransition(number[edge.source], index[edge.event], number[edge.target])
    for q, initial, marked in zip(number, automaton.initial, automaton.marked, strict=True):
        if initial:
            generator.SetInitState(q)
        if marked:
            generator.SetMarkedState(q)
    seen = [e for e in names if e not in set(silent)]
    if len(seen) < len(names):
        library().ProjectNonDet(generator, event_set(seen))
    result = library().Generator()
    library().Deterministic(generator, result)
    return _read(result, automaton.alphabet.restrict(seen))


@isolated
def answers(questions: Iterable[tuple[Any, ...]]) -> list[Any]:
    """Return the answers to many questions (function, argument, ...) at once: that is quicker."""
    return [globals()[function].__wrapped__(*arguments) for function, *arguments in questions]


def library() -> Any:
    import faudes

    faudes.StateNamesOff()  # names of product states cost more than the product
    return faudes


def _of_two(function: str, a: Automaton, b: Automaton) -> Automaton:
    """Return what libFAUDES makes of two generators, over the union of their alphabets."""
    result = library().Generator()
    getattr(library(), function)(_create(a), _create(b), result)
    return _read(result, _alphabet([a, b]))


def _alphabet(automata: Iterable[Automaton]) -> Alphabet:
    return reduce(or_, (a.alphabet for a in automata), Alphabet())


def event_set(names: Iterable[str]) -> Any:
    events = library().NameSet()
    for name in names:
        events.Insert(name)
    return events


def _create(automaton: Automaton) -> Any:
    generator = library().Generator()
    for e in automaton.alphabet.names:
        generator.InsEvent(e)
    index = [generator.EventIndex(e) for e in automaton.alphabet.names]
    number = [generator.InsState() for _ in range(automaton.n_states)]
    for q in range(automaton.n_states):
        if automaton.marked[q]:
            generator.SetMarkedState(number[q])
        for event, target in automaton.row(q):
            generator.SetTransition(number[q], index[event], number[target])
    if number:
        generator.SetInitState(number[automaton.initial])
    return generator


def _parallel(automata: Iterable[Automaton]) -> Any:
    """Return the parallel composition; of no automata, one marked state over no events."""
    faudes = library()
    product = faudes.Generator()
    product.SetMarkedState(product.InsInitState())
    for automaton in automata:
        wider = faudes.Generator()
        faudes.Parallel(product, _create(automaton), wider)
        product = wider
    return product


def lifted(automata: list[Automaton], alphabet: Alphabet) -> Any:
    product = _parallel(automata)
    library().InvProject(product, event_set(alphabet.names))
    return product


def _read(generator: Any, alphabet: Alphabet) -> Automaton:
    """Return a generator as an automaton, states by their rank in libFAUDES, the initial one first."""
    states, _, transitions, initial, marked = generator.ToLists()
    if not initial:
        return Automaton.empty(alphabet)
    order = [*initial, *(q for q in states if q not in initial)]
    number = {q: k for k, q in enumerate(order)}
    rows: list[list[tuple[int, int]]] = [[] for _ in order]
    for source, event, target in transitions:
        rows[number[source]].append((alphabet.index(event), number[target]))
    moves = [sorted(row) for row in rows]
    return Automaton.from_arrays(
        alphabet,
        np.cumsum([0, *(len(row) for row in moves)]),
        [event for row in moves for event, _ in row],
        [target for row in moves for _, target in row],
        marked=np.isin(order, marked),
    )


def _several(automata: Automata) -> list[Automaton]:
    return [automata] if isinstance(automata, Automaton) else list(automata)
