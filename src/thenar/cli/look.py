"""thenar show, paper, doctor: things to look at."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import click

from thenar.cli.common import (
    as_json,
    check_outputs,
    find_trace,
    limits,
    load_any,
    make_limits,
    models,
    print_json,
    progress,
    run_synthesis,
    say,
)
from thenar.errors import InputError

if TYPE_CHECKING:
    from thenar.model.automaton import Automaton
    from thenar.model.problem import Problem
    from thenar.model.supervisor import Supervisor
    from thenar.model.trace import Trace

FORMATS = ("text", "mermaid", "svg")


@click.command()
@models
@click.option("--format", "format_", type=click.Choice(FORMATS), default="text", show_default=True)
@click.option("--automaton", metavar="NAME", help="What to show: an automaton of the model, 'plant' or 'supervisor'.")
@click.option("--after", metavar="TRACE", help="Highlight the way along these events.")
@click.option("--layout", type=click.Choice(["own", "dot"]), default="own", help="Who places the states of an svg.")
@click.option("-o", "--output", metavar="OUT", help="Write to OUT instead of standard output.")
@limits
@as_json
def show(
    model: tuple[str, ...],
    format_: str,
    automaton: str | None,
    after: str | None,
    layout: Literal["own", "dot"],
    output: str | None,
    json_: bool,
    **bounds: Any,
) -> None:
    """Show a model: its automata as a table, as Mermaid text or as a drawing; with --json, as a model file.

    Without --automaton the whole problem is shown; a drawing needs one automaton.  One with variables or conditions is
    shown as a model file.
    """
    from thenar import io, render
    from thenar.model.problem import Problem
    from thenar.model.supervisor import Supervisor

    problem = load_any(model)
    check_outputs(model, output)
    if not isinstance(problem, Problem):
        if format_ != "text" or automaton is not None or after is not None:
            raise InputError(
                f"{model[0]}: has variables or conditions, and is shown as a whole: as text, or with --json as JSON"
            )
        text = io.dumps(problem, "json" if json_ else "toml").rstrip("\n")
    elif json_:
        whole = problem if automaton is None else _choose(problem, automaton, bounds)
        text = io.dumps(whole.automaton if isinstance(whole, Supervisor) else whole, "json").rstrip("\n")
    elif format_ == "text" and automaton is None:
        text = "\n\n".join([render.table(problem), *(render.table(a) for a in problem.automata)])
    else:
        if automaton is None and len(problem.automata) > 1:
            names = ", ".join([*(a.name for a in problem.automata), "plant", "supervisor"])
            raise InputError(f"a drawing shows one automaton; choose with --automaton: {names}")
        chosen = _choose(problem, automaton or problem.automata[0].name, bounds)
        path = None if after is None else _seen_by(chosen, find_trace(problem.alphabet, after))
        if format_ == "text":
            text = render.table(chosen)
        elif format_ == "svg":
            text = render.svg(chosen, path=path, layout=layout)
        else:
            text = render.mermaid(chosen, path=path)
    if output is None:
        say(text)
    else:
        io.atomic_write(output, text + "\n")


def _choose(problem: Problem, name: str, bounds: dict[str, Any]) -> Automaton | Supervisor:
    from thenar.explicit.products import sync

    if name == "supervisor":
        return run_synthesis(problem, bounds).supervisor
    if name != "plant":
        return problem.automaton(name)
    with progress() as show:
        return sync(*problem.plants, limits=make_limits(**bounds), progress=show)


def _seen_by(chosen: Automaton | Supervisor, trace: Trace) -> Trace:
    """Return the events of a trace of the whole model that the chosen automaton takes part in."""
    from thenar.model.supervisor import Supervisor
    from thenar.model.trace import Trace

    alphabet = (chosen.automaton if isinstance(chosen, Supervisor) else chosen).alphabet
    return Trace(e for e in trace if e in alphabet)


@click.command()
@as_json
def paper(json_: bool) -> None:
    """Compute the paper's published results, and set each beside the published figure.

    Exit code 1 if one that the reconstruction must reach (status 'exact') is missed.
    """
    from thenar.library.glr.paper import SIMULATIONS, results, simulations

    rows = results()
    if json_:
        fields = ("what", "published", "computed", "match", "status")
        print_json({"rows": [{f: getattr(r, f) for f in fields} for r in rows]})
    else:
        from rich import box
        from rich.console import Console
        from rich.table import Table

        console = Console(highlight=False)
        if not console.is_terminal:
            console.width = 160  # a pipe has no width: leave the rows whole
        view = Table("what", "published", "computed", "match", box=box.SIMPLE)
        for r in rows:
            match = "[green]yes[/]" if r.match else "[yellow]open[/]" if r.status == "open" else "[red]NO[/]"
            view.add_row(r.what, r.published, r.computed, match)
        for simulation, steps in zip(SIMULATIONS, simulations(), strict=True):
            console.print(f"[bold]{simulation.title}[/]   (the published state number at the end, where it differs)")
            lines = [status for step in steps for status in step.statuses]
            for k, line in enumerate(lines):
                published = simulation.published[k][2] if k < len(simulation.published) else None
                console.print(f"{line}" + (f"   [yellow]({published})[/]" if published != line.state else ""))
            console.print()
        console.print(view)
        exact = [r for r in rows if r.status == "exact"]
        console.print(
            f"{sum(r.match for r in exact)} of {len(exact)} results that the reconstruction must reach are reached; "
            f"{sum(r.match for r in rows if r.status == 'open')} of {len(rows) - len(exact)} open ones: the paper's "
            "figures are lost, and its words do not determine them."
        )
    if not all(r.match for r in rows if r.status == "exact"):
        raise click.exceptions.Exit(1)


@click.command()
@as_json
def doctor(json_: bool) -> None:
    """Say what is installed, what is missing, and how to get it."""
    from thenar.cli.health import examine

    findings = examine()
    if json_:
        print_json([{"what": f.what, "found": f.found, "needed_for": f.needed_for, "get": f.get} for f in findings])
    else:
        for f in findings:
            mark = "ok      " if f.found else "MISSING " if f.required else "-       "
            say(f"{mark} {f.what:<20} {f.found or f'not found; for {f.needed_for}: {f.get}'}")
    if any(f.required and not f.found for f in findings):
        raise click.exceptions.Exit(1)
