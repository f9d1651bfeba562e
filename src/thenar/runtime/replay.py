"""Replay: a recorded run, stepped through the model alone."""

from __future__ import annotations

from dataclasses import dataclass, field

from thenar.errors import did_you_mean
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace
from thenar.runtime.identity import identity
from thenar.runtime.record import Entry, Log

__all__ = ["Replay", "replay"]


@dataclass(frozen=True, slots=True)
class Replay:
    """What a replay found: true exactly if plant and supervisor accept the log, and nothing in it contradicts them.

    * ``accepted_by_plant``, ``accepted_by_supervisor``: is the trace in L(G), in L(S/G); the witness ends with
      the first event that is not, and the reason names its line
    * ``differences``: each recorded state or enabled set that is not the recomputed one, each skill that was started
      while its event was not enabled, a time that runs backwards, and a header of another supervisor, with the line
    * ``violations``: what the run itself had found wrong
    * ``torn``: whether the last line was cut off; ``end``: the last entry of a log that is whole

    >>> yes = Check("accepted by the plant", True)
    >>> bool(Replay(Trace("lift"), yes, yes, (), (), False, None))
    True
    """

    trace: Trace
    accepted_by_plant: Check
    accepted_by_supervisor: Check
    differences: tuple[str, ...]
    violations: tuple[str, ...]
    torn: bool
    end: Entry | None = field(repr=False)

    def __bool__(self) -> bool:
        accepted = bool(self.accepted_by_plant and self.accepted_by_supervisor)
        return accepted and not self.differences and not self.violations


def replay(log: Log, supervisor: Supervisor, plant: Automaton) -> Replay:
    """Step ``log`` through G = ``plant`` and through S/G, and say where it leaves either.  O(|Σ|) an entry.

    Shares no code with the executor: each event is looked up in the automata themselves.  An event that the
    run recorded as a violation counts as one that happened.

    >>> from thenar.explicit.products import sync
    >>> from thenar.library.classics import small_factory
    >>> from thenar.runtime.record import entry, header
    >>> from thenar.synthesis.api import synthesize
    >>> problem = small_factory()
    >>> events = tuple(entry("event", t, event="start_2") for t in (1.0, 2.0))
    >>> found = replay(Log("run.jsonl", {}, events), synthesize(problem).supervisor, sync(*problem.plants))
    >>> print(found.accepted_by_supervisor)
    accepted by the supervisor: no after start_2: line 2: 'start_2' is disabled in supervisor state 0
    >>> print(found.accepted_by_plant)
    accepted by the plant: no after start_2, start_2: line 3: 'start_2' is impossible in plant state 'idle|working'
    """
    x = None if supervisor.is_empty else supervisor.automaton.initial
    g = None if plant.is_empty else plant.initial
    by_supervisor = Check("accepted by the supervisor", x is not None, reason=_none(x, "no supervisor exists"))
    by_plant = Check("accepted by the plant", g is not None, reason=_none(g, "the plant has no states"))
    trace: list[str] = []
    differences: list[str] = []
    recorded, here = log.header.get("supervisor"), identity(supervisor, plant)
    if recorded not in (None, here):
        differences.append(f"line 1: the log is of supervisor {recorded}, not of this one, {here}")
    before = -1.0
    for line, found in enumerate(log.entries, 2):
        if found["t"] < before:
            differences.append(f"line {line}: the time runs backwards, from {before:g} s to {found['t']:g} s")
        before = max(before, found["t"])
        if found["kind"] == "start" and x is not None and g is not None:
            event = str(found.get("event", ""))
            if why := _refused(supervisor, x, event) or _impossible(plant, supervisor, g, event):
                differences.append(f"line {line}: a skill was started although {why}")
        if found["kind"] in ("event", "violation"):
            event = found["event"]
            trace.append(event)
            impossible = "" if g is None else _impossible(plant, supervisor, g, event)
            refused = "" if x is None else _refused(supervisor, x, event) or impossible
            if refused:
                by_supervisor = Check(by_supervisor.property, False, Trace(trace), f"line {line}: {refused}")
            if impossible:
                by_plant = Check(by_plant.property, False, Trace(trace), f"line {line}: {impossible}")
            x = None if x is None or refused else supervisor.automaton.step(x, event)
            if g is not None and event in plant.alphabet:
                g = plant.step(g, event)
            elif impossible:
                g = None
        if found["kind"] in ("begin", "event"):
            differences += [f"line {line}: {what}" for what in _differences(found, supervisor, x, plant, g)]
    violations = tuple(str(v) for v in log.end.get("violations", ())) if log.end else ()
    return Replay(Trace(trace), by_plant, by_supervisor, tuple(differences), violations, bool(log.torn), log.end)


def _none(state: int | None, why: str) -> str:
    return why if state is None else ""


def _impossible(plant: Automaton, supervisor: Supervisor, state: int, event: str) -> str:
    """Return why the plant cannot do ``event``, "" if it can."""
    if event not in plant.alphabet:  # a plant does not hinder what only specifications know
        known = supervisor.automaton.alphabet
        return "" if event in known else f"unknown event {event!r}{did_you_mean(event, known.names)}"
    if plant.step(state, event) is None:
        return f"{event!r} is impossible in plant state {plant.states[state]!r}"
    return ""


def _refused(supervisor: Supervisor, state: int, event: str) -> str:
    """Return why the supervisor does not let ``event`` happen, "" if it does."""
    automaton = supervisor.automaton
    if event not in automaton.alphabet:
        return f"unknown event {event!r}{did_you_mean(event, automaton.alphabet.names)}"
    if not supervisor.psi(event, state):
        return f"{event!r} is disabled in supervisor state {state}"
    if automaton.step(state, event) is None:
        return f"{event!r} is impossible in supervisor state {state}"
    return ""


def _differences(found: Entry, supervisor: Supervisor, x: int | None, plant: Automaton, g: int | None) -> list[str]:
    """Return how an entry differs from what is computed; nothing is compared once the model was left."""
    computed: dict[str, object] = {}
    if g is not None:
        computed |= {"plant": plant.states[g], "plant_state": g}
    if x is not None:
        computed["supervisor_state"] = x
    if x is not None and g is not None:
        enabled = [e.name for e in supervisor.pattern(x).enabled if supervisor.psi(e, x)]
        computed["enabled"] = [e for e in enabled if not _impossible(plant, supervisor, g, e)]
    return [
        f"{name} is recorded as {_shown(found[name])}, but is {_shown(value)}"
        for name, value in computed.items()
        if name in found and _plain(found[name]) != _plain(value)
    ]


def _plain(value: object) -> object:
    """Return a list of names in an order of its own: what is enabled is a set."""
    return sorted(value) if isinstance(value, list) else value


def _shown(value: object) -> str:
    return ", ".join(value) or "nothing" if isinstance(value, list) else str(value)
