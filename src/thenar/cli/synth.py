"""thenar synth, check, verify: the answers that are true or false."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from thenar.cli.common import (
    as_json,
    check_outputs,
    limits,
    load_any,
    load_problem,
    make_limits,
    models,
    print_json,
    progress,
    say,
    say_problem,
    specs,
)
from thenar.cli.large import listed_supervisor, report_symbolic, supervised_system
from thenar.errors import InputError, about

if TYPE_CHECKING:
    from thenar.model.limits import Limits, Progress
    from thenar.model.problem import Problem
    from thenar.model.trace import Check
    from thenar.synthesis.api import SynthesisResult

PROPERTIES = ("controllable", "nonblocking", "nonconflicting", "solvable")


@click.command()
@models
@click.option(
    "-o", "--output", metavar="OUT", help="Write the supervisor to OUT (.toml, .DES ...), state by state; see --guards."
)
@click.option(
    "--engine", default="auto", show_default=True, metavar="E", help="Engine to use: auto, explicit or symbolic."
)
@click.option("--order", default="auto", show_default=True, metavar="O", help="Order of the symbolic engine's levels.")
@click.option(
    "--guards",
    "guards_",
    is_flag=True,
    help="Print a guard for each controllable event; with -o, write the supervised system as automata and guards.",
)
@click.option("--certificate", "certificate_", metavar="FILE", help="Write the evidence, for 'thenar verify FILE'.")
@limits
@as_json
def synth(
    model: tuple[str, ...],
    output: str | None,
    engine: str,
    order: str,
    guards_: bool,
    certificate_: str | None,
    json_: bool,
    **bounds: Any,
) -> None:
    """Synthesise the largest controllable, nonblocking supervisor.

    Exit code 1 if none exists; the reason is printed.
    """
    from thenar import io
    from thenar.synthesis.api import synthesize
    from thenar.synthesis.certificate import certificate

    problem = load_any(model)
    check_outputs(model, output, certificate_)
    if output is not None:
        io.format_of(output)
    if guards_ and engine == "explicit":
        raise InputError("guards come from the symbolic engine; leave out --engine explicit")
    with progress() as show:
        chosen = "symbolic" if guards_ else engine
        result = synthesize(problem, chosen, order=order, limits=make_limits(**bounds), progress=show)
        proof = None if certificate_ is None else certificate(result)  # made before the first file is written
        if output is not None and result:
            saved = io.save(supervised_system(result) if guards_ else listed_supervisor(result, output), output)
            for note in saved.notes:
                say(f"note: {note}")
        if certificate_ is not None and proof is not None:
            io.atomic_write(certificate_, proof)
    written = [
        (what, path)
        for what, path in (
            ("supervised system" if guards_ else "supervisor", output if result else None),
            ("certificate", certificate_),
        )
        if path
    ]
    report = report_symbolic if result.symbolic is not None else _report
    if not report(result, written, bounds, guards=guards_, as_json=json_):
        raise click.exceptions.Exit(1)


def _report(
    result: SynthesisResult, written: list[tuple[str, str]], bounds: dict[str, Any], *, guards: bool, as_json: bool
) -> bool:
    """Print what was found and return whether it is a supervisor: it exists, and the checks agree."""
    from thenar.explicit.control import is_controllable
    from thenar.explicit.reach import is_nonblocking

    plain, size = result.plain, result.size
    automaton = result.extract.automaton if result.extract else result.supervisor.automaton
    disablements = len(result.extract.disabled) if result.extract else 0
    with progress() as show:
        # not taken on trust: checked again on the result, as the properties of any automaton are
        controllable = bool(is_controllable(automaton, plain.plants, progress=show))
        nonblocking = bool(is_nonblocking(automaton))
        plant = _plant_size(plain, result, make_limits(**bounds), show)
    if as_json:
        print_json(
            {
                "plant": {"states": plant[0], "transitions": plant[1]},
                "supervisor": {"states": size.states, "transitions": size.transitions},
                "controllable": controllable,
                "nonblocking": nonblocking,
                "engine": result.engine,
                "engine_reason": result.engine_reason,
                "seconds": result.seconds,
                **({} if result else {"reason": result.reason.to_dict() if result.reason else None}),
            }
        )
    else:

        def sizes(what: str, states: int | None, transitions: int | None) -> None:
            here = (
                "not counted: too large" if states is None else f"{states:>12,} states {transitions:>12,} transitions"
            )
            say(f"  {what:<11} {here}")

        say_problem(result.problem)
        sizes("plant", *plant)
        if result:
            sizes("supervisor", size.states, size.transitions)
            say(f"  {disablements:,} disablements; {result.engine} engine, {1000 * result.seconds:.1f} ms")
        else:
            say(str(result.reason))
        for what, path in written:
            say(f"  {what} written to {path}")
        if result:
            say(f"  checked: {'' if controllable else 'NOT '}controllable, {'' if nonblocking else 'NOT '}nonblocking")
    return bool(result) and controllable and nonblocking


def _plant_size(
    problem: Problem, result: SynthesisResult, bounds: Limits, show: Progress | None
) -> tuple[int, int] | tuple[None, None]:
    """Return the states and transitions of the plants' product; None where counting them would dwarf the synthesis."""
    from thenar.errors import LimitReached
    from thenar.explicit.products import sync

    most = max(4 * result.explored.states, 1_000_000)
    bounds = replace(bounds, states=most if bounds.states is None else min(bounds.states, most))
    try:
        plant = sync(*problem.plants, limits=bounds, progress=show)
    except LimitReached:
        return None, None
    return plant.n_states, plant.n_transitions


