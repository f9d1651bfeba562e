"""Supremica's project XML: automata without variables, as the project's own files and many benchmarks have them.

What an automaton is for, and what it becomes:

* ``Plant``, ``Undefined`` and no type: a plant, for what has no kind says what can happen
* ``Specification`` and ``Supervisor``: a specification, as Supremica treats supervisors in synthesis and verification
* ``Interface``: a specification too; in hierarchical interface-based control interfaces are part of the flat supervisor
* ``Property``: a question and no part of the system; it is left out, and the problem's description says so

``controllable``, ``observable`` and ``prioritized`` are true unless the file says otherwise.  An event that is not
prioritized in an automaton is not blocked by it: where it has no transition for the event, it stays where it is.
A plant's state with ``forbidden="true"`` must not be entered: a specification ``NAME without forbidden states``, the
plant without them, says so; a specification's is left away; in an :class:`ExtendedProblem` invariants say it.
An automaton without an accepting state marks nothing.
``Layout``, ``Execution`` (signals, actions and controls of a PLC), ``Animation``, costs and times are passed over.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import TypeAlias

import numpy as np

from thenar.errors import InputError, Mistake, ModelError, did_you_mean
from thenar.io.foreign.assemble import assembled
from thenar.io.foreign.compose import Component, composed
from thenar.io.foreign.labels import check_names, quoted, titles, written_name
from thenar.io.foreign.written import Written
from thenar.io.foreign.xml import Element, parse
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event, merge
from thenar.model.expressions import TRUE
from thenar.model.extended import ExtendedAutomaton, ExtendedProblem
from thenar.model.names import Listed
from thenar.model.problem import Problem

__all__ = ["dumps", "loads"]

Part: TypeAlias = Automaton | ExtendedAutomaton

_ROOTS = ("SupremicaProject", "Automata")
_PLANT = ("plant", "undefined", "")
_SPEC = ("specification", "supervisor", "interface")
_QUESTION = ("property",)
_PASSED_OVER = {"Automaton", "Layout", "Execution", "Animation", "Attributes"}
MAX_MISTAKES = 100  # more of them say nothing new
MAX_LOOPS = 2_000_000  # of events that are not prioritized: a short file stands for very many


# -- reading -------------------------------------------------------------------------------------------------


def loads(data: bytes, source: str) -> Problem | ExtendedProblem:
    """Read the automata of a Supremica project; what becomes of them is said above.

    An :class:`ExtendedProblem` comes out only if an automaton is nondeterministic or has several initial states.
    Events are ordered as they are first mentioned; white space and commas in a label become ``_``.
    O(size of the file).  Raises ModelError with line and column of all that is wrong.

    >>> text = '''<SupremicaProject name="lamp">
    ...   <Automaton name="LAMP" type="Plant">
    ...     <Events><Event id="e0" label="on"/><Event id="e1" label="off" controllable="false"/></Events>
    ...     <States><State id="q0" name="dark" initial="true" accepting="true"/><State id="q1" name="lit"/></States>
    ...     <Transitions><Transition source="q0" dest="q1" event="e0"/></Transitions>
    ...   </Automaton>
    ... </SupremicaProject>'''
    >>> loads(text.encode(), "lamp.xml").plants[0].alphabet
    Alphabet(on, off!)
    """
    root = parse(data, source)
    if root.tag not in _ROOTS:
        raise ModelError([Mistake(root.where, f"no Supremica project: it begins with <{root.tag}>")])
    reader = _Reader(root)
    return reader.problem()


@dataclass(slots=True)
class _Drawn:
    """An automaton as the file draws it; states and events by position."""

    element: Element
    name: str
    kind: str
    events: list[Event]
    states: list[str] = field(default_factory=list)
    initial: list[int] = field(default_factory=list)
    marked: list[bool] = field(default_factory=list)
    forbidden: list[int] = field(default_factory=list)
    columns: tuple[list[int], list[int], list[int]] = ([], [], [])
    loose: list[int] = field(default_factory=list)  # events that are not prioritized


class _Reader:
    def __init__(self, root: Element) -> None:
        self.root = root
        self.mistakes: list[Mistake] = []
        self.known: dict[str, tuple[Event, Element]] = {}  # by label, where it was first mentioned
        self.names: dict[str, str] = {}  # of events, and their labels

    def problem(self) -> Problem | ExtendedProblem:
        drawn = [self._automaton(e) for e in self.root.all("Automaton")]
        for child in self.root.children:
            if child.tag not in _PASSED_OVER:
                near = did_you_mean(child.tag, _PASSED_OVER)
                self._wrong(child, f"<{child.tag}> is not known here{near}")
        self._names_twice(drawn)
        self._loosen(drawn)
        if self.mistakes:
            raise ModelError(self.mistakes[:MAX_MISTAKES])
        built = [self._component(d) for d in drawn if d.kind not in _QUESTION]
        said = [self.root.attributes.get("comment", "")]
        said += [f"Not read: property {d.name!r}, a question about the system." for d in drawn if d.kind in _QUESTION]
        alphabet = merge([c.automaton.alphabet for c in built])
        name = self.root.attributes.get("name", "")
        try:
            return composed(built, name=name, description="\n".join(s for s in said if s), alphabet=alphabet)
        except ModelError as error:
            raise ModelError([Mistake(f"{self.root.where}: {m.where}", m.what) for m in error.mistakes]) from None

    def _wrong(self, element: Element, what: str) -> None:
        self.mistakes.append(Mistake(element.where, what))

    def _get(self, element: Element, attribute: str) -> str:
        value = element.attributes.get(attribute)
        if value is None:
            self._wrong(element, f"<{element.tag}> has no attribute {attribute!r}")
        return value or ""

    def _truth(self, element: Element, attribute: str, default: bool) -> bool:
        text = element.attributes.get(attribute)
        if text is None:
            return default
        if text.strip().lower() not in ("true", "false"):
            self._wrong(element, f"{attribute}={text!r}; write 'true' or 'false'")
        return text.strip().lower() == "true"

    def _automaton(self, element: Element) -> _Drawn:
        kind = element.attributes.get("type", "").strip().lower()
        if kind not in _PLANT + _SPEC + _QUESTION:
            known = "Plant, Specification, Supervisor, Interface or Property"
            self._wrong(element, f"an automaton of type {element.get('type')!r}; there are {known}")
        drawn = _Drawn(element, self._get(element, "name"), kind, [])
        events: dict[str, int] = {}
        for e in _inner(element, "Events", "Event"):
            key, event = e.attributes.get("id", e.attributes.get("label", "")), self._event(e)
            if key in events or any(event.name == other.name for other in drawn.events[-1:]):
                self._wrong(e, f"event {key!r} is listed twice")
            if not self._truth(e, "prioritized", True):
                drawn.loose.append(len(drawn.events))
            events[key] = len(drawn.events)
            drawn.events.append(event)
        if len({e.name for e in drawn.events}) < len(drawn.events):
            self._wrong(element, f"automaton {drawn.name!r} lists an event twice")
        states = self._states(element, drawn)
        self._transitions(element, drawn, states, events)
        return drawn

    def _event(self, element: Element) -> Event:
        label = self._get(element, "label")
        known = self.known.get(label)
        controllable = self._truth(element, "controllable", True)
        observable = self._truth(element, "observable", True)
        if known is None:
            event = Event(written_name(label, self.names), controllable, observable)
            self.known[label] = event, element
            return event
        if (known[0].controllable, known[0].observable) != (controllable, observable):
            there = ", ".join(known[0].properties)
            self._wrong(element, f"event {label!r} is {there} in line {known[1].line}; give it one meaning")
        return known[0]

    def _states(self, element: Element, drawn: _Drawn) -> dict[str, int]:
        number: dict[str, int] = {}
        for k, e in enumerate(_inner(element, "States", "State")):
            key = self._get(e, "id")
            if key in number:
                self._wrong(e, f"state {key!r} is listed twice")
            number[key] = k
            drawn.states.append(e.attributes.get("name", key))
            drawn.marked.append(self._truth(e, "accepting", False))
            if self._truth(e, "initial", False):
                drawn.initial.append(k)
            if self._truth(e, "forbidden", False):
                drawn.forbidden.append(k)
        if len(set(drawn.states)) < len(drawn.states):  # told apart by their ids, as Supremica does
            drawn.states = [f"{name} ({key})" for name, key in zip(drawn.states, number, strict=False)]
        if drawn.states and not drawn.initial:
            self._wrong(element, f"automaton {drawn.name!r} has no initial state")
        return number

    def _transitions(self, element: Element, drawn: _Drawn, states: dict[str, int], events: dict[str, int]) -> None:
        s, e, t = drawn.columns = ([], [], [])
        for transition in _inner(element, "Transitions", "Transition"):
            given = transition.attributes
            try:
                source, target, event = states[given["source"]], states[given["dest"]], events[given["event"]]
            except KeyError:
                for what, known in (("source", states), ("dest", states), ("event", events)):
                    value = self._get(transition, what)
                    if value not in known and what in given:
                        noun = "event" if what == "event" else "state"
                        self._wrong(transition, f"unknown {noun} {value!r}{did_you_mean(value, list(known)[:1000])}")
                continue
            s.append(source)
            t.append(target)
            e.append(event)

    def _names_twice(self, drawn: Sequence[_Drawn]) -> None:
        seen: dict[str, Element] = {}
        for d in drawn:
            if d.name in seen:
                self._wrong(d.element, f"automaton {d.name!r} is there twice, first in line {seen[d.name].line}")
            seen.setdefault(d.name, d.element)

    def _loosen(self, drawn: Sequence[_Drawn]) -> None:
        """Let automata stay where they do not take part in an event that is not prioritized in them."""
        in_system = [d for d in drawn if d.kind not in _QUESTION]
        tight = {e.name for d in in_system for k, e in enumerate(d.events) if k not in d.loose}
        loops = 0
        for d in in_system:
            s, e, t = d.columns
            able: dict[int, set[int]] = {k: set() for k in d.loose}
            for q, k in zip(s, e, strict=True):
                if k in able:
                    able[k].add(q)
            for k, there in able.items():
                if d.events[k].name not in tight:
                    what = f"event {d.events[k].name!r} is prioritized in no automaton, which thenar cannot say"
                    self._wrong(d.element, f"{what}; make it prioritized in one of them")
                    continue
                missing = [q for q in range(len(d.states)) if q not in there]
                loops += len(missing)
                if loops > MAX_LOOPS:
                    self._wrong(d.element, f"events that are not prioritized make more than {MAX_LOOPS:,} loops")
                    return
                s += missing
                t += missing
                e += [k] * len(missing)

    def _component(self, d: _Drawn) -> Component:
        columns = (np.array(column, np.int64) for column in d.columns)
        where = d.element.where
        built = assembled(d.name, Alphabet(d.events), d.states, d.initial, d.marked, *columns, where=where)
        return Component(built, d.kind in _PLANT, tuple(d.forbidden))


def _inner(element: Element, group: str, tag: str) -> Iterator[Element]:
    """Yield the elements ``tag`` in the groups called ``group``."""
    return chain.from_iterable(g.all(tag) for g in element.all(group))


# -- writing -------------------------------------------------------------------------------------------------


def dumps(problem: Problem | ExtendedProblem) -> Written:
    """Write ``problem`` as a Supremica project, one ``Automaton`` after the other.

    Kept are names, marking, controllability, observability and the alphabet of each automaton, blocked events
    included.  Not kept are what forces events, meanings, the order of the problem's alphabet if it is not that of
    first mention, and events that no automaton has: ``notes`` say what was left out.  O(transitions), in pieces.

    Raises InputError for variables, guards, conditions and several initial states: a ``.wmod`` file can say them.

    >>> from thenar.library.classics import small_factory
    >>> text = "".join(dumps(small_factory()).chunks)
    >>> loads(text.encode(), "factory.xml")
    Problem 'small_factory(2)': 2 plants, 1 spec, 8 events (4 uncontrollable)
    """
    if isinstance(problem, ExtendedProblem):
        _refuse(problem)
    kinds = ["Plant"] * len(problem.plants) + ["Specification"] * len(problem.specs)
    automata: Sequence[Part] = problem.automata
    called = titles(automata)
    check_names([problem.name, problem.description, *called, *problem.alphabet.names])
    for a in automata:
        check_names(a.states[q] for q in range(len(a.states)))
    return Written(_chunks(problem, list(zip(called, kinds, automata, strict=True))), notes=_notes(problem, called))


def _refuse(problem: ExtendedProblem) -> None:
    """Raise InputError for the first thing that Supremica's XML cannot say."""
    guarded = (a for a in problem.automata if any(e.guard != TRUE or e.updates for e in a.edges))
    several = (a for a in problem.automata if sum(a.initial) > 1)
    what = ""
    if problem.variables:
        what = f"variable {problem.variables[0].name!r}"
    elif problem.plant_conditions or problem.spec_conditions:
        what = f"the condition {str((problem.plant_conditions + problem.spec_conditions)[0])!r}"
    elif a := next(guarded, None):
        what = f"guards or updates of automaton {a.name!r}"
    elif a := next(several, None):
        what = f"the several initial states of automaton {a.name!r}"
    elif TRUE not in (problem.initial,) or TRUE not in (problem.marked,):
        what = "a predicate on initial or marked states"
    if what:
        raise InputError(f"Supremica's XML has no way to say {what}; write a .wmod file")


