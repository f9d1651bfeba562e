"""Why, for supervisors that are sets of states: the same questions, answered by a few steps from one state."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

from thenar._native import kernel
from thenar.errors import ModelError
from thenar.explicit.exploration import ticker
from thenar.model.automaton import Automaton
from thenar.model.extended import Condition, ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem
from thenar.model.trace import Trace
from thenar.symbolic.encode import Encoding, EventRelation
from thenar.symbolic.synthesis import SymbolicSupervisor, reach, supremal
from thenar.synthesis.explain import Explanation, Violation, after_words, could_follow, listed

if TYPE_CHECKING:
    from thenar.synthesis.api import SynthesisResult

__all__ = ["explain_disabled", "explain_empty", "explain_removed"]

Spec: TypeAlias = Automaton | ExtendedAutomaton | Condition
SHOWN = 12  # parts of a state that are written; of more, those that are not as they were at first
TRIALS = 256  # syntheses that minimising a conflict may take


def explain_disabled(result: SynthesisResult, event: str, trace: Trace) -> Explanation:
    """Say whether ``event`` is enabled after ``trace``, and why not."""
    supervisor = _symbolic(result)
    at = supervisor.encoding.initial & supervisor.controlled
    for k, name in enumerate(trace):
        following = supervisor.follow(at, name)
        if not following:
            cut = _why(supervisor, at, trace[:k], name)
            verdict = "impossible" if cut.verdict == "impossible" else "prevented"
            return replace(
                cut, verdict=verdict, lead=f"The trace is cut at its event {k + 1} of {len(trace)}. {cut.lead}"
            )
        at = following
    return _why(supervisor, at, trace, event)


def explain_removed(result: SynthesisResult, trace: Trace) -> Explanation:
    """Say why the state that plants and specifications reach by ``trace`` is not one of the supervisor's."""
    supervisor = _symbolic(result)
    forest = supervisor.encoding.forest
    at = supervisor.encoding.initial
    if not at:
        return Explanation("impossible", "No supervisor exists: ", "the plant has no initial state.", trace)
    for k, name in enumerate(trace):
        supervisor.encoding.alphabet.index(name)
        event = supervisor.events.get(name)
        following = forest.image(at, event.relation) & supervisor.reachable if event else forest.nothing
        if not following:
            return _why(supervisor, at, trace[:k], name)
        at = following
    if at & supervisor.controlled:
        return Explanation("enabled", f"{after_words(trace)} ", "the state is one of the supervisor's.", trace)
    if at & supervisor.safe:
        lead = f"{after_words(trace)} nothing is wrong with the state, but the supervisor cuts every way to it."
        return Explanation("prevented", lead, "", trace)
    return _consequence(supervisor, at, trace, f"{after_words(trace)} the state is removed: ")


def explain_empty(result: SynthesisResult) -> Explanation:
    """Say why no supervisor exists: specifications that cannot be met together, and what happens with them."""
    lead = "No supervisor exists: "
    specs, minimal = _minimal_conflict(result.problem)
    supervisor = _solved(_with(result.problem, specs))
    names = tuple(_named(s) for s in specs)
    who = (
        f"{' and '.join(names)} cannot be met{' together' if len(names) > 1 else ''}: "
        if names
        else "even without any specification, "
    )
    start = supervisor.encoding.initial & supervisor.reachable
    if not start:
        return Explanation("impossible", lead, "the plant has no initial state.", conflict=names, minimal=minimal)
    found = _consequence(supervisor, start, Trace(), lead + who)
    return replace(found, conflict=names, minimal=minimal)


# -- one state ---------------------------------------------------------------------------------------------------


def _why(supervisor: SymbolicSupervisor, at: kernel.Set, trace: Trace, name: str) -> Explanation:
    """Say why ``name`` is, or is not, enabled in ``at``."""
    here = after_words(trace)
    enabled = tuple(e.name for e in supervisor.pattern(at).enabled)
    event = supervisor.events.get(name)
    if event is None:
        supervisor.encoding.alphabet.index(name)
        why = "no automaton of the problem has it."
        return Explanation("impossible", f"{here} {name} cannot happen: ", why, trace, name, enabled=enabled)
    row = supervisor.encoding.first(at)
    if not at & event.possible:
        why = f"{' and '.join(_unable(supervisor, event, row)) or 'an invariant of the plant would not hold'}."
        return Explanation("impossible", f"{here} the plant cannot do {name}: ", why, trace, name, enabled=enabled)
    lead = f"{here} the event {name} is disabled: "
    if not at & event.allowed:
        against = tuple(_against(supervisor, event, row))
        return Explanation("forbidden", lead, f"{listed(against)}.", trace, name, violations=against, enabled=enabled)
    if at & supervisor.enabled(event):
        return Explanation("enabled", f"{here} the event {name} is enabled", ".", trace, name, enabled=enabled)
    after = supervisor.encoding.forest.image(at, event.relation) & supervisor.reachable - supervisor.safe
    found = _consequence(supervisor, after, trace, f"{lead}if it happened, ")
    return replace(found, event=name, enabled=enabled)


