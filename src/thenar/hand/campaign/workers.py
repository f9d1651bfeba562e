"""The episodes of a campaign over processes of this machine."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Generator, Sequence
from multiprocessing.connection import Connection, Pipe, wait
from types import FrameType

from thenar.errors import ThenarError
from thenar.hand.campaign.row import Finished, Lost, Task, run_task

__all__ = ["here", "processes"]

Outcome = Finished | Lost
Outcomes = Generator[Outcome, None, None]
GOING_S = 0.3  # how long a worker may take to leave when asked; then it is made to
# an episode is one core's work: linear algebra with threads of its own would only get in the way of the others
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM")}


def here(task: Task, episodes: Sequence[int]) -> Outcomes:
    """Run ``episodes`` one after the other in this process."""
    for k in episodes:
        yield _outcome(task, k)


def processes(task: Task, episodes: Sequence[int], workers: int) -> Outcomes:
    """Run ``episodes`` over ``workers`` processes, and yield each as it is finished or lost.

    A worker that dies takes one episode with it, which is named; another takes its place.  After ``workers`` + 2
    such losses without a success in between nothing more is tried.  Closing the iterator ends the workers at once.
    """
    waiting, payload = deque(episodes), pickle.dumps(task, protocol=pickle.HIGHEST_PROTOCOL)
    team: dict[Connection, _Worker] = {}
    lost_in_a_row = 0
    try:
        for _ in range(min(workers, len(waiting))):
            worker = _Worker()
            team[worker.pipe] = worker
        for worker in team.values():
            worker.begin(payload, waiting.popleft())
        while team:
            for pipe in wait(list(team)):
                assert isinstance(pipe, Connection)
                worker = team[pipe]
                outcome = worker.outcome()
                died = worker.process.returncode is not None
                lost_in_a_row = lost_in_a_row + 1 if isinstance(outcome, Lost) else 0
                if lost_in_a_row >= workers + 2:
                    waiting.clear()
                if died or not waiting:
                    worker.end()
                    del team[pipe]
                if waiting:
                    if died:
                        worker = _Worker()
                        team[worker.pipe] = worker
                        worker.begin(payload, waiting.popleft())
                    else:
                        worker.give(waiting.popleft())
                yield outcome
    finally:
        for worker in team.values():
            worker.process.terminate()
        deadline_s = time.monotonic() + GOING_S
        for worker in team.values():
            worker.end(max(0.0, deadline_s - time.monotonic()))


class _Worker:
    """A process of ours that runs one episode after the other; its own session, so that Ctrl-C is our affair."""

    def __init__(self) -> None:
        self.pipe, theirs = Pipe()
        with theirs:
            handle = theirs.fileno()
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-c", f"import {__name__} as w; w.work({handle})"],
                pass_fds=[handle],
                env={**os.environ, **ONE_THREAD},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
            )
        self.episode = 0

    def begin(self, payload: bytes, episode: int) -> None:
        """Hand over the task, and the first episode."""
        self.episode = episode
        try:
            self.pipe.send_bytes(payload)
        except OSError:
            return  # it has died already: outcome() says so
        self.give(episode)

    def give(self, episode: int) -> None:
        """Hand over the next episode."""
        self.episode = episode
        try:
            self.pipe.send(episode)
        except OSError:
            return

    def outcome(self) -> Outcome:
        """Return what has become of the episode; raises what the worker raised, if that was the user's to mend."""
        try:
            reply = self.pipe.recv()
        except (EOFError, OSError):
            return Lost(self.episode, _how(self.process.wait()))
        if isinstance(reply, ThenarError):
            raise reply
        assert isinstance(reply, Finished | Lost)
        return reply

    def end(self, within_s: float = GOING_S) -> None:
        """Make the process leave."""
        self.pipe.close()
        try:
            self.process.wait(within_s)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def _how(code: int) -> str:
    """Return how a process died, in words."""
    if code >= 0:
        return f"its process ended with exit code {code}"
    hint = " (out of memory?)" if -code == signal.SIGKILL else ""
    return f"its process was killed by {signal.Signals(-code).name}{hint}"


def _outcome(task: Task, episode: int) -> Outcome:
    try:
        return run_task(task, episode)
    except ThenarError:
        raise
    except Exception as error:
        return Lost(episode, f"{type(error).__name__}: {error}")


def _leave(number: int, frame: FrameType | None) -> None:
    raise SystemExit(0)


def work(handle: int) -> None:
    """Be a worker: take the task, then episodes, until nobody is there to give any."""
    signal.signal(signal.SIGTERM, _leave)  # with its temporary files
    with Connection(handle) as pipe:
        try:
            task: Task = pickle.loads(pipe.recv_bytes())
            while True:
                episode: int = pipe.recv()
                try:
                    reply: Outcome | ThenarError = _outcome(task, episode)
                except ThenarError as error:
                    reply = error
                pipe.send(reply)
        except (EOFError, OSError):  # the one who gave the work has gone
            return
