"""What thenar synth says and writes of a supervisor that is a set of states: sizes, checks, guards."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from thenar.cli.common import print_json, say, say_problem
from thenar.errors import InputError, LimitReached, about

if TYPE_CHECKING:
    from thenar.model.automaton import Automaton
    from thenar.model.extended import ExtendedProblem
    from thenar.symbolic.guards import Guards
    from thenar.synthesis.api import SynthesisResult

__all__ = ["listed_supervisor", "report_symbolic", "supervised_system"]

MAX_TERMS = 500_000  # of all guards together; what a model file holds, and some seconds


def listed_supervisor(result: SynthesisResult, output: str) -> Automaton:
    """Return the supervisor state by state; where that cannot be, the error names the way out."""
    way_out = "with --guards the supervised system is written as automata and guards"
    try:
        return result.supervisor.automaton
    except LimitReached as reached:
        if result.symbolic is None:
            raise
        states = about(result.symbolic.n_states)
        reached.args = (f"{output}: the supervisor has {states} states, too many to list one by one; {way_out}",)
        raise
    except InputError as error:  # several initial states, or an event with several outcomes
        raise InputError(f"{output}: {error}; {way_out}") from None


def supervised_system(result: SynthesisResult) -> ExtendedProblem:
    """Return the supervised system as automata and guards; raise InputError if the guards take too much room."""
    from thenar.symbolic.guards import guards, supervised

    assert result.symbolic is not None
    size = _written_out(guards(result.symbolic))
    if size > MAX_TERMS:
        raise InputError(
            f"the guards share what they say, and written out for a model file they have {about(size)} terms; "
            "leave out -o to print them"
        )
    return supervised(result.symbolic)


def _written_out(found: Guards) -> int:
    """Return how many terms the guards have with their definitions put in."""
    from thenar.model.expressions import Name, leaves

    sizes: dict[str, int] = {}
    for name, definition in found.definitions.items():  # each after those that it uses
        sizes[name] = sum(sizes.get(x.name, 1) if isinstance(x, Name) else 1 for x in leaves(definition))
    terms = (x for guard in found.values() for x in leaves(guard))
    return sum(sizes.get(x.name, 1) if isinstance(x, Name) else 1 for x in terms)


def report_symbolic(
    result: SynthesisResult, written: list[tuple[str, str]], bounds: dict[str, Any], *, guards: bool, as_json: bool
) -> bool:
    """Print what was found and return whether it is a supervisor: it exists, and the checks agree."""
    from thenar.symbolic.check import is_controllable, is_nonblocking
    from thenar.symbolic.guards import guards as find_guards

    supervisor = result.symbolic
    assert supervisor is not None
    controllable, nonblocking = is_controllable(supervisor), is_nonblocking(supervisor)
    found = find_guards(supervisor) if guards else None
    if as_json:
        print_json(
            {
                "supervisor": {"states": supervisor.n_states},
                "reachable": result.explored.states,
                "controllable": controllable,
                "nonblocking": nonblocking,
                "engine": result.engine,
                "engine_reason": result.engine_reason,
                "seconds": result.seconds,
                **({} if result else {"reason": result.reason.to_dict() if result.reason else None}),
                **({"guards": {e: str(g) for e, g in found.items()}} if found is not None else {}),
                **({"definitions": {d: str(p) for d, p in found.definitions.items()}} if found is not None else {}),
            }
        )
    else:
        say_problem(result.problem)
        say(f"  reachable   {about(result.explored.states):>12} states")
        if result:
            say(f"  supervisor  {about(supervisor.n_states):>12} states")
        else:
            say(str(result.reason))
        nodes = f"{supervisor.controlled.n_nodes:,} nodes, {supervisor.encoding.forest.peak:,} at most"
        say(f"  {result.engine} engine ({result.engine_reason}), {1000 * result.seconds:.1f} ms, {nodes}")
        for what, path in written:
            say(f"  {what} written to {path}")
        if result:
            checks = f"{'' if controllable else 'NOT '}controllable, {'' if nonblocking else 'NOT '}nonblocking"
            say(f"  checked on the diagrams: {checks}")
        if found is not None:
            say(str(found))
    return bool(result) and controllable and nonblocking
