"""thenar run, scenarios: the supervisor on the simulated hand."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from thenar.cli.common import as_json, load_problem, print_json, say, supervisor_to_run
from thenar.errors import InputError, counted

if TYPE_CHECKING:
    from thenar.hand.episode import Episode
    from thenar.hand.estimates import Estimate
    from thenar.hand.objects import Block
    from thenar.model.automaton import Automaton
    from thenar.model.problem import Problem
    from thenar.model.supervisor import Supervisor

OUTPUTS = ("episode.mcap", "episode.png", "episode.mp4")
OnTick = Callable[[float, "str | None", "str | None"], None]
OnEntry = Callable[[dict[str, Any]], None]


@click.command()
@click.argument("model", metavar="MODEL")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Draws the block and the noise.")
@click.option("--scenario", "scenario_", default="nominal", show_default=True, metavar="NAME", help="What happens.")
@click.option("--variant", metavar="V", help="Variant of the task: paper, extended or timed.")
@click.option(
    "--policy",
    default="shortest",
    show_default=True,
    metavar="P",
    help="shortest, cheapest, priority, random, operator.",
)
@click.option("--sensors", default="lab", show_default=True, metavar="S", help="Sensor profile: ideal, lab, rough.")
@click.option("--hand", default="planar", show_default=True, metavar="H", help="The hand: planar or panda.")
@click.option("--mass", type=float, metavar="KG", help="Mass of the block, instead of the scenario's.")
@click.option("--mu", type=float, metavar="MU", help="Friction of the block, instead of the scenario's.")
@click.option("--stiffness", type=float, metavar="N/M", help="Stiffness of both sides, instead of the scenario's.")
@click.option("--fault", "fault_", metavar="KIND:PART", help="Put a fault in, such as silent:incip_slip.")
@click.option("--out", default="out", show_default=True, metavar="DIR", help="Folder for log, MCAP file and picture.")
@click.option("--video", is_flag=True, help="Also write a video (needs an OpenGL library).")
@click.option("--live", is_flag=True, help="Run at the pace of the real clock.")
@as_json
def run(
    model: str,
    seed: int,
    scenario_: str,
    variant: str | None,
    policy: str,
    sensors: str,
    hand: str,
    fault_: str | None,
    out: str,
    video: bool,
    live: bool,
    json_: bool,
    **own: float | None,
) -> None:
    """Run the supervisor of MODEL on a simulated hand: grasp, lift, squeeze and replace a block.

    Writes log.jsonl (every event, with its reasons), episode.mcap (all channels, for Foxglove and PlotJuggler) and
    episode.png into DIR.  Exits with 1 if the task was not done, or only seemingly.
    """
    from thenar.hand.episode import block_of, log_header, run_episode
    from thenar.hand.faults import fault as fault_named
    from thenar.hand.scenarios import scenario as scenario_named
    from thenar.runtime.clock import RealClock, VirtualClock
    from thenar.runtime.record import LogWriter

    problem = named_problem(model, variant)
    scenario = scenario_named(scenario_)
    fault = None if fault_ is None else fault_named(fault_)
    block = with_own_values(block_of(scenario, seed), own)
    folder = make_folder(out)
    if video:
        from thenar.hand.video import check_video

        check_video()
    supervisor, plant = fit_loop(problem)
    first = log_header(
        supervisor,
        plant,
        problem.name.partition("(")[0],
        variant=variant_of(problem),
        seed=seed,
        scenario=scenario.name,
        sensors=sensors,
        policy=policy,
        hand=hand,
        fault=fault_ or "",
        **{name: value for name, value in own.items() if value is not None},
    )
    try:
        with LogWriter(folder / "log.jsonl", first) as log, watched(policy) as (on_entry, on_tick):
            episode = run_episode(
                supervisor,
                plant,
                block=block,
                scenario=scenario,
                sensors=sensors,
                policy=policy,
                seed=seed,
                hand=hand,
                fault=fault,
                clock=RealClock() if live else VirtualClock(),
                log=log,
                on_entry=on_entry,
                on_tick=on_tick,
            )
    except KeyboardInterrupt:
        clear(folder)
        click.echo(f"thenar: interrupted; the fingers stand still, the log is in {folder / 'log.jsonl'}", err=True)
        raise click.exceptions.Exit(130) from None
    if json_:  # first of all, so that a full disk does not cost the answer
        print_json(episode.to_dict())
    else:
        report(problem, supervisor, scenario.name, episode)
        if fault is not None and episode.run.outcome == "complete":
            say(f"  fault       {fault_} did not come about")
    try:
        files = write_files(folder, episode, first, scenario.name, video)
    except KeyboardInterrupt:
        click.echo(f"thenar: interrupted while writing; the log in {folder / 'log.jsonl'} is whole", err=True)
        raise click.exceptions.Exit(130) from None
    if not json_:
        say(f"  written     {', '.join(['log.jsonl', *files])} in {folder}")
    if not (episode.discrete_success and episode.physical_success):
        raise click.exceptions.Exit(1)


@click.command()
@as_json
def scenarios(json_: bool) -> None:
    """List the scenarios of thenar run, and what each provokes."""
    from thenar.hand.scenarios import SCENARIOS

    if json_:
        print_json(
            [
                {"name": s.name, "says": s.says, "provokes": s.provokes or None, "ends": s.ends, "hole": s.hole}
                for s in SCENARIOS.values()
            ]
        )
        return
    width = max(map(len, SCENARIOS))
    for s in SCENARIOS.values():
        ends = s.ends.replace("_", " ")
        said = f"provokes {s.provokes}, ends: {ends}" if s.provokes else f"ends: {ends}"
        if s.hole:
            said = f"paper: has no word for it, ends: {ends}; extended: provokes {s.provokes}, ends: gave up"
        say(f"{s.name:<{width}}  {s.says}")
        say(f"{'':<{width}}    {said}")


def named_problem(model: str, variant: str | None) -> Problem:
    """Return the problem that MODEL and --variant name."""
    if variant is None:
        return load_problem((model,))
    if model != "glr":
        raise InputError(f"--variant is of the model glr; {model} has none")
    from thenar.library import glr

    return glr.problem(variant)


def variant_of(problem: Problem) -> str:
    """Return the variant that a problem of the library is, as its name says."""
    return problem.name.partition("(")[2].rstrip(")") or "paper"


def with_own_values(block: Block, own: dict[str, float | None]) -> Block:
    """Return ``block`` with what the command line says of it."""
    changes: dict[str, Any] = {}
    if own.get("mass") is not None:
        changes["mass_kg"] = own["mass"]
    if own.get("mu") is not None:
        changes["mu"] = own["mu"]
    if own.get("stiffness") is not None:
        changes |= {"stiffness_1_n_per_m": own["stiffness"], "stiffness_2_n_per_m": own["stiffness"]}
    return replace(block, **changes)


def make_folder(out: str) -> Path:
    """Return the folder of the outputs, made if it is not there."""
    if not out:
        raise InputError("--out '': name a folder")
    folder = Path(out)
    for name in OUTPUTS:
        if (folder / name).is_dir():
            raise InputError(f"{folder / name}: a folder is in the way of the file; give --out another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: cannot be made a folder: {error.strerror}") from None
    if not os.access(folder, os.W_OK):
        raise InputError(f"{out}: cannot be written: no permission")
    return folder


def fit_loop(problem: Problem) -> tuple[Supervisor, Automaton]:
    """Return S and G, S fit to be executed; say why it is not and exit with 1 otherwise."""
    from thenar.explicit.products import sync
    from thenar.hand.skills import SKILLS
    from thenar.synthesis.deploy import fit_to_run

    supervisor, reason = supervisor_to_run(problem, {"max_states": None, "max_seconds": None, "max_bytes": None})
    if supervisor.is_empty:
        say(f"{problem}\n{reason}")
        raise click.exceptions.Exit(1)
    known = supervisor.automaton.alphabet
    commands = [event for event, skill in SKILLS.items() if skill.plan.commit == "command" and event in known]
    plant = sync(*problem.plants, name="G")
    failed = [c for c in fit_to_run(supervisor, plant, commands) if not c]
    if failed:
        for check in failed:
            say(f"not fit to be executed: {check}")
        raise click.exceptions.Exit(1)
    return supervisor, plant


@contextmanager
def watched(policy: str) -> Iterator[tuple[OnEntry | None, OnTick | None]]:
    """Yield callbacks that keep a line on a terminal up to date: time, phase, last event."""
    if policy.strip().startswith("operator") or not sys.stderr.isatty():  # a line that moves disturbs a question
        yield None, None
        return
    from rich.console import Console

    from thenar.hand.phases import phase_after

    phase = phase_after(None)
    with Console(stderr=True).status("") as status:

        def note(entry: dict[str, Any]) -> None:
            nonlocal phase
            if entry["kind"] == "event":
                phase = phase_after(entry["event"], phase)

        def show(time_s: float, last: str | None, running: str | None) -> None:
            now = running or "waits"
            status.update(f"{time_s:6.2f} s   {phase:<13} {now:<24} after {last or 'the start'}   (Ctrl-C stops)")

        yield note, show


def clear(folder: Path) -> None:
    """Remove what an earlier run left beside its log: what lies there belongs together."""
    for name in OUTPUTS:
        (folder / name).unlink(missing_ok=True)


def write_files(folder: Path, episode: Episode, first: dict[str, Any], scenario: str, video: bool) -> list[str]:
    """Write the MCAP file, the picture and, if asked for, the video; return their names."""
    from thenar.hand.mcap_log import write_mcap
    from thenar.hand.picture import save

    clear(folder)
    write_mcap(folder / "episode.mcap", episode, first)
    save(folder / "episode.png", episode, scenario=scenario)
    if not video:
        return ["episode.mcap", "episode.png"]
    from thenar.hand.video import write_video

    write_video(folder / "episode.mp4", episode)
    return ["episode.mcap", "episode.png", "episode.mp4"]


def report(problem: Problem, supervisor: Supervisor, scenario: str, episode: Episode) -> None:
    """Print what a person wants to know at a glance."""
    found, score, block = episode.run, episode.score, episode.block
    pace = found.time_s / episode.wall_s if episode.wall_s else 0.0
    say(f"{problem.name}, scenario {scenario}, seed {episode.seed}: {found.outcome.replace('_', ' ')}")
    say(f"  {found.message}")
    say(f"  supervisor  {supervisor.n_states:,} states; exists, controllable, nonblocking, fit to be executed")
    took = f"{found.time_s:.1f} s simulated in {episode.wall_s:.1f} s ({pace:.0f}x)"
    say(f"  run         {counted(len(found.trace), 'event')}, {took}")
    done = [
        "never dropped" if not score.dropped else "DROPPED",
        f"lifted to within {abs(1e3 * score.lift_error_m):.2f} mm"
        if score.lift_error_m is not None
        else "not lifted to Z",
        f"moved by {1e3 * score.replace_error_m:.2f} mm in all",
    ]
    say(f"  physically  {'success' if score.physical_success else 'FAILED'}: {', '.join(done)}")
    e = episode.estimates
    estimate_line("friction", e.mu, block.mu, "", e.mu_paper)
    estimate_line("weight", e.weight_n, block.weight_n, " N", e.weight_paper_n)
    estimate_line("stiffness", e.stiffness_n_per_m, block.stiffness_n_per_m, " N/m", e.stiffness_paper_n_per_m)
    if score.latency_ms:
        late = (f"{event} {sum(ms) / len(ms):.0f} ms" for event, ms in score.latency_ms.items())
        say(f"  detected    {', '.join(late)} after it happened")
    for violation in found.violations:
        say(f"  VIOLATION   {violation}")


def estimate_line(what: str, found: Estimate | None, truth: float, unit: str, paper: float | None) -> None:
    """Print an estimate beside the truth, and beside the paper's formula."""
    if found is None:
        say(f"  {what:<11} not measured")
        return
    formula = "" if paper is None else f"; by the paper's formula {paper:.4g} ({100 * (paper / truth - 1):+.1f} %)"
    error = f"{100 * (found.value / truth - 1):+.2f} %"
    say(f"  {what:<11} {found}{unit}, in truth {truth:.4g} ({error}){formula}")
