"""thenar convert: from one format to another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from thenar.cli.common import limits, load_any, make_limits, progress, say, spec_files, specs
from thenar.errors import InputError

if TYPE_CHECKING:
    from thenar.model.extended import ExtendedProblem
    from thenar.model.limits import Limits, Progress
    from thenar.model.problem import Problem

__all__ = ["convert", "formats"]


@click.command()
@click.argument("model", nargs=-1, required=True, metavar="IN...")
@click.argument("output", metavar="OUT")
@click.option("--from", "source", metavar="FORMAT", help="The format of the files IN, if not as their endings say.")
@click.option("--to", "target", metavar="FORMAT", help="The format of OUT, if not as its ending says.")
@click.option("--flatten", is_flag=True, help="List the states of variables: one plant, one specification.")
@specs
@limits
def convert(
    model: tuple[str, ...], output: str, source: str | None, target: str | None, flatten: bool, **bounds: Any
) -> None:
    """Read the files IN (several are one problem), or a library model, and write OUT.

    OUT is a file, a folder (one file an automaton, for formats that hold one), or '-' for standard output.  What
    a format has no words for goes into a table beside the file, OUT.names.json, which is read with it.
    'thenar formats' lists the formats.
    """
    from thenar import io
    from thenar.model.extended import ExtendedProblem

    wanted = None if target is None else io.format_named(target)
    if output == "-" and wanted is None:
        raise InputError("-: say by --to in which format to write to standard output")
    if output != "-" and wanted is None:
        io.format_of(output)
    problem = io.load(*model, specs=spec_files(), format=source) if source else load_any(model)
    if flatten and isinstance(problem, ExtendedProblem):
        with progress() as show:
            problem = _listed(problem, make_limits(**bounds), show)
    if output == "-" and wanted is not None:
        text = io.dumps(problem, wanted.name)
        click.echo(text, nl=False)
    else:
        say(str(io.save(problem, output, target)))


def _listed(problem: ExtendedProblem, within: Limits, show: Progress | None) -> Problem:
    """Return ``problem`` with its states listed: the specification only if it forbids something."""
    from thenar.explicit.exploration import ticker
    from thenar.explicit.flatten import flatten
    from thenar.model.problem import Problem

    flat = flatten(problem, ticker(within, show)).problem
    if new := [name for name in flat.alphabet.names if name not in problem.alphabet]:
        say(f"note: added were {', '.join(new)}: where to start, what a choice leads to, that an invariant is broken")
    (plant,), (spec,) = flat.plants, flat.specs
    if spec.n_transitions < plant.n_transitions or (spec.marked != plant.marked).any():
        return flat
    return Problem(plant, name=flat.name, alphabet=flat.alphabet, description=flat.description)


@click.command()
def formats() -> None:
    """List the formats that are read and written."""
    from rich.console import Console
    from rich.table import Table

    from thenar.io import FORMATS

    table = Table("format", "what it is", "endings", "read", "written", box=None)
    for format in FORMATS:
        yes = ["yes" if can else "no" for can in (format.reads, format.writes)]
        table.add_row(format.name, format.title, ", ".join(format.endings), *yes)
    Console().print(table)
