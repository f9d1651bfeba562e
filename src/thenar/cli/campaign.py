"""thenar campaign: many random blocks, one summary."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from thenar.cli.common import as_json, print_json, say
from thenar.cli.run import fit_loop, named_problem, variant_of

if TYPE_CHECKING:
    from thenar.hand.campaign import Campaign
    from thenar.hand.campaign import Progress as Progress_

Watch = Callable[["Progress_"], None]
NAMES = {
    "mu": "friction mu, by element",
    "mu_paper": "  paper: F_t / F_n of the pad *",
    "weight_n": "weight",
    "weight_n_paper": "  paper: 2 mu F_g",
    "stiffness_n_per_m": "stiffness",
    "stiffness_n_per_m_paper": "  paper: dF / dx of fingertips",
}
BIAS = "* it reads low: when the first elements slip, the middle of the pad still sticks, below its friction limit"


@click.command()
@click.argument("model", metavar="MODEL")
@click.option("--episodes", type=click.IntRange(1), default=200, show_default=True, metavar="N", help="How many.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Draws the blocks and the noise.")
@click.option("--workers", type=click.IntRange(1), metavar="K", help="Processes; default: one for each core.")
@click.option("--scheduler", metavar="ADDRESS", help="Run on the Dask cluster of this scheduler instead.")
@click.option("--scenario", default="nominal", show_default=True, metavar="NAME", help="What happens to the block.")
@click.option("--variant", metavar="V", help="Variant of the task: paper, extended or timed.")
@click.option("--policy", default="shortest", show_default=True, metavar="P", help="shortest, priority or random.")
@click.option("--sensors", default="lab", show_default=True, metavar="S", help="Sensor profile: ideal, lab, rough.")
@click.option("--hand", default="planar", show_default=True, metavar="H", help="The hand.")
@click.option("--out", metavar="DIR", help="Folder of the results; default: campaign-MODEL-VARIANT-SEED.")
@as_json
def campaign(
    model: str, episodes: int, seed: int, variant: str | None, out: str | None, json_: bool, **options: Any
) -> None:
    """Run MODEL's supervisor on N random blocks, and sum up how it went and how good the estimates are.

    DIR gets campaign.sqlite (a row an episode, as it finishes), campaign.png (the errors) and logs/SEED.jsonl (for
    thenar replay).  The same command again goes on where the last one stopped; a larger N adds episodes.
    thenar run MODEL --seed SEED shows any of them alone.

    Exits with 1 if an episode could not be done; one that failed physically is a result, not an error.
    """
    from thenar.hand.campaign import read_rows, run_campaign
    from thenar.hand.campaign.picture import draw_errors
    from thenar.io.files import atomic_write

    problem = named_problem(model, variant)
    task, which = model.partition("(")[0], variant_of(problem)
    folder = out or f"campaign-{task}-{which}-{seed}"
    supervisor, plant = fit_loop(problem)
    try:
        with _watched() as on_progress:
            found = run_campaign(
                supervisor,
                plant,
                episodes=episodes,
                seed=seed,
                out=folder,
                task=task,
                variant=which,
                on_progress=on_progress,
                **options,
            )
    except KeyboardInterrupt:
        file = Path(folder, "campaign.sqlite")
        done = sum(row.episode <= episodes for row in read_rows(file)) if file.exists() else 0
        kept = f"{done} of {episodes} episodes are done and kept in {folder}"
        click.echo(f"thenar: interrupted: {kept}; the same command goes on from there", err=True)
        raise click.exceptions.Exit(130) from None
    atomic_write(found.folder / "campaign.png", draw_errors(found.rows))
    if json_:
        print_json(found.to_dict())
    else:
        report(found)
    if found.missing:
        click.echo(_missing(found), err=True)
        raise click.exceptions.Exit(1)


@contextmanager
def _watched() -> Iterator[Watch]:
    """Yield what is called with each episode: it moves a bar on a terminal, and says at once what is lost."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        BarColumn(16),
        MofNCompleteColumn(),
        TextColumn("{task.description}"),
        TimeRemainingColumn(),
        TextColumn("(Ctrl-C stops)"),
    )
    console = Console(stderr=True)
    with Progress(*columns, console=console, disable=not sys.stderr.isatty(), transient=True) as bar:
        line = bar.add_task("")

        def show(now: Progress_) -> None:
            if now.lost is not None:
                click.echo(f"thenar: episode {now.lost.episode} is not done: {now.lost.why}", err=True)
            says = f"physical {now.physical_success}, discrete {now.discrete_success}"
            bar.update(line, total=now.episodes, completed=now.done, description=says)

        yield show