def _consequence(supervisor: SymbolicSupervisor, at: kernel.Set, trace: Trace, lead: str) -> Explanation:
    """Say what goes wrong, unpreventably, from removed states on; ``lead`` begins the sentence."""
    removal = next(r for r in supervisor.removals if at & r.states)
    string, end = _uncontrollable_path(supervisor, at & removal.states, removal.seeds, removal.states)
    if removal.reason == "illegal":
        violations = tuple(_broken(supervisor, end))
        last = violations[0].event
        if not last:  # an invariant
            follows = f"{could_follow(string)}, and then " if len(string) else ""
            return Explanation(
                "uncontrollable", lead, f"{follows}{listed(violations)}.", trace, None, string, violations
            )
        violations = tuple(v for v in violations if v.event == last)
        string = Trace([*string, last])
        return Explanation(
            "uncontrollable",
            lead,
            f"{could_follow(string)}, and {listed(violations)}.",
            trace,
            None,
            string,
            violations,
        )
    stuck = _stuck(supervisor, end)
    why = f"{could_follow(string)}, and then {stuck}" if len(string) else stuck
    return Explanation("blocking", lead, why, trace, None, string)


def _uncontrollable_path(
    supervisor: SymbolicSupervisor, start: kernel.Set, goal: kernel.Set, inside: kernel.Set
) -> tuple[Trace, tuple[int, ...]]:
    """Return a shortest string of uncontrollable events from ``start`` to ``goal``, and the state where it ends."""
    forest = supervisor.encoding.forest
    free = [e for e in supervisor.encoding.events if not e.controllable]
    layers = [start]
    seen = start
    while not layers[-1] & goal:
        following = forest.any_of([forest.image(layers[-1], e.relation) for e in free], supervisor.encoding.tick)
        layers.append(following & inside - seen)
        seen |= layers[-1]
        assert layers[-1]  # what was removed in this round leads to its seeds
    end = supervisor.encoding.first(layers[-1] & goal)
    string: list[str] = []
    state = supervisor.encoding.only(end)
    for layer in reversed(layers[:-1]):
        event = next(e for e in free if forest.image(state, forest.inverse(e.relation)) & layer)
        string.append(event.name)
        state = supervisor.encoding.only(
            supervisor.encoding.first(forest.image(state, forest.inverse(event.relation)) & layer)
        )
    return Trace(reversed(string)), end


def _unable(supervisor: SymbolicSupervisor, event: EventRelation, row: Sequence[int]) -> Iterable[str]:
    """Yield what keeps the plants from doing ``event`` in the state ``row``."""
    problem = supervisor.encoding.problem
    plants: Sequence[Automaton | ExtendedAutomaton] = problem.plants
    for k, plant in enumerate(plants):
        if _stops(supervisor, plant, row[k], event, row):
            state = supervisor.encoding.parts[k].labels[row[k]]
            yield f"{plant.name or 'an automaton without a name'} is in its state {state!r}"
    if isinstance(problem, ExtendedProblem):
        for condition in problem.plant_conditions:
            if condition.event == event.name and not _holds(supervisor, condition, row):
                yield f"it needs {condition.predicate}"


def _against(supervisor: SymbolicSupervisor, event: EventRelation, row: Sequence[int]) -> Iterable[Violation]:
    """Yield the specifications that forbid ``event`` in the state ``row``."""
    problem = supervisor.encoding.problem
    specs: Sequence[Automaton | ExtendedAutomaton] = problem.specs
    for k, spec in enumerate(specs, supervisor.encoding.n_plants):
        if _stops(supervisor, spec, row[k], event, row):
            yield Violation(spec.name, supervisor.encoding.parts[k].labels[row[k]], event.name, spec.meaning)
    if isinstance(problem, ExtendedProblem):
        for condition in problem.spec_conditions:
            if condition.event == event.name and not _holds(supervisor, condition, row):
                yield Violation(_named(condition), _written(supervisor, row), event.name, condition.meaning)


