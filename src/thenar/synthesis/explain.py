"""Why: the reasons behind a supervisor, as words and as data.

Everything is read off the evidence of the synthesis: the explored product, in which each removed state
carries the reason and the rank of its removal (0: a specification is broken here; otherwise larger than
that of the states it follows from).  A question costs one search in that product, never a synthesis;
only :func:`explain_empty` synthesises again, with fewer specifications and within the states that the
synthesis itself explored.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from thenar.errors import InputError, LimitReached
from thenar.explicit.control import allows, forbidden
from thenar.explicit.exploration import Exploration, ticker
from thenar.explicit.reach import shortest_trace
from thenar.model.automaton import Automaton
from thenar.model.display import Displayable
from thenar.model.limits import Limits
from thenar.model.problem import Problem
from thenar.model.trace import Trace
from thenar.synthesis.api import SynthesisResult, synthesize

__all__ = ["Explanation", "Violation", "explain", "explain_disabled", "explain_empty", "explain_removed"]

SURVIVES, ILLEGAL, UNCONTROLLABLE, BLOCKING = range(4)  # as the kernel numbers its reasons
NOTHING = Trace()
MAX_SEARCHED = 1000  # states that a closed way is looked for in; beyond that it would explain nothing to a person
MAX_LISTED = 8  # violations in one sentence
MIN_BUDGET = 100_000  # product states that minimising a conflict may explore however small the problem: milliseconds


@dataclass(frozen=True, slots=True)
class Violation:
    """Specification ``spec``, in its state ``state``, forbids ``event``; ``meaning`` is what it says in words.

    An invariant that does not hold in ``state`` forbids no event: ``event`` is empty.

    >>> print(Violation("BUFFER", "full", "finish_1", "The buffer holds one part."))
    BUFFER ("The buffer holds one part.") forbids finish_1 in its state 'full'
    """

    spec: str
    state: str
    event: str
    meaning: str = ""

    def __str__(self) -> str:
        says = f' ("{self.meaning}")' if self.meaning else ""
        if not self.event:
            return f"the requirement {self.spec!r}{says} is broken in state {self.state!r}"
        return f"{self.spec or 'a specification without a name'}{says} forbids {self.event} in its state {self.state!r}"


@dataclass(frozen=True, slots=True)
class Explanation(Displayable):
    """An answer to *why*.  ``str`` gives the words (``lead``, then ``why``); the fields are the data.

    * ``verdict``: ``"enabled"``; ``"impossible"`` (the plant cannot do it); ``"forbidden"`` (a specification
      says no); ``"uncontrollable"`` (uncontrollable events could then break a specification);
      ``"blocking"`` (no marked state could then be reached); ``"prevented"`` (the supervisor has already cut
      the trace asked about)
    * ``after``: the trace to where the question is asked; ``event``: the event asked about
    * ``continuation``: the shortest uncontrollable string from there to what goes wrong
    * ``violations``: the specifications broken at its end
    * ``enabled``: the events that the supervisor enables there
    * ``conflict``: for an impossible task, specifications that cannot be met together; ``minimal`` says
      that leaving out any one of them gives a supervisor, False that this was not found out for all

    >>> print(Explanation("enabled", "In the initial state the event go is enabled", "."))
    In the initial state the event go is enabled.
    """

    verdict: str
    lead: str
    why: str
    after: Trace = NOTHING
    event: str | None = None
    continuation: Trace = NOTHING
    violations: tuple[Violation, ...] = ()
    enabled: tuple[str, ...] = ()
    conflict: tuple[str, ...] = ()
    minimal: bool | None = None

    def __str__(self) -> str:
        instead = f" Enabled there: {', '.join(self.enabled)}." if self.enabled and self.verdict != "enabled" else ""
        return f"{self.lead}{self.why}{instead}"

    def to_dict(self) -> dict[str, object]:
        """Return the explanation as plain lists, strings and numbers."""
        plain = {k: list(v) if isinstance(v, (Trace, tuple)) else v for k, v in asdict(self).items()}
        return {"text": str(self), **plain}


def explain(
    result: SynthesisResult, *, after: Iterable[str] | str | None = None, state: int | None = None
) -> list[Explanation]:
    """Explain everything that the supervisor disables after a trace, or in a state; or why it does not get there.

    One explanation for each disabled event; a single one if nothing is disabled, if the trace is cut before its
    end, or if no supervisor exists.  Arguments, cost and errors as for :func:`explain_disabled`.

    >>> from thenar.library import glr
    >>> [str(why.event) for why in explain(synthesize(glr.problem()))]
    ['approach_2']
    """
    if not result:
        return [explain_empty(result)]
    trace = _trace(result, after, state)
    for event in trace:
        result.problem.alphabet.index(event)
    pattern = (result.symbolic or result.supervisor).after(trace)
    if pattern is None:  # asking about the last event of a trace that is cut says where and why
        return [explain_disabled(result, trace[-1], after=trace[:-1])]
    if pattern.disabled:
        return [explain_disabled(result, e.name, after=trace) for e in pattern.disabled]
    enabled = tuple(e.name for e in pattern.enabled)
    lead = f"{after_words(trace)} nothing is disabled; enabled: "
    return [Explanation("enabled", lead, f"{', '.join(enabled) or 'nothing'}.", trace, enabled=enabled)]


def explain_disabled(
    result: SynthesisResult, event: str, *, after: Iterable[str] | str | None = None, state: int | None = None
) -> Explanation:
    """Say whether ``event`` is enabled after a trace, or in a supervisor state, and why not.

    Give ``after`` (a trace; default: the empty one) or ``state`` (a number; a shortest trace leads there).
    One search in the explored product.  Raises UnknownName for an event that does not exist.

    >>> from thenar.library.classics import small_factory
    >>> print(explain_disabled(synthesize(small_factory()), "start_2"))
    In the initial state the event start_2 is disabled: BUFFER1 (...) forbids start_2 in its state 'empty'. ...
    """
    result.problem.alphabet.index(event)
    if not result:
        return explain_empty(result)
    trace = _trace(result, after, state)
    if result.symbolic is not None:
        from thenar.synthesis import explain_symbolic

        return explain_symbolic.explain_disabled(result, event, trace)
    evidence = _evidence(result)
    x, prevented = _walk(result, evidence, trace)
    if prevented is not None:
        return prevented
    return _why(evidence, x, trace, event)


def explain_removed(result: SynthesisResult, after: Iterable[str] | str) -> Explanation:
    """Say why the state that plants and specifications reach by ``after`` is not one of the supervisor's.

    The trace may leave the supervised behaviour, but not the specifications: beyond their end there is no state.
    The verdict is ``"enabled"`` if the state is one of the supervisor's after all, and ``"prevented"`` if nothing
    is wrong with it but the supervisor cuts every way to it.  One search in the explored product.

    >>> from thenar.library.classics import cat_and_mouse
    >>> explain_removed(synthesize(cat_and_mouse()), "").verdict
    'enabled'
    """
    trace = _trace(result, after, None)
    if result.symbolic is not None:
        from thenar.synthesis import explain_symbolic

        return explain_symbolic.explain_removed(result, trace)
    if result.evidence is None:
        return explain_empty(result)
    evidence = result.evidence
    x = 0
    for k, event in enumerate(trace):
        result.problem.alphabet.index(event)
        target = dict(_row(evidence, x)).get(event)
        if target is None:
            if evidence.native.reason[x] == ILLEGAL:
                return _consequence(evidence, x, trace[:k], f"{after_words(trace[:k])} the state is removed: ")
            return _why(evidence, x, trace[:k], event)
        x = target
    if evidence.native.reason[x] != SURVIVES:
        return _consequence(evidence, x, trace, f"{after_words(trace)} the state is removed: ")
    if result.extract is not None and x in result.extract.origin:
        return Explanation("enabled", f"{after_words(trace)} ", "the state is one of the supervisor's.", trace)
    cut = _walk(result, evidence, trace)[1]
    assert cut is not None  # a state that survives is the supervisor's, or every way to it is cut
    lead = f"{after_words(trace)} nothing is wrong with the state, but the supervisor cuts every way to it. "
    return replace(cut, verdict="prevented", lead=lead + cut.lead)


def explain_empty(result: SynthesisResult) -> Explanation:
    """Say why no supervisor exists: specifications that cannot be met together, and the trace that shows it.

    Specifications that the proof in the evidence does not need are left out at once; then one after the other
    is tried.  These syntheses together may explore as many states as the one that failed (at least 100 000);
    when that does not suffice ``minimal`` is False.

    Raises InputError if a supervisor does exist.

    >>> plant = Automaton.from_transitions(["0 -go-> 1"], initial="0", marked=["1"], name="HAND")
    >>> stay = Automaton.from_transitions([], initial="0", marked=["0"], alphabet=["go"], name="STAY")
    >>> explain_empty(synthesize(Problem(plant, stay))).conflict
    ('STAY',)
    """
    if result:
        raise InputError("a supervisor exists; ask explain_disabled about its decisions")
    if result.symbolic is not None:
        from thenar.synthesis import explain_symbolic

        return explain_symbolic.explain_empty(result)
    problem = result.plain
    lead = "No supervisor exists: "
    empty = tuple(a.name for a in problem.automata if a.is_empty)
    if empty:
        return Explanation("impossible", lead, f"{' and '.join(empty)} has no states.", conflict=empty)
    core, minimal = _minimal_conflict(result)
    names = tuple(s.name or "a specification without a name" for s in core.problem.specs)
    if not names:
        who = "even without any specification"
    elif len(names) == 1:
        who = f"{names[0]} alone makes it impossible"
    else:
        who = f"{', '.join(names[:-1])} and {names[-1]} cannot be met together"
    if names and minimal:
        who += "; without it there is one" if len(names) == 1 else "; without any one of them there is one"
    elif names:
        who += " (whether all of them are needed was not found out)"
    why = _consequence(_evidence(core), 0, NOTHING, f"{lead}{who}. Already at the start ")
    return replace(why, conflict=names, minimal=minimal)


# -- the parts of an answer ------------------------------------------------------------------------------------


def _why(evidence: Exploration, x: int, trace: Trace, event: str) -> Explanation:
    """Explain ``event`` at product state ``x``, which survives or at least was expanded."""
    here = after_words(trace)
    row, reason = dict(_row(evidence, x)), evidence.native.reason
    enabled = tuple(e for e, t in row.items() if reason[x] == reason[t] == SURVIVES)
    plants, specs = evidence.local(x)
    unable = [(p, q) for p, q in plants if not allows(p, q, event)]
    if not any(event in p.alphabet for p in evidence.parts):
        lead, why = f"{here} {event} cannot happen: ", "no automaton of the problem has it."
        return Explanation("impossible", lead, why, trace, event, enabled=enabled)
    if unable:
        who = " and ".join(f"{p.name} is in its state {p.states[q]!r}" for p, q in unable)
        return Explanation(
            "impossible", f"{here} the plant cannot do {event}: ", f"{who}.", trace, event, enabled=enabled
        )
    against = _violations((event, s, q) for s, q in specs if not allows(s, q, event))
    if against:
        lead, why = f"{here} the event {event} is disabled: ", f"{listed(against)}."
        return Explanation("forbidden", lead, why, trace, event, violations=against, enabled=enabled)
    if reason[row[event]] == SURVIVES:
        return Explanation("enabled", f"{here} the event {event} is enabled", ".", trace, event, enabled=enabled)
    lead = f"{here} the event {event} is disabled: if it happened, "
    return replace(_consequence(evidence, row[event], trace, lead), event=event, enabled=enabled)


def _consequence(evidence: Exploration, x: int, trace: Trace, lead: str) -> Explanation:
    """Say what goes wrong, unpreventably, from the removed product state ``x`` on; ``lead`` begins the sentence."""
    reason, rank = evidence.native.reason, evidence.native.rank
    path = [] if reason[x] != UNCONTROLLABLE else evidence.shortest_uncontrollable(x, reason == ILLEGAL)
    if path is None:
        path = evidence.shortest_uncontrollable(x, (reason == BLOCKING) & (rank < rank[x]))
    assert path is not None  # a state removed for an uncontrollable event leads to one removed for another reason
    end = path[-1][1] if path else x
    string = Trace(e for e, _ in path)
    if reason[end] == ILLEGAL:
        broken = forbidden(evidence, end, uncontrollable_only=True)
        last = broken[0][0]
        violations = _violations(v for v in broken if v[0] == last)
        string = Trace([*string, last])
        why = f"{could_follow(string)}, and {listed(violations)}."
        return Explanation("uncontrollable", lead, why, trace, None, string, violations)
    why = f"{could_follow(string)}, and then {_stuck(evidence, end)}" if len(string) else _stuck(evidence, end)
    return Explanation("blocking", lead, why, trace, None, string)


def _stuck(evidence: Exploration, x: int) -> str:
    """Say why no marked state can be reached from ``x``, a state removed as blocking."""
    reason, rank = evidence.native.reason, evidence.native.rank
    name = evidence.names(np.array([x]))[0]
    if not evidence.native.row(x):
        closed = _forbidden_at(evidence, x)
        end = f"which is not marked (a deadlock{': ' + closed if closed else ''})"
        return f"nothing could happen any more in state {name!r}, {end}."
    unmarked = [p.name or "an automaton without a name" for p in evidence.parts if not p.marked.any()]
    if unmarked:
        marks = "marks no state" if len(unmarked) == 1 else "mark no state"
        return f"no marked state could be reached from state {name!r}: {' and '.join(unmarked)} {marks} at all."
    # States that block at the same rank are closed but for what was removed before them.
    way_out = evidence.shortest((rank >= 0) & (rank < rank[x]), inside=rank == rank[x], start=x)
    if way_out is None:
        closed = _nearest_closed_way(evidence, x)
        return (
            f"no marked state could be reached from state {name!r}{': ' + closed if closed else ', whatever happened'}."
        )
    cause = {
        ILLEGAL: "an uncontrollable event breaks a specification",
        UNCONTROLLABLE: "uncontrollable events lead to what was removed",
        BLOCKING: "no marked state can be reached either",
    }[int(reason[way_out[-1][1]])]
    return (
        f"no marked state could be reached from state {name!r}: every way to one passes a state that is itself "
        f"removed, the nearest after {Trace(e for e, _ in way_out)}, where {cause}."
    )


def _forbidden_at(evidence: Exploration, x: int) -> str:
    """Name the specifications that forbid in state ``x`` what the plants could do there; empty if none does."""
    return listed(_violations(forbidden(evidence, x, uncontrollable_only=False)))


def _nearest_closed_way(evidence: Exploration, x: int) -> str:
    """Name what the specifications forbid nearest to ``x``, a state that nothing leads out of to a marked one."""
    queue: list[tuple[int, Trace]] = [(x, NOTHING)]
    seen = {x}
    for state, trace in queue:
        if closed := _forbidden_at(evidence, state):
            return f"after {trace} {closed}" if len(trace) else closed
        for event, target in _row(evidence, state):
            if target not in seen and len(seen) < MAX_SEARCHED:
                seen.add(target)
                queue.append((target, Trace([*trace, event])))
    return ""


def _walk(result: SynthesisResult, evidence: Exploration, trace: Trace) -> tuple[int, Explanation | None]:
    """Follow ``trace`` under supervision; return where it ends, or why the supervisor (or the plant) cuts it."""
    if not result:
        return 0, explain_empty(result)
    x = 0
    for k, event in enumerate(trace):
        result.problem.alphabet.index(event)
        target = dict(_row(evidence, x)).get(event)
        if target is None or evidence.native.reason[target] != SURVIVES:
            cut = _why(evidence, x, trace[:k], event)
            verdict = "impossible" if cut.verdict == "impossible" else "prevented"
            lead = f"The trace is cut at its event {k + 1} of {len(trace)}. {cut.lead}"
            return x, replace(cut, verdict=verdict, lead=lead)
        x = target
    return x, None


def _minimal_conflict(result: SynthesisResult) -> tuple[SynthesisResult, bool]:
    """Return an impossible problem of fewer specifications, synthesised, and whether none can be left out of it.

    Specifications that the proof in the evidence does not need go first; then one after the other is tried.
    """
    budget = max(_evidence(result).n_states, MIN_BUDGET)
    whole, core, minimal = result.plain, result, True

    def attempt(specs: Sequence[Automaton]) -> SynthesisResult | None:
        nonlocal budget
        problem = Problem(whole.plants, specs, alphabet=whole.alphabet)
        try:
            trial = synthesize(problem, "explicit", limits=Limits(states=budget))
        except LimitReached:
            return None
        budget = max(budget - _evidence(trial).n_states, 1)
        return trial

    in_proof = _evidence(result).native.conflict(ticker())[len(whole.plants) :]
    if not in_proof.all():
        trial = attempt([s for s, is_needed in zip(whole.specs, in_proof, strict=True) if is_needed])
        core, minimal = (core, False) if trial is None else (trial, True)
    for spec in reversed(core.plain.specs):
        trial = attempt([s for s in core.plain.specs if s is not spec])
        if trial is None:
            minimal = False
        elif not trial:
            core = trial
    return core, minimal


def _evidence(result: SynthesisResult) -> Exploration:
    if result.evidence is None:
        raise InputError("nothing was explored: an automaton of the problem has no states")
    return result.evidence


def _trace(result: SynthesisResult, after: Iterable[str] | str | None, state: int | None) -> Trace:
    if state is not None:
        if after is not None:
            raise InputError("give a trace or a state, not both")
        supervisor = result.supervisor.automaton
        return shortest_trace(supervisor, to=supervisor.state(state)) or Trace()
    if isinstance(after, str):
        return Trace(after)
    return Trace(after or ())


def _row(evidence: Exploration, x: int) -> list[tuple[str, int]]:
    return [(evidence.alphabet[e].name, t) for e, t in evidence.native.row(x)]


def _violations(broken: Iterable[tuple[str, Automaton, int]]) -> tuple[Violation, ...]:
    return tuple(Violation(spec.name, spec.states[q], event, spec.meaning) for event, spec, q in broken)


def listed(violations: tuple[Violation, ...]) -> str:
    """Join violations to one sentence; of very many, the first ones."""
    most = [str(v) for v in violations[:MAX_LISTED]]
    more = len(violations) - len(most)
    return ", and ".join([*most, f"{more} more like these"] if more else most)


def after_words(trace: Trace) -> str:
    """Say where a trace has led, however long it is."""
    if not len(trace):
        return "In the initial state"
    return f"After {trace}" if len(trace) <= 8 else f"After ..., {trace[-6:]} ({len(trace)} events)"


def could_follow(string: Trace) -> str:
    """Say that uncontrollable events may come."""
    kind = "the uncontrollable events " if len(string) > 1 else "the uncontrollable event "
    return f"{kind}{string} could follow, which no supervisor can prevent"
