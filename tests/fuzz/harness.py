"""What must hold for every file, and the process in which libFuzzer looks for one for which it does not hold."""

from __future__ import annotations

import gc
import sys
from contextlib import suppress
from importlib import import_module
from types import FunctionType
from typing import Any

from tests.fuzz.seeds import small_seeds

from thenar.errors import InputError
from thenar.io import dumps, loads
from thenar.io.formats import format_named
from thenar.model.extended import ExtendedProblem
from thenar.model.problem import Problem

__all__ = ["check", "main", "read"]

SOURCE = "hostile"
COVERED = ("thenar.io", "thenar.model")  # whose branches guide the fuzzer


def read(data: bytes, format: str) -> Problem | ExtendedProblem | None:
    """Return what ``data`` says, or None if it is refused: with InputError, in a message that names the file."""
    try:
        return loads(data, format, SOURCE)
    except InputError as error:
        if SOURCE not in str(error):
            raise AssertionError(f"the message does not name the file: {error}") from error
        return None


def check(data: bytes, format: str) -> None:
    """Read ``data``; what it says can be written as JSON, or is refused with InputError."""
    if (model := read(data, format)) is not None:
        with suppress(InputError):
            dumps(model, "json")


def main(arguments: list[str]) -> None:
    """Fuzz the format that the first argument names; the others are libFuzzer's."""
    atheris: Any = import_module("atheris")  # needed here only
    format = format_named(arguments[0])
    for seed in small_seeds(format):  # imports what is imported when it is needed
        check(seed, format.name)
    # not instrument_imports: it does not reach the modules of an editable package
    for function in [f for f in gc.get_objects() if isinstance(f, FunctionType)]:
        if str(function.__module__).startswith(COVERED):
            atheris.instrument_func(function)
    atheris.Setup([sys.argv[0], *arguments[1:]], lambda data: check(data, format.name))
    atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1:])
