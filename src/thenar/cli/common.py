"""What the commands share: models by name, traces as people type them, progress, JSON."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import click

from thenar.errors import InputError, UnknownName, did_you_mean

if TYPE_CHECKING:
    from thenar.model.events import Alphabet
    from thenar.model.extended import ExtendedProblem
    from thenar.model.limits import Limits, Progress
    from thenar.model.problem import Problem
    from thenar.model.supervisor import Supervisor
    from thenar.model.trace import Trace
    from thenar.synthesis.api import SynthesisResult

__all__ = [
    "as_json",
    "check_outputs",
    "find_event",
    "find_trace",
    "limits",
    "load_any",
    "load_problem",
    "make_limits",
    "models",
    "print_json",
    "progress",
    "run_synthesis",
    "say",
    "say_problem",
    "supervisor_to_run",
]

F = TypeVar("F", bound=Callable[..., Any])
_SPECS = "thenar.specs"  # where the files of --spec are kept, so that no command has to hand them on


def specs(function: F) -> F:
    """Add the files that are specifications; ``load_any`` reads them with the models."""
    return click.option(
        "--spec",
        multiple=True,
        metavar="FILE",
        expose_value=False,
        callback=_keep_specs,
        help="A file that holds one automaton (.DES, .gen, ...), and that is a specification; else it is a plant.",
    )(function)


def models(function: F) -> F:
    """Add the models, and the files of specifications among them; ``load_any`` reads both."""
    return click.argument("model", nargs=-1, required=True, metavar="MODEL...")(specs(function))


def spec_files() -> tuple[str, ...]:
    """Return the files that :func:`specs` was given."""
    context = click.get_current_context(silent=True)
    return () if context is None else context.meta.get(_SPECS, ())


def check_outputs(model: tuple[str, ...], *outputs: str | None) -> None:
    """Complain of files that cannot be written, or that would overwrite each other or a model, before any work."""
    from thenar import io

    taken = {os.path.realpath(name): "the model" for name in (*model, *spec_files()) if os.path.isfile(name)}
    for path in outputs:
        if path is None:
            continue
        if path == "-":
            raise InputError("'-' is no file to write to; show the supervisor with thenar show --automaton supervisor")
        place = os.path.realpath(path)
        if not os.path.isdir(place):
            io.check_writable(path.rstrip("/"))
        if place in taken:
            raise InputError(f"{path}: would overwrite {taken[place]}; give it another name")
        taken[place] = "the other output"


def _keep_specs(context: click.Context, parameter: click.Parameter, files: tuple[str, ...]) -> None:
    context.meta[_SPECS] = files


as_json = click.option("--json", "json_", is_flag=True, help="Print JSON instead of text.")


def limits(function: F) -> F:
    """Add the options that bound a computation; ``make_limits`` reads them."""
    options = (
        click.option("--max-states", type=click.IntRange(1), metavar="N", help="Stop exploring after N states."),
        click.option("--max-seconds", type=click.FloatRange(0), metavar="S", help="Stop exploring after S seconds."),
        click.option("--max-bytes", type=click.IntRange(1), metavar="B", help="Stop when the kernel holds B bytes."),
    )
    for option in reversed(options):
        function = option(function)
    return function


def make_limits(max_states: int | None, max_seconds: float | None, max_bytes: int | None) -> Limits:
    """Turn the options of :func:`limits` into Limits."""
    from thenar.model.limits import Limits

    return Limits(states=max_states, seconds=max_seconds, bytes=max_bytes)


def load_problem(names: tuple[str, ...]) -> Problem:
    """Load library models and files; several are composed into one problem."""
    from thenar.model.problem import Problem

    loaded = load_any(names)
    if isinstance(loaded, Problem):
        return loaded
    more = bool(loaded.variables or loaded.plant_conditions or loaded.spec_conditions)
    has = "has variables or conditions" if more else "is nondeterministic"
    raise InputError(
        f"{names[0]}: {has}, which this command does not take; thenar synth, explain, simulate, lint and show do, "
        "and thenar convert --flatten makes plain automata of it"
    )


def load_any(names: tuple[str, ...]) -> Problem | ExtendedProblem:
    """Load as :func:`load_problem` does, or one model with variables and conditions."""
    from thenar import io, library
    from thenar.model.events import merge
    from thenar.model.problem import Problem, compose

    files = [n for n in names if _is_file(n, library.MODELS)]
    allowed = spec_files()
    problems = []
    for name in names:
        if name not in files:
            try:
                problems.append(library.model(name))
            except UnknownName:
                near = did_you_mean(name, library.MODELS)
                known = ", ".join(library.MODELS)
                raise InputError(
                    f"no file and no library model is called {name!r}{near}; library models: {known}"
                ) from None
        elif name == files[0]:  # files share their events, so they are read together
            loaded = io.load(*files, specs=allowed)
            if isinstance(loaded, Problem):
                problems.append(loaded)
            elif len(names) > len(files):
                raise InputError(f"{name}: a model with variables or conditions stands alone; leave out the others")
            else:
                return loaded
    whole = compose(problems)
    if not allowed or files:
        return whole
    more = io.load(*allowed)  # which takes them as plants
    if not isinstance(more, Problem):
        raise InputError(f"--spec {allowed[0]}: has variables or conditions, and stands alone")
    alphabet = merge([whole.alphabet, more.alphabet], [whole.name, "the files of --spec"])
    return Problem(whole.plants, [*whole.specs, *more.automata], name=whole.name, alphabet=alphabet)


def _is_file(name: str, models: Container[str]) -> bool:
    """Tell a file from the name of a library model: it looks like one, or it is there and no model is called so."""
    from thenar.io.formats import FORMATS

    endings = tuple(ending.lower() for format in FORMATS for ending in format.endings)
    looks = name == "-" or "/" in name or name.lower().endswith(endings)
    return looks or (name not in models and os.path.exists(name))


def find_event(alphabet: Alphabet, name: str) -> str:
    """Return the event called ``name``; the ``*`` that marks a shared event may be left out."""
    return name + "*" if name not in alphabet and name + "*" in alphabet else alphabet[name].name


def find_trace(alphabet: Alphabet, text: str) -> Trace:
    """Read a trace; raises UnknownName for its first unknown event."""
    from thenar.model.trace import Trace

    return Trace(find_event(alphabet, name) for name in Trace(text))


@contextmanager
def progress() -> Iterator[Progress | None]:
    """Yield a progress callback that keeps a line on a terminal up to date, once work has taken a moment."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console

    status = Console(stderr=True).status("")
    start, shown = time.monotonic(), False

    def show(states: int, transitions: int) -> None:
        nonlocal shown
        elapsed = time.monotonic() - start
        if elapsed < 0.5:
            return
        status.update(f"{states:,} states or nodes, {transitions:,} steps, {elapsed:.0f} s   (Ctrl-C stops)")
        if not shown:
            status.start()
            shown = True

    try:
        yield show
    finally:
        status.stop()


