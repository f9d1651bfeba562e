"""thenar lint: what looks wrong in a model although it can be solved."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

from thenar.cli.common import as_json, limits, load_any, make_limits, models, print_json, progress, say

__all__ = ["lint"]


@click.command()
@models
@limits
@as_json
def lint(model: tuple[str, ...], json_: bool, **bounds: Any) -> None:
    """Say what looks wrong in a model: states never reached, events that never happen, updates out of range.

    Exit code 1 if anything does.
    """
    from thenar.synthesis.lint import lint as find

    problem = load_any(model)
    with progress() as show:
        found = find(problem, limits=make_limits(**bounds), progress=show)
    if json_:
        print_json([asdict(mistake) for mistake in found])
    else:
        for mistake in found:
            say(str(mistake))
        if not found:
            say("nothing looks wrong")
    if found:
        raise click.exceptions.Exit(1)