def _notes(problem: Problem | ExtendedProblem, called: Sequence[str]) -> tuple[str, ...]:
    automata: Sequence[Part] = problem.automata
    notes = []
    mentioned = merge([a.alphabet for a in automata]).names
    if mentioned != problem.alphabet.names:
        unused = [e for e in problem.alphabet.names if e not in mentioned]
        notes.append("Events are in the order of first mention, not in that of the problem's alphabet.")
        notes += [f"Events that no automaton has are not written: {', '.join(unused)}."] if unused else []
    forced = [e.name for e in problem.alphabet if e.forcible]
    notes += [f"That {', '.join(forced)} can be forced is not written."] if forced else []
    if any(e.meaning for e in problem.alphabet) or any(a.meaning for a in automata):
        notes.append("Meanings of events and automata are not written.")
    unnamed = [t for t, a in zip(called, automata, strict=True) if not a.name]
    notes += [f"Automata without a name are called {', '.join(unnamed)}."] if unnamed else []
    return tuple(notes)


_BLOCK = 2048  # transitions in a piece of the file
_ROW = '      <Transition source="%d" dest="%d" event="%d"/>\n'


def _chunks(problem: Problem | ExtendedProblem, parts: Sequence[tuple[str, str, Part]]) -> Iterator[str]:
    comment = f" comment={quoted(problem.description)}" if problem.description else ""
    head = f"<SupremicaProject name={quoted(problem.name)}{comment}"
    yield f'<?xml version="1.0" encoding="UTF-8"?>\n{head} major="0" minor="9">\n'
    for title, kind, a in parts:
        yield f'  <Automaton name={quoted(title)} type="{kind}">\n    <Events>\n'
        for k, event in enumerate(a.alphabet):
            flags = "" if event.controllable else ' controllable="false"'
            flags += "" if event.observable else ' observable="false"'
            yield f'      <Event id="{k}" label={quoted(event.name)}{flags}/>\n'
        yield "    </Events>\n    <States>\n"
        yield from _states(a)
        yield "    </States>\n    <Transitions>\n"
        yield from _transitions(a)
        yield "    </Transitions>\n  </Automaton>\n"
    yield "</SupremicaProject>\n"


