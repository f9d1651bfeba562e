"""From a problem to a Waters module."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from xml.sax.saxutils import escape

import numpy as np

from thenar.errors import InputError
from thenar.io.foreign.labels import check_names, quoted, titles
from thenar.io.foreign.waters.looks import asked_by, holding
from thenar.io.foreign.waters.module import ACCEPTING, FORBIDDEN
from thenar.io.foreign.waters.physics import guards_of, holds_at_first
from thenar.io.foreign.waters.say import Sayer, binary, number, simple
from thenar.io.foreign.waters.values import among, in_no_gap
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.expressions import TRUE, At, Expression, Operation, conjunction, evaluate
from thenar.model.extended import Condition, Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem
from thenar.model.variables import Variable

__all__ = ["write"]

Part = Automaton | ExtendedAutomaton
_BLOCK = 2048  # transitions in a piece of the file


def write(problem: Problem | ExtendedProblem) -> Written:
    """Return the module that says what ``problem`` does; see :func:`thenar.io.foreign.waters.dumps`."""
    automata: Sequence[Part] = problem.automata
    called = titles(automata)
    plan = _Plan(list(called))
    if isinstance(problem, ExtendedProblem):
        _check_names(problem)
        plan.names += [_name(v.name) for v in problem.variables]
        sayer = Sayer({v.name: v.values for v in problem.variables}, {v.name: _name(v.name) for v in problem.variables})
        plan.narrow(problem)
        plan.components += [_variable(v, plan.values) for v in problem.variables]
        kinds = ["PLANT"] * len(problem.plants) + ["SPEC"] * len(problem.specs)
        for name, kind, a in zip(called, kinds, problem.automata, strict=True):
            plan.components.append("".join(_component(name, kind, a, plan, sayer)))
        plan.conditions(problem, sayer)
        if sayer.asked_where:
            plan.notes.append(
                "Guards compare automata with their states; Supremica needs its option for automaton variables."
            )
        bits = [v.name for v in problem.variables if isinstance(v.values[0], bool)]
        plan.notes += [f"The truths {', '.join(bits)} are written as 0 and 1."] if bits else []
    unnamed = [t for t, a in zip(called, automata, strict=True) if not a.name]
    plan.notes += [f"Automata without a name are called {', '.join(unnamed)}."] if unnamed else []
    plan.notes += _left_out(problem)
    check_names([problem.name, problem.description, *problem.alphabet.names, *called])
    for part in automata:
        check_names(part.states[q] for q in range(len(part.states)))
    return Written(_chunks(problem, called, plan), notes=tuple(plan.notes))


def _left_out(problem: Problem | ExtendedProblem) -> list[str]:
    forced = [e.name for e in problem.alphabet if e.forcible]
    notes = [f"That {', '.join(forced)} can be forced is not written."] if forced else []
    conditions = problem.plant_conditions + problem.spec_conditions if isinstance(problem, ExtendedProblem) else ()
    automata: Sequence[Part] = problem.automata
    if any(x.meaning for x in (*problem.alphabet, *automata, *conditions)):
        notes.append("Meanings of events, automata and conditions are not written.")
    return notes


def _name(variable: str) -> str:
    """Return what a module calls a variable: its names have colons where ours have dots."""
    return variable.replace(".", ":")


def _check_names(problem: ExtendedProblem) -> None:
    names = {a.name for a in problem.automata if a.name}
    for v in problem.variables:
        if _name(v.name) in names:
            raise InputError(f"variable {v.name!r} and an automaton would both be called {_name(v.name)!r}; rename one")
        names.add(_name(v.name))
    for v in problem.variables:
        for value in v.values:
            if isinstance(value, str) and (value in names or not value):
                what = "is no name" if not value else "is called like an automaton or a variable"
                raise InputError(f"variable {v.name!r}: its value {value!r} {what}; rename it")


# -- what a module says in another way -----------------------------------------------------------------------


@dataclass(slots=True)
class _Plan:
    """What is to be written besides the parts of the problem themselves."""

    names: list[str]  # of components, so far
    components: list[str] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    forbidden: set[At] = field(default_factory=set)
    values: dict[tuple[str, str], list[Expression]] = field(
        default_factory=dict
    )  # of "initial" or "marked", a variable
    states: dict[tuple[str, str], list[Expression]] = field(default_factory=dict)  # the same of an automaton

    def unique(self, wanted: str) -> str:
        """Return a name for a component that no other has."""
        while wanted in self.names:
            wanted += "_"
        self.names.append(wanted)
        return wanted

    def narrow(self, problem: ExtendedProblem) -> None:
        """Give the predicates on initial and marked states to the variables and automata that they speak of."""
        physics = (p for c in problem.plant_conditions if c.event is None for p in _conjuncts(c.predicate))
        first = conjunction([problem.initial, *(p for p in physics if not holds_at_first(problem, p))])
        for what, predicate in (("initial", first), ("marked", problem.marked)):
            for part in _conjuncts(predicate):
                asked = asked_by(part)
                owners = {leaf.automaton if isinstance(leaf, At) else leaf.name for leaf in asked}
                if len(owners) > 1:
                    way = f"a .wmod file can only say which values and states are {what} one by one"
                    raise InputError(f"the predicate {str(part)!r} on {what} states; {way}")
                for leaf in asked[:1]:
                    at = isinstance(leaf, At)
                    (self.states if at else self.values).setdefault((what, *owners), []).append(part)  # type: ignore[arg-type]
                if not asked and part != TRUE:
                    raise InputError(f"no state is {what}; a .wmod file cannot say that of all states at once")
        for condition in problem.spec_conditions:
            avoided = _avoided(condition)
            if avoided is not None:
                self.forbidden.add(avoided)

    def conditions(self, problem: ExtendedProblem, sayer: Sayer) -> None:
        """Write conditions as automata."""
        physics = conjunction(c.predicate for c in problem.plant_conditions if c.event is None)
        if physics != TRUE:
            edges = [_edge("*", "*", [e], [sayer.truth(guard)], []) for e, guard in guards_of(problem, physics)]
            self.components.append(_one_node(self.unique("physics"), "PLANT", edges, []))
            self.notes.append("Invariants of the plants are written as guards of the events that could violate them.")
        rules = [c for c in problem.spec_conditions if c.event is None and _avoided(c) is None]
        needs = [("PLANT", c) for c in problem.plant_conditions if c.event is not None]
        needs += [("SPEC", c) for c in problem.spec_conditions if c.event is not None]
        for kind, c in needs:
            name = self.unique(c.name or f"{c.event} needs")
            edge = _edge("*", "*", [str(c.event)], [sayer.truth(c.predicate)], [])
            self.components.append(_one_node(name, kind, [edge], []))
        if needs:
            self.notes.append("What events need is written as automata of one node with guards.")
        if rules:
            event = "violation"
            while event in problem.alphabet:
                event += "_"
            self.events.append(Event(event, controllable=False))
            edges = [_edge("*", "*", [event], [sayer.truth(Operation("not", (c.predicate,)))], []) for c in rules]
            self.components.append(_one_node(self.unique("invariants"), "PLANT", edges, []))
            self.components.append(_one_node(self.unique("no violation"), "SPEC", [], [event]))
            what = f"Invariants are written as an uncontrollable event {event!r}, possible where one is violated"
            self.notes.append(f"{what}, and a specification that forbids it.")

    def narrowed(self, what: str, a: Part, chosen: Sequence[bool]) -> list[bool]:
        """Return which states of ``a`` are ``what``, of those ``chosen``."""
        predicates = self.states.get((what, a.name), [])
        if not predicates:
            return list(chosen)
        predicate = conjunction(predicates)

        def true(q: int) -> bool:
            here = a.states[q]
            return bool(evaluate(predicate, lambda leaf: leaf.state == here if isinstance(leaf, At) else leaf.value))  # type: ignore[union-attr]

        return [keep and true(q) for q, keep in enumerate(chosen)]


def _avoided(condition: Condition) -> At | None:
    """Return the state that an invariant forbids, if it says just that."""
    p = condition.predicate
    if condition.event is None and isinstance(p, Operation) and p.operator == "not" and isinstance(p.operands[0], At):
        return p.operands[0]
    return None


def _conjuncts(predicate: Expression) -> Iterator[Expression]:
    if isinstance(predicate, Operation) and predicate.operator == "and":
        for part in predicate.operands:
            yield from _conjuncts(part)
    else:
        yield predicate


# -- variables -----------------------------------------------------------------------------------------------


def _variable(v: Variable, predicates: Mapping[tuple[str, str], list[Expression]]) -> str:
    name = simple(_name(v.name))
    if isinstance(v.values[0], str):
        domain = f"<EnumSetExpression>{''.join(simple(str(x)) for x in v.values)}</EnumSetExpression>"
    else:
        numbers = [int(x) for x in v.values]
        domain = binary("..", number(min(numbers)), number(max(numbers)))
    starting = holding(v.initial, conjunction(predicates.get(("initial", v.name), [])))
    if not starting:
        raise InputError(f"variable {v.name!r} has no value that the predicate on initial states leaves it")
    first = among(name, starting, v.values)
    last = among(name, holding(v.marked, conjunction(predicates.get(("marked", v.name), []))), v.values)
    initial = binary("&", *first) if first else number(1)
    marking = f"<VariableMarking>{simple(ACCEPTING)}{binary('&', *last)}</VariableMarking>" if last else ""
    return (
        f"    <VariableComponent Name={quoted(_name(v.name))}>\n      <VariableRange>{domain}</VariableRange>\n"
        f"      <VariableInitial>{initial}</VariableInitial>\n{f'      {marking}' + chr(10) if marking else ''}"
        f"    </VariableComponent>\n"
    )


# -- automata ------------------------------------------------------------------------------------------------


def _component(name: str, kind: str, a: Part, plan: _Plan, sayer: Sayer | None) -> Iterator[str]:
    """Yield the pieces of an automaton's component."""
    n = len(a.states)
    start = a.initial if isinstance(a, ExtendedAutomaton) else [q == a.initial for q in range(n)]
    initial, marked = plan.narrowed("initial", a, start), plan.narrowed("marked", a, np.asarray(a.marked).tolist())
    if n and not any(initial):
        raise InputError(f"automaton {name!r} has no state that the predicate on initial states leaves it")
    used = {e.event for e in a.edges} if isinstance(a, ExtendedAutomaton) else set(np.unique(a.events).tolist())
    blocked = [event.name for k, event in enumerate(a.alphabet) if k not in used]
    blocked += [] if any(marked) or not n else [ACCEPTING]
    yield f'    <SimpleComponent Kind="{kind}" Name={quoted(name)}>\n      <Graph{_deterministic(a)}>\n'
    yield f"{_blocked(blocked)}        <NodeList>\n"
    for first in range(0, n, _BLOCK):
        block = range(first, min(n, first + _BLOCK))
        yield "".join([_node(a, q, initial[q], marked[q], plan.forbidden) for q in block])
    yield "        </NodeList>\n        <EdgeList>\n"
    if isinstance(a, ExtendedAutomaton):
        assert sayer is not None
        yield from _edges(a, sayer)
    else:
        yield from _plain_edges(a)
    yield "        </EdgeList>\n      </Graph>\n    </SimpleComponent>\n"


