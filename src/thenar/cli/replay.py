"""thenar replay: a recorded run, stepped through the model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from thenar.cli.common import as_json, limits, load_problem, print_json, say, supervisor_to_run
from thenar.errors import InputError, UnknownName

if TYPE_CHECKING:
    from thenar.model.problem import Problem
    from thenar.runtime.replay import Replay


@click.command()
@click.argument("log", metavar="LOG")
@click.argument("model", nargs=-1, metavar="[MODEL...]")
@limits
@as_json
def replay(log: str, model: tuple[str, ...], json_: bool, **bounds: Any) -> None:
    """Step a recorded run through the model, and say where it leaves the plant or the supervised plant.

    MODEL is the one that the log names, if not given.  Exits with 1 if the log leaves the model, or records a
    state or an enabled set that is not the model's.
    """
    from thenar.explicit.products import sync
    from thenar.runtime.record import read_log
    from thenar.runtime.replay import replay as step

    recorded = read_log(log)
    problem = load_problem(model) if model else _named(recorded.header, log)
    supervisor, _ = supervisor_to_run(problem, bounds)
    found = step(recorded, supervisor, sync(*problem.plants, name="G"))
    if json_:
        print_json(_plain(found))
    else:
        _print(found)
    if not found:
        raise click.exceptions.Exit(1)


def _named(header: dict[str, Any], log: str) -> Problem:
    """Return the library model that the header of a log names."""
    from thenar import library

    task, variant = header.get("task"), header.get("variant") or ""
    if not isinstance(task, str) or not isinstance(variant, str):
        raise InputError(f"{log}:1: task and variant of a header are texts; name the model: thenar replay LOG MODEL")
    try:
        if variant in ("", "paper"):
            return library.model(task)
        if task not in library.MODELS:
            raise UnknownName("model", task, library.MODELS)
        return library.MODELS[task](variant=variant)
    except InputError as error:
        raise InputError(f"{log}:1: {error}; name the model: thenar replay LOG MODEL") from None
    except TypeError:
        raise InputError(f"{log}:1: model {task!r} has no variant {variant!r}") from None


def _plain(found: Replay) -> dict[str, object]:
    checks = {"plant": found.accepted_by_plant, "supervisor": found.accepted_by_supervisor}
    return {
        **{
            f"accepted_by_{name}": {
                "holds": check.holds,
                "witness": None if check.witness is None else list(check.witness),
                "reason": check.reason,
            }
            for name, check in checks.items()
        },
        "differences": list(found.differences),
        "violations": list(found.violations),
        "torn": found.torn,
        "outcome": found.end.get("outcome") if found.end else None,
        "trace": list(found.trace),
    }


def _print(found: Replay) -> None:
    say(f"{len(found.trace)} events: {found.trace}")
    say(str(found.accepted_by_plant))
    say(str(found.accepted_by_supervisor))
    for difference in found.differences:
        say(difference)
    for violation in found.violations:
        say(f"the run itself found: {violation}")
    if found.end:
        say(f"the run ended: {found.end.get('outcome', '')}: {found.end.get('message', '')}")
    else:
        say(f"the log breaks off{' in the middle of a line' * found.torn}: the run did not get to its end")
