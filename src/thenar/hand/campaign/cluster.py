"""The episodes of a campaign over a Dask cluster; the only place that knows of Dask."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from importlib import import_module
from typing import Any
from uuid import uuid4

from thenar.errors import InputError, ThenarError
from thenar.hand.campaign.row import Finished, Lost, Task, run_task, versions

__all__ = ["cluster", "connect"]

CONNECT_S = 10.0


def connect(address: str) -> Any:
    """Return a client of the scheduler at ``address``, whose workers have the same versions as we have.

    To be closed.  Raises InputError if Dask is not installed, nobody answers, or a worker has not the same thenar.
    """
    try:
        distributed = import_module("distributed")
    except ImportError:
        raise InputError("a Dask cluster needs dask.distributed: pip install 'thenar[cluster]'") from None
    try:
        client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(f"no Dask scheduler answers at {address}: {error}") from error
    try:
        _check_workers(client, address)
    except BaseException:
        client.close()
        raise
    return client


def _check_workers(client: Any, address: str) -> None:
    try:
        found = client.run(versions)
    except Exception as error:  # whatever the workers' own Python raised
        raise InputError(
            f"the workers of {address} cannot run thenar ({type(error).__name__}: {error}); install it there"
        ) from error
    if not found:
        raise InputError(f"the scheduler at {address} has no workers; start some: dask worker {address}")
    wanted = versions()
    for worker, there in found.items():
        other = [f"{name} {there.get(name)}, not {number}" for name, number in wanted.items() if there[name] != number]
        if other:
            raise InputError(f"worker {worker} has {'; '.join(other)}; install the same versions there")


def cluster(task: Task, episodes: Sequence[int], client: Any) -> Generator[Finished | Lost, None, None]:
    """Run ``episodes`` on the cluster of ``client``, and yield each as it is finished or lost."""
    as_completed = import_module("distributed").as_completed
    shared = client.scatter(task, broadcast=True, hash=False)
    run = uuid4().hex
    futures = {
        client.submit(run_task, shared, k, key=f"thenar-{run}-{k}", pure=False): k for k in episodes
    }  # keys of our own: a result that the cluster still has from before a kill is none of this run
    try:
        for future in as_completed(list(futures), loop=client.loop):
            episode = futures.pop(future)
            error = future.exception()
            if isinstance(error, ThenarError):
                raise error
            yield future.result() if error is None else Lost(episode, f"{type(error).__name__}: {error}")
            future.release()
    finally:
        client.cancel(list(futures))