def _deterministic(a: Part) -> str:
    if isinstance(a, Automaton):
        return ""
    pairs = [(e.source, e.event) for e in a.edges]
    return "" if len(set(pairs)) == len(pairs) and sum(a.initial) == 1 else ' Deterministic="false"'


def _blocked(events: Sequence[str]) -> str:
    return f"        <LabelBlock>{''.join(map(simple, events))}</LabelBlock>\n" if events else ""


def _node(a: Part, q: int, initial: bool, marked: bool, forbidden: set[At]) -> str:
    propositions = [ACCEPTING] if marked else []
    propositions += [FORBIDDEN] if forbidden and At(a.name, a.states[q]) in forbidden else []
    head = f"          <SimpleNode{' Initial=' + quoted('true') if initial else ''} Name={quoted(a.states[q])}"
    if not propositions:
        return head + "/>\n"
    return f"{head}><EventList>{''.join(map(simple, propositions))}</EventList></SimpleNode>\n"


def _plain_edges(a: Automaton) -> Iterator[str]:
    """Yield the edges of an automaton, those between two states as one."""
    names = [quoted(a.states[q]) for q in range(a.n_states)]
    labels = [simple(e) for e in a.alphabet.names]
    sources = np.repeat(np.arange(a.n_states), np.diff(a.offsets))
    order = np.lexsort((a.events, a.targets, sources))
    rows = zip(sources[order].tolist(), a.targets[order].tolist(), a.events[order].tolist(), strict=True)
    piece: list[str] = []
    for (s, t), group in groupby(rows, key=lambda row: row[:2]):
        block = "".join([labels[e] for _, _, e in group])
        piece.append(f"          <Edge Source={names[s]} Target={names[t]}><LabelBlock>{block}</LabelBlock></Edge>\n")
        if len(piece) >= _BLOCK:
            yield "".join(piece)
            piece.clear()
    yield "".join(piece)


