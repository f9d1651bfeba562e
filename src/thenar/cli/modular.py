"""thenar modular: small supervisors that are together the largest one."""

from __future__ import annotations

from typing import Any

import click

from thenar.cli.common import as_json, limits, load_problem, make_limits, models, print_json, progress, say
from thenar.errors import about

__all__ = ["modular"]


@click.command()
@models
@click.option(
    "--engine", default="auto", show_default=True, metavar="E", help="Engine to use: auto, explicit or symbolic."
)
@limits
@as_json
def modular(model: tuple[str, ...], engine: str, json_: bool, **bounds: Any) -> None:
    """Synthesise by groups and local supervisors that are together the largest supervisor.

    Exit code 1 if none exists.
    """
    from thenar.synthesis.modular import synthesize_modular

    problem = load_problem(model)
    with progress() as show:
        result = synthesize_modular(problem, engine=engine, limits=make_limits(**bounds), progress=show)
    found = [local for group in result.groups for local in group.locals if local.result is not None]
    sizes = [local.result.size for local in found if local.result is not None]
    names = [([s.name for s in local.specs], [p.name for p in local.plants]) for local in found]
    if json_:
        rows = [
            {"specs": specs, "plants": plants, "states": size.states, "transitions": size.transitions}
            for (specs, plants), size in zip(names, sizes, strict=True)
        ]
        print_json({"exists": bool(result), "states": result.n_states, "how": result.how, "supervisors": rows})
    else:
        say(str(problem))
        say(f"  {about(result.n_states)} states, {1000 * result.seconds:.1f} ms: {result.how}")
        for (specs, plants), size in zip(names, sizes, strict=True):
            of = ", ".join(specs) + (f" with {', '.join(plants)}" if plants else "")
            say(f"  {size.states:>8,} states {size.transitions:>8,} transitions  {of}")
        if not result:
            say("No supervisor exists.")
    if not result:
        raise click.exceptions.Exit(1)
