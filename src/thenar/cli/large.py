"""What thenar synth says of a supervisor that is a set of states: sizes, checks, guards."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from thenar.cli.common import print_json, say
from thenar.errors import about

if TYPE_CHECKING:
    from thenar.synthesis.api import SynthesisResult

__all__ = ["report_symbolic"]


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
        say(str(result.problem))
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