def _edges(a: ExtendedAutomaton, sayer: Sayer) -> Iterator[str]:
    """Yield the edges of an extended automaton, one for each case of its updates.

    Where one edge of an event updates a variable, the others say that it keeps its value: older versions of
    Supremica let it take any.
    """
    changed: dict[int, dict[str, None]] = {}
    for e in a.edges:
        changed.setdefault(e.event, {}).update(dict.fromkeys(v for v, _ in e.updates))
    for k, e in enumerate(a.edges):
        try:
            yield from _cases(a, e, list(changed[e.event]), sayer)
        except InputError as error:
            raise InputError(f"automaton {a.name!r}, {a.place(k)}: {error}") from None


def _cases(a: ExtendedAutomaton, e: Edge, changed: Sequence[str], sayer: Sayer) -> Iterator[str]:
    updates = dict(e.updates)
    apart: list[tuple[tuple[Expression, ...], tuple[Expression, ...]]] = [((), ())]
    for x in updates.values():
        apart = [((*c, *more), (*values, y)) for c, values in apart for more, y in sayer.cases(x)]
        if len(apart) > 256:
            raise InputError("its updates have more than 256 cases; a .wmod file has no 'if' in expressions")
    for conditions, values in apart:
        guards = [] if e.guard == TRUE else [sayer.truth(e.guard)]
        guards += map(sayer.truth, conditions)
        new = dict(zip(updates, values, strict=True))
        for v, x in new.items():
            guards += in_no_gap(sayer.value(x), sayer.domains[v])
        actions = [
            binary("=", simple(sayer.names[v]), sayer.value(new[v]) if v in new else simple(sayer.names[v]))
            for v in changed
        ]
        yield _edge(a.states[e.source], a.states[e.target], [a.alphabet[e.event].name], guards, actions)