def run_synthesis(problem: Problem | ExtendedProblem, bounds: dict[str, Any]) -> SynthesisResult:
    """Synthesise within the limits of the command line, with progress."""
    from thenar.synthesis.api import synthesize

    with progress() as show:
        return synthesize(problem, limits=make_limits(**bounds), progress=show)


def supervisor_to_run(problem: Problem, bounds: dict[str, Any]) -> tuple[Supervisor, object]:
    """Return the supervisor of ``problem`` that is executed, and why there is none, if so.

    In a timed problem, one with the event ``tick``, forcible events preempt it.
    """
    from thenar.explicit.forcing import supcon_forcing
    from thenar.explicit.timed import TICK

    if TICK.name not in problem.alphabet:
        result = run_synthesis(problem, bounds)
        return result.supervisor, result.reason
    with progress() as show:
        supervisor = supcon_forcing(problem.plants, problem.specs, limits=make_limits(**bounds), progress=show)
    return supervisor, "no supervisor exists, not even one that forces" if supervisor.is_empty else None


def print_json(value: object) -> None:
    """Print as JSON."""
    limit = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(0)  # counts of states may have thousands of digits; they are ours, not a stranger's
    try:
        text = json.dumps(value, ensure_ascii=False, indent=2)
    finally:
        sys.set_int_max_str_digits(limit)
    click.echo(text)


def say(text: str = "") -> None:
    """Print a line."""
    click.echo(text)


def say_problem(problem: Problem | ExtendedProblem) -> None:
    """Print what the problem is, and what of it a synthesis does not consider."""
    say(str(problem))
    hidden = sum(not event.observable for event in problem.alphabet)
    if hidden:
        say(f"  note: {hidden} of its events cannot be observed; that is not considered")
    if len(problem.alphabet) and not any(event.controllable for event in problem.alphabet):
        say("  note: none of its events is controllable; files of libFAUDES say which are by +C+")
