"""thenar explain, simulate: what happens, and why."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from thenar.cli.common import (
    as_json,
    find_event,
    find_trace,
    limits,
    load_any,
    models,
    print_json,
    run_synthesis,
    say,
)
from thenar.errors import InputError

if TYPE_CHECKING:
    from thenar.synthesis.api import SynthesisResult
    from thenar.synthesis.simulate import Step


@click.command()
@models
@click.option("--after", metavar="TRACE", help="Where to ask: after these events, separated by commas.")
@click.option("--state", type=click.IntRange(0), metavar="N", help="Where to ask: in supervisor state N.")
@click.option("--event", metavar="E", help="The event to ask about; default: every disabled one.")
@limits
@as_json
def explain(
    model: tuple[str, ...], after: str | None, state: int | None, event: str | None, json_: bool, **bounds: Any
) -> None:
    """Say why an event is disabled, why a trace is prevented, or why no supervisor exists.

    The '*' at the end of an event's name may be left out.
    """
    from thenar.synthesis.explain import explain as explain_all
    from thenar.synthesis.explain import explain_disabled

    problem = load_any(model)
    trace = None if after is None else find_trace(problem.alphabet, after)
    event = None if event is None else find_event(problem.alphabet, event)
    result = run_synthesis(problem, bounds)
    if event is None:
        found = explain_all(result, after=trace, state=state)
    else:
        found = [explain_disabled(result, event, after=trace, state=state)]
    if json_:
        print_json([e.to_dict() for e in found])
        return
    for k, e in enumerate(found):
        say("\n" * (k > 0) + click.wrap_text(str(e), width=100))


@click.command()
@models
@click.option("--trace", metavar="TRACE", help="Offer these events, separated by commas, one by one.")
@click.option("--interactive", "-i", is_flag=True, help="Choose each event yourself.")
@click.option("--random", "length", type=click.IntRange(0), metavar="N", help="Let N enabled events happen at random.")
@click.option("--seed", type=int, default=0, show_default=True, metavar="S", help="Seed of --random.")
@limits
@as_json
def simulate(
    model: tuple[str, ...],
    trace: str | None,
    interactive: bool,
    length: int | None,
    seed: int,
    json_: bool,
    **bounds: Any,
) -> None:
    """Step the supervised system, and say at each step what is enabled and what is disabled."""
    from thenar.synthesis.simulate import random_trace
    from thenar.synthesis.simulate import simulate as run

    if [trace is not None, interactive, length is not None].count(True) != 1:
        raise InputError("say what to simulate: one of --trace, --interactive and --random")
    if interactive and json_:
        raise InputError("--interactive talks to a person; --json goes with --trace or --random")
    problem = load_any(model)
    names = None if trace is None else find_trace(problem.alphabet, trace)
    result = run_synthesis(problem, bounds)
    if not result:
        if json_:
            print_json({"reason": result.reason.to_dict() if result.reason else None})
        else:
            say(str(result.reason))
        raise click.exceptions.Exit(1)
    if interactive:
        _interact(result)
        return
    if names is None:
        names = random_trace(result.supervisor, length or 0, seed)
    steps = run(result.supervisor, names)
    if json_:
        print_json([_plain(step) for step in steps])
    else:
        for step in steps:
            for status in step.statuses:
                say(str(status))


def _plain(step: Step) -> dict[str, object]:
    return {
        "state": step.state,
        "event": step.event,
        "status": step.statuses[0].status,
        "target": step.target,
        "enabled": [e.name for e in step.pattern.enabled],
        "disabled": [e.name for e in step.pattern.disabled],
    }


def _interact(result: SynthesisResult) -> None:
    """Let a person step: enabled events numbered, disabled ones with the reason."""
    from thenar.model.trace import Trace
    from thenar.render.measure import printable
    from thenar.synthesis.explain import explain_disabled

    supervisor = result.supervisor
    automaton = supervisor.automaton
    trace: list[str] = []
    while True:
        state = automaton.run(trace)[-1]
        pattern = supervisor.pattern(state)
        numbers = {str(k): event.name for k, event in enumerate(pattern.enabled, 1)}
        marked = "   (marked)" if automaton.marked[state] else ""
        say(f"\nState {state}: {printable(automaton.states[state])}{marked}")
        for k, event in enumerate(pattern.enabled, 1):
            kind = "" if event.controllable else "   (uncontrollable)"
            say(f"  {k:>3}  {event.name:<24} {event.meaning}{kind}")
        for event in pattern.disabled:
            say(f"    -  {event.name:<24} disabled: {explain_disabled(result, event.name, after=trace).why}")
        answer = _answer()
        if answer == "q":
            say(f"Trace: {Trace(trace)}")
            return
        if answer == "u":
            trace = trace[:-1]
        elif answer in numbers:
            trace.append(numbers[answer])
        elif answer in pattern:
            trace.append(answer)
        elif answer + "*" in pattern:
            trace.append(answer + "*")
        else:
            say(f"{answer!r} is not enabled here; give a number from the list, its event, u to undo or q to quit")


def _answer() -> str:
    """Read an answer; the end of the input quits."""
    try:
        return str(click.prompt("event (number or name, u undo, q quit)", default="q", show_default=False)).strip()
    except (click.Abort, RuntimeError):  # the end of the input, or no input at all
        say()
        return "q"