def report(found: Campaign) -> None:
    """Print what a person wants to know at a glance."""
    s, what = found.to_dict(), found.configuration
    n = s["episodes"]
    say(
        f"{what['task']} ({what['variant']}), seed {what['seed']}, scenario {what['scenario']}, "
        f"sensors {what['sensors']}, policy {what['policy']}, hand {what['hand']}"
    )
    if not n:
        return
    dropped = f"; {s['dropped']} dropped" if s["dropped"] else ""
    say(f"  physically   {s['physical_success']} of {n} succeeded{dropped}")
    say(f"  by events    {s['discrete_success']} of {n} complete; {len(s['disagreements'])} disagree with the physics")
    say(f"  logs         {s['accepted_by_plant']} of {n} accepted by G, {s['accepted_by_supervisor']} by S/G")
    say(f"  disabled     controllable events executed while disabled: {s['executed_while_disabled']}")
    if s["violations"] or s["log_differences"]:
        say(
            f"  VIOLATIONS   {s['violations']} found by the runs, {s['log_differences']} states that replay differently"
        )
    for failure in s["failures"]:
        agree = "" if failure["discrete_success"] == failure["physical_success"] else "DISAGREE  "
        outcome = failure["outcome"].replace("_", " ")
        say(f"  seed {failure['seed']}  {agree}{outcome}: {failure['message']}; physically: {failure['physically']}")
    say()
    say(f"  {'relative error, %':<32}{'rms':>8}{'mean':>8}{'max':>8}{'n':>6}   within 2 u")
    for name, title in NAMES.items():
        e = s["errors"][name]
        if not e["n"]:
            continue
        numbers = "".join(f"{100 * e[k]:>8.2f}" for k in ("rms", "mean", "max"))
        covered = f"{100 * e['within_2u']:>9.0f} %" if e.get("within_2u") is not None else ""
        say(f"  {title:<32}{numbers}{e['n']:>6}{covered}")
    say(f"  {BIAS}")
    say()
    say(f"  {'reported after it happened, ms':<32}{'':>8}{'mean':>8}{'max':>8}{'n':>6}")
    for event, delay in s["latency_ms"].items():
        say(f"  {event:<32}{'':>8}{delay['mean']:>8.1f}{delay['max']:>8.1f}{delay['n']:>6}")
    lift = "-" if s["max_lift_error_mm"] is None else f"{s['max_lift_error_mm']:.2f}"
    say()
    say(f"  at worst     {s['max_slip_before_detection_mm']:.3f} mm slip before it is detected")
    say(f"               {lift} mm off Z when lifted, {s['max_replace_error_mm']:.2f} mm off its place in the end")
    pace = f"{s['real_time_factor']:.1f}x real time a core"
    say(f"  speed        {s['sim_s']:.0f} s simulated in {s['wall_s']:.0f} s of the workers' time: {pace}")
    say(f"  written      campaign.sqlite, campaign.png, logs in {found.folder}")


def _missing(found: Campaign) -> str:
    missing = found.missing
    shown = ", ".join(map(str, missing[:10])) + (", ..." if len(missing) > 10 else "")
    return (
        f"thenar: {len(missing)} of {found.episodes} episodes are not done ({shown}); the same command tries them again"
    )
