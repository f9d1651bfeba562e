"""thenar reduce: a small supervisor, or one for each plant, that controls as the largest one does."""

from __future__ import annotations

from typing import Any

import click

from thenar.cli.common import (
    as_json,
    check_outputs,
    limits,
    load_problem,
    make_limits,
    models,
    print_json,
    progress,
    run_synthesis,
    say,
)

__all__ = ["reduce"]


@click.command()
@models
@click.option("-o", "--output", metavar="OUT", help="Write it to the file OUT, or several to the folder OUT.")
@click.option("--to", "target", metavar="FORMAT", help="The format of OUT, if not as its ending says.")
@click.option("--local", is_flag=True, help="One controller for each plant, which disables events of that plant only.")
@limits
@as_json
def reduce(
    model: tuple[str, ...], output: str | None, target: str | None, local: bool, json_: bool, **bounds: Any
) -> None:
    """Synthesise, and reduce the supervisor to a small one that controls alike.

    What the supervisor knows about the plant is forgotten where it makes no difference to what must be disabled.
    Exit code 1 if no supervisor exists.
    """
    from thenar import io
    from thenar.explicit.reduction import localize, supreduce
    from thenar.model.problem import Problem

    problem = load_problem(model)
    check_outputs(model, output)
    if output is not None and target is None:
        io.format_of(output)
    result = run_synthesis(problem, bounds)
    if not result:
        say(str(result.reason))
        raise click.exceptions.Exit(1)
    with progress() as show:
        within = make_limits(**bounds)
        if local:
            found = localize(problem.plants, result.supervisor, limits=within, progress=show)
        else:
            title = problem.name or "supervisor"
            found = (supreduce(problem.plants, result.supervisor, name=title, limits=within, progress=show),)
    rows = [(r.automaton.name, r.n_states, r.lower_bound, r.n_transitions) for r in found]
    if json_:
        keys = ("name", "states", "at_least", "transitions")
        print_json({"supervisor": result.size.states, "reduced": [dict(zip(keys, row, strict=True)) for row in rows]})
    else:
        say(f"{problem}\n  supervisor {result.size.states:,} states, reduced to")
        for name, states, least, transitions in rows:
            say(f"  {states:>8,} states (at least {least:,}) {transitions:>8,} transitions  {name}")
    if output is not None:
        whole = Problem([r.automaton for r in found], name=problem.name) if local else found[0].automaton
        saved = io.save(whole, output, target)
        if not json_:
            say(str(saved))
