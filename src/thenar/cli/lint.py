"""thenar lint: what looks wrong in a model although it can be solved."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from thenar.cli.common import (
    as_json,
    limits,
    load_any,
    make_limits,
    models,
    print_json,
    progress,
    run_synthesis,
    say,
)
from thenar.errors import Mistake

if TYPE_CHECKING:
    from thenar.model.extended import ExtendedProblem
    from thenar.model.problem import Problem

__all__ = ["lint"]


@click.command()
@models
@click.option("--sampled", is_flag=True, help="Also check the supervisor for a device that works in scans.")
@limits
@as_json
def lint(model: tuple[str, ...], sampled: bool, json_: bool, **bounds: Any) -> None:
    """Say what looks wrong in a model.

    States never reached, events that never happen, specifications that are not trim, alphabets that never meet,
    updates out of range.

    With --sampled the supervisor is computed, and it is said what goes wrong when a program runs it that reads its
    inputs at certain moments only: endless bursts of commands, choices, avalanches, the order of inputs.

    Exit code 1 if anything does.
    """
    from thenar.synthesis.lint import lint as find

    problem = load_any(model)
    with progress() as show:
        found = find(problem, limits=make_limits(**bounds), progress=show)
    if sampled:
        found += unfit_for_sampling(problem, bounds)
    if json_:
        print_json([asdict(mistake) for mistake in found])
    else:
        for mistake in found:
            say(str(mistake))
        if not found:
            say("nothing looks wrong")
    if found:
        raise click.exceptions.Exit(1)


def unfit_for_sampling(problem: Problem | ExtendedProblem, bounds: dict[str, Any]) -> list[Mistake]:
    """Return what keeps the supervisor of ``problem`` from running as it is on a sampled device."""
    from thenar.synthesis.implementation import fit_for_sampling

    result = run_synthesis(problem, bounds)
    if not result:
        return [Mistake("supervisor", "none exists")]
    supervisor = result.supervisor
    # what was synthesised is its own closed loop
    checks = fit_for_sampling(supervisor, supervisor.automaton)
    return [Mistake("sampled device", str(check)) for check in checks if not check]
