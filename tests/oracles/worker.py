"""A process of its own for each peer: they print, leak memory, keep global state, and may crash."""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from functools import wraps
from importlib import import_module
from importlib.util import find_spec
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import pytest

P = ParamSpec("P")
R = TypeVar("R")

ROOT = Path(__file__).parents[2]
TIMEOUT_S = 300.0


class PeerError(RuntimeError):
    """A peer refused a call, crashed, or did not answer."""


def isolate(package: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator that runs a function where ``package`` can do no harm: in the process of its module.

    The process is started at the first call; where the package is not installed that call skips the test.  A
    function with this decorator must not call another one.
    """

    def isolated(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            if find_spec(package) is None:
                pytest.skip(f"the peer is not installed: pip install {package}")
            module = function.__module__
            if module not in _workers:
                _workers[module] = _Worker(module)
            try:
                answered, answer = _workers[module].call(function.__name__, args, kwargs)
            except (EOFError, OSError) as error:
                _workers.pop(module).stop()  # the next call gets a new one
                raise PeerError(f"{module}.{function.__name__} crashed or hung: {error!r}") from None
            if not answered:
                raise PeerError(f"{module}.{function.__name__}: {answer}")
            result: R = answer
            return result

        return call

    return isolated


class _Worker:
    """The process that serves one module, seen from here."""

    def __init__(self, module: str) -> None:
        self._connection, far_end = Pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-c", f"from {__name__} import serve; serve({far_end.fileno()}, {module!r})"],
            env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
            pass_fds=[far_end.fileno()],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        far_end.close()

    def call(self, *request: Any) -> tuple[bool, Any]:
        self._connection.send(request)
        if not self._connection.poll(TIMEOUT_S):
            raise TimeoutError(f"no answer within {TIMEOUT_S:.0f} s")
        answer: tuple[bool, Any] = self._connection.recv()
        return answer

    def stop(self) -> None:
        self._connection.close()
        self._process.kill()
        self._process.wait()


_workers: dict[str, _Worker] = {}


@atexit.register
def stop_all() -> None:
    while _workers:
        _workers.popitem()[1].stop()


def serve(fileno: int, module: str) -> None:
    """Answer calls until the other end hangs up; the main loop of a worker."""
    warnings.simplefilter("ignore")  # the peers' own
    functions = import_module(module)
    connection = Connection(fileno)
    while True:
        try:
            name, args, kwargs = connection.recv()
        except EOFError:
            return
        try:
            answer = (True, getattr(functions, name).__wrapped__(*args, **kwargs))
        except Exception as error:
            answer = (False, repr(error))
        connection.send(answer)