def _edge(source: str, target: str, events: Sequence[str], guards: Sequence[str], actions: Sequence[str]) -> str:
    said = f"<Guards>{binary('&', *guards)}</Guards>" if guards else ""
    said += f"<Actions>{''.join(actions)}</Actions>" if actions else ""
    block = f"<GuardActionBlock>{said}</GuardActionBlock>" if said else ""
    labels = f"<LabelBlock>{''.join(map(simple, events))}</LabelBlock>"
    return f"          <Edge Source={quoted(source)} Target={quoted(target)}>{labels}{block}</Edge>\n"


def _one_node(name: str, kind: str, edges: Sequence[str], blocked: Sequence[str]) -> str:
    """Return the component of an automaton that has one node."""
    head = f'    <SimpleComponent Kind="{kind}" Name={quoted(name)}>\n      <Graph Deterministic="false">\n'
    node = f'          <SimpleNode Initial="true" Name="*"><EventList>{simple(ACCEPTING)}</EventList></SimpleNode>\n'
    nodes = f"        <NodeList>\n{node}        </NodeList>\n"
    drawn = f"        <EdgeList>\n{''.join(edges)}        </EdgeList>\n" if edges else ""
    return f"{head}{_blocked(blocked)}{nodes}{drawn}      </Graph>\n    </SimpleComponent>\n"


# -- the file ------------------------------------------------------------------------------------------------


def _chunks(problem: Problem | ExtendedProblem, called: Sequence[str], plan: _Plan) -> Iterator[str]:
    spaces = 'xmlns="http://waters.sourceforge.net/xsd/module" xmlns:ns2="http://waters.sourceforge.net/xsd/base"'
    yield f'<?xml version="1.0" encoding="UTF-8"?>\n<Module {spaces} Name={quoted(problem.name)}>\n'
    if problem.description:
        yield f"  <ns2:Comment>{escape(problem.description, {chr(13): '&#13;'})}</ns2:Comment>\n"
    yield "  <EventDeclList>\n"
    for event in (*problem.alphabet, *plan.events):
        kind = "CONTROLLABLE" if event.controllable else "UNCONTROLLABLE"
        seen = "" if event.observable else ' Observable="false"'
        yield f'    <EventDecl Kind="{kind}" Name={quoted(event.name)}{seen}/>\n'
    for proposition in (ACCEPTING, FORBIDDEN) if plan.forbidden else (ACCEPTING,):
        yield f'    <EventDecl Kind="PROPOSITION" Name="{proposition}"/>\n'
    yield "  </EventDeclList>\n  <ComponentList>\n"
    yield from plan.components
    if isinstance(problem, Problem):
        kinds = ["PLANT"] * len(problem.plants) + ["SPEC"] * len(problem.specs)
        for name, kind, a in zip(called, kinds, problem.automata, strict=True):
            yield from _component(name, kind, a, plan, None)
    yield "  </ComponentList>\n</Module>\n"