def _broken(supervisor: SymbolicSupervisor, row: Sequence[int]) -> Iterable[Violation]:
    """Yield the specifications that are broken in the state ``row``; without an event for an invariant."""
    here = supervisor.encoding.only(row)
    for event in supervisor.encoding.events:
        if not event.controllable and here & (event.possible - event.allowed):
            yield from _against(supervisor, event, row)
    problem = supervisor.encoding.problem
    if isinstance(problem, ExtendedProblem):
        for condition in problem.spec_conditions:
            if condition.event is None and not _holds(supervisor, condition, row):
                yield Violation(_named(condition), _written(supervisor, row), "", condition.meaning)


def _stops(
    supervisor: SymbolicSupervisor,
    automaton: Automaton | ExtendedAutomaton,
    state: int,
    event: EventRelation,
    row: Sequence[int],
) -> bool:
    """Return whether ``automaton`` takes part in ``event`` and has no way to do it in ``state``."""
    if event.name not in automaton.alphabet:
        return False
    if isinstance(automaton, Automaton):
        return automaton.step(state, event.name) is None
    index, here = automaton.alphabet.index(event.name), supervisor.encoding.only(row)
    own = [edge for edge in automaton.edges if edge.source == state and edge.event == index]
    return not any(here & supervisor.encoding.happens(edge) for edge in own)


def _holds(supervisor: SymbolicSupervisor, condition: Condition, row: Sequence[int]) -> bool:
    return bool(supervisor.encoding.only(row) & supervisor.encoding.predicate(condition.predicate))


def _stuck(supervisor: SymbolicSupervisor, row: Sequence[int]) -> str:
    """Say that no marked state can be reached from the state ``row``."""
    name, here = _written(supervisor, row), supervisor.encoding.only(row)
    forest = supervisor.encoding.forest
    if not any(forest.image(here, e.relation) & supervisor.encoding.invariant for e in supervisor.encoding.events):
        closed = [v for e in supervisor.encoding.events if here & e.possible for v in _against(supervisor, e, row)]
        end = f"which is not marked (a deadlock{': ' + listed(tuple(closed)) if closed else ''})"
        return f"nothing could happen any more in state {name!r}, {end}."
    return f"no marked state could be reached from state {name!r} without passing states that are removed."


def _written(supervisor: SymbolicSupervisor, row: Sequence[int]) -> str:
    """Write a state: all parts if they are few, else those that are not as at first."""
    parts = supervisor.encoding.parts
    values = [part.labels[v] for part, v in zip(parts, row, strict=True)]
    if len(parts) <= SHOWN:
        return "|".join(values)
    moved = [f"{p.name}={v}" for p, v, k in zip(parts, values, row, strict=True) if not p.initial[k]]
    return ", ".join(moved[:SHOWN]) + (f", ... ({len(moved)} parts)" if len(moved) > SHOWN else "")


# -- no supervisor -----------------------------------------------------------------------------------------------


def _minimal_conflict(problem: Problem | ExtendedProblem) -> tuple[list[Spec], bool]:
    """Return specifications that cannot be met together, and whether none can be left out."""
    core = _specs(problem)
    if len(core) > TRIALS:
        return core, False
    for spec in reversed(core):
        fewer = [s for s in core if s is not spec]
        try:
            trial = _with(problem, fewer)
        except ModelError:  # other conditions speak of its states
            continue
        if _solved(trial).is_empty:
            core = fewer
    return core, True


def _specs(problem: Problem | ExtendedProblem) -> list[Spec]:
    return [*problem.specs, *(problem.spec_conditions if isinstance(problem, ExtendedProblem) else ())]


def _with(problem: Problem | ExtendedProblem, specs: Sequence[Spec]) -> Problem | ExtendedProblem:
    """Return ``problem`` with these specifications only."""
    if isinstance(problem, Problem):
        return Problem(
            problem.plants, [s for s in problem.specs if any(s is x for x in specs)], alphabet=problem.alphabet
        )
    return ExtendedProblem(
        [*problem.plants, *problem.plant_conditions],
        specs,
        variables=problem.variables,
        initial=problem.initial,
        marked=problem.marked,
        alphabet=problem.alphabet,
    )


def _solved(problem: Problem | ExtendedProblem) -> SymbolicSupervisor:
    encoding = Encoding(problem, ticker())
    return supremal(encoding, reach(encoding))


def _named(spec: Spec) -> str:
    return spec.name or (str(spec) if isinstance(spec, Condition) else "a specification without a name")


def _symbolic(result: SynthesisResult) -> SymbolicSupervisor:
    assert result.symbolic is not None
    return result.symbolic
