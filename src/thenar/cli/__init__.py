"""The command line: parse, call, print; nothing else.

Exit codes: 0 yes, or done; 1 the property does not hold, or no supervisor exists; 2 bad input; 3 a limit was
reached; 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from errno import EPIPE
from io import TextIOWrapper

import click

from thenar.cli import ask, campaign, look, replay, run, synth
from thenar.cli.convert import convert, formats
from thenar.cli.lint import lint
from thenar.cli.modular import modular
from thenar.cli.reduce import reduce
from thenar.errors import InputError, LimitReached

__all__ = ["cli", "main"]


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="thenar", message="thenar %(version)s")
def cli() -> None:
    """Supervisory control of discrete-event systems: synthesise, explain, certify and run.

    MODEL is a model file (.toml, .json, or another tool's: 'thenar formats' lists them), '-' for standard input, or a
    library model such as glr, agv or 'dining(5)'.  Several models are composed: their plants together, their
    specifications together.

    Exit codes: 0 yes, or done; 1 no; 2 bad input; 3 a limit was reached; 130 interrupted.
    """


for command in (
    synth.synth,
    modular,
    reduce,
    synth.check,
    lint,
    synth.verify,
    ask.explain,
    ask.simulate,
    convert,
    formats,
    look.show,
    look.paper,
    look.doctor,
    run.run,
    run.scenarios,
    campaign.campaign,
    replay.replay,
):
    cli.add_command(command)


def main() -> None:
    """Run the command line; every error that is the user's to mend is one message and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # names may hold what a terminal cannot show
            stream.reconfigure(errors="backslashreplace")
    try:
        # not cli.main(): that takes a reader who leaves a pipe for a failure
        with cli.make_context("thenar", sys.argv[1:]) as context:
            cli.invoke(context)
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.exceptions.Exit as done:
        sys.exit(done.exit_code)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except InputError as error:
        _fail(str(error), 2)
    except LimitReached as error:
        _fail(str(error), 3)
    except MemoryError:
        _fail("out of memory; nothing was written (see --max-states)", 3)
    except (KeyboardInterrupt, click.Abort):
        _fail("interrupted; nothing was written", 130)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is still buffered goes nowhere
        if error.errno != EPIPE:  # the reader of a pipe has seen enough: that is no failure
            _fail(f"cannot write the answer: {error.strerror or error}", 2)
    sys.exit(0)


def _fail(message: str, code: int) -> None:
    click.echo(f"thenar: {message}", err=True)
    sys.exit(code)