@click.command()
@models
@click.option(
    "--property", "properties", multiple=True, type=click.Choice(PROPERTIES), help="What to check; default: everything."
)
@limits
@as_json
def check(model: tuple[str, ...], properties: tuple[str, ...], json_: bool, **bounds: Any) -> None:
    """Check properties of a problem, with a shortest trace as evidence where one does not hold.

    \b
    controllable    no specification forbids an uncontrollable event that the plants can do
    nonblocking     plants and specifications together can always reach a marked state
    nonconflicting  the specifications among themselves can always reach a marked state
    solvable        a supervisor exists

    Exit code 1 if one of them does not hold.
    """
    problem = load_problem(model)
    with progress() as show:
        checks = [_check(problem, p, bounds, show) for p in properties or PROPERTIES]
    if json_:
        print_json([_plain(c) for c in checks])
    else:
        for c in checks:
            say(str(c))
    if not all(checks):
        raise click.exceptions.Exit(1)


def _check(problem: Problem, name: str, bounds: dict[str, Any], show: Any) -> Check:
    from thenar.explicit.control import is_controllable
    from thenar.explicit.reach import is_nonconflicting
    from thenar.model.trace import Check, Trace
    from thenar.synthesis.api import synthesize

    how = {"limits": make_limits(**bounds), "progress": show}
    if name == "controllable":
        return is_controllable(problem.specs, problem.plants, **how)
    if name == "solvable":
        result = synthesize(problem, **how)
        return Check("solvable", True) if result else Check("solvable", False, Trace(), str(result.reason))
    together = problem.automata if name == "nonblocking" else problem.specs
    if not together:
        return Check(name, True)
    found = is_nonconflicting(*together, **how)
    return Check(name, found.holds, found.witness, found.reason)


def _plain(found: Check) -> dict[str, object]:
    witness = None if found.witness is None else list(found.witness)
    return {"property": found.property, "holds": found.holds, "witness": witness, "reason": found.reason}


@click.command()
@click.argument("file", metavar="FILE")
@click.argument("model", nargs=-1, metavar="[MODEL...]")
@specs
@as_json
def verify(file: str, model: tuple[str, ...], json_: bool) -> None:
    """Check a certificate with an independent checker; with MODEL, also that it is about that problem.

    Exit code 1 if the certificate proves nothing, 2 if it is none or damaged.
    """
    from thenar.synthesis.certificate import statement
    from thenar.synthesis.verify import verify as verify_file

    verdict = verify_file(file, statement(load_any(model)) if model else None)
    holds, reason = bool(verdict), verdict.reason
    if json_:
        supervisor = {"states": verdict.states, "transitions": verdict.transitions}
        about_it = {"problem": verdict.problem, "supervisor": supervisor, "nodes": verdict.nodes}
        print_json({"holds": holds, "reason": reason, **about_it})
    elif holds:
        say(f"{file}: proved: {reason}")
        sizes = f"{about(verdict.states)} states, {about(verdict.transitions)} transitions"
        how = f", on diagrams of {verdict.nodes:,} nodes" if verdict.nodes else ""
        say(f"  {verdict.problem}: {sizes}; {about(verdict.checked)} states of the product checked{how}")
    else:
        say(f"{file}: not proved: {reason}")
    if not holds:
        raise click.exceptions.Exit(1)