def _states(a: Part) -> Iterator[str]:
    n, initial, marked = len(a.states), _initial(a), np.asarray(a.marked, np.bool_).tolist()
    names = a.states.names if isinstance(a.states, Listed) else a.states
    for first in range(0, n, _BLOCK):
        rows = []
        for q in range(first, min(n, first + _BLOCK)):
            flags = (' initial="true"' if q == initial else "") + (' accepting="true"' if marked[q] else "")
            rows.append(f'      <State id="{q}" name={quoted(names[q])}{flags}/>\n')
        yield "".join(rows)


def _initial(a: Part) -> int:
    if isinstance(a, Automaton):
        return a.initial
    return a.initial.index(True) if True in a.initial else -1


def _transitions(a: Part) -> Iterator[str]:
    if isinstance(a, Automaton):
        s, e, t = np.repeat(np.arange(a.n_states), np.diff(a.offsets)), a.events.astype(np.int64), a.targets
    else:
        edges = np.array([(edge.source, edge.event, edge.target) for edge in a.edges], np.int64).reshape(-1, 3)
        s, e, t = edges[:, 0], edges[:, 1], edges[:, 2].astype(np.int32)
    for first in range(0, len(s), _BLOCK):
        block = slice(first, first + _BLOCK)
        rows = zip(s[block].tolist(), t[block].tolist(), e[block].tolist(), strict=True)
        yield "".join([_ROW % row for row in rows])
