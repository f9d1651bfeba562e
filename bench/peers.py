"""One supcon of each tool, timed as a whole: from the problem in memory to the supervisor in the tool's own form."""

import contextlib
import os
import time
from collections.abc import Callable, Iterator

from tests.oracles import libfaudes, tct

import thenar
from thenar.model.problem import Problem

Timed = tuple[float, int]  # CPU seconds, states of the supervisor


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Swallow what a peer prints from C."""
    saved = os.dup(1)
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    try:
        yield
    finally:
        os.dup2(saved, 1)
        os.close(saved)
        os.close(null)


def time_thenar(problem: Problem) -> Timed:
    start = time.process_time()
    result = thenar.synthesize(problem)
    return time.process_time() - start, result.supervisor.n_states


def time_tct(problem: Problem) -> Timed:
    with quiet(), tct.session(*problem.automata) as session:
        start = time.process_time()
        supervisor = session.do("supcon", session.plant(list(problem.plants)), session.legal(list(problem.specs)))
        seconds = time.process_time() - start
        return seconds, int(session.tct.statenum(supervisor))


def time_faudes(problem: Problem) -> Timed:
    alphabet = problem.alphabet
    with quiet():
        import faudes  # greets on import

        start = time.process_time()
        controllable = libfaudes.event_set(e.name for e in alphabet if e.controllable)
        plants, specs = (libfaudes.lifted(list(group), alphabet) for group in (problem.plants, problem.specs))
        result = libfaudes.library().Generator()
        faudes.SupCon(plants, controllable, specs, result)
        seconds = time.process_time() - start
        return seconds, int(result.Size())


TOOLS: dict[str, Callable[[Problem], Timed]] = {"thenar": time_thenar, "TCT": time_tct, "libFAUDES": time_faudes}


def best(tool: Callable[[Problem], Timed], problem: Problem, patience_s: float = 2.0) -> Timed:
    """Repeat for a while (at least once, at most 20 times) and return the quickest run."""
    runs = [tool(problem)]
    start = time.perf_counter()
    while len(runs) < 20 and time.perf_counter() - start + runs[0][0] < patience_s:
        runs.append(tool(problem))
    return min(runs)
