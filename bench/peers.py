"""One supcon of each tool, timed as a whole: from the problem in memory to the supervisor in the tool's own form.

``python -m bench.peers TOOL MODEL PATIENCE`` measures in a process of its own, and prints JSON.
"""

import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterator

from tests.oracles import libfaudes, tct

import thenar
from bench.fresh import peak, rebase
from thenar.model.problem import Problem

Timed = tuple[float, int]  # CPU seconds, states of the supervisor
MOST_RUNS = 20


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
    result = thenar.synthesize(problem, "explicit")
    n_states = result.supervisor.n_states
    return time.process_time() - start, n_states


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


def measure(tool: str, model: str, patience_s: float) -> dict[str, float]:
    """Run once for the memory, then again for up to ``patience_s`` seconds; the CPU seconds are of the quickest."""
    problem, run = thenar.library.model(model), TOOLS[tool]
    run(thenar.library.model("small_factory(1)"))  # what is imported and set up once is not the job
    base = rebase()
    start = time.perf_counter()
    seconds, states = run(problem)
    memory = peak() - base
    runs = [seconds]
    while len(runs) < MOST_RUNS and time.perf_counter() - start + seconds < patience_s:
        runs.append(run(problem)[0])
    return {"states": states, "cpu_s": min(runs), "runs": len(runs), "peak_bytes": memory}


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1], sys.argv[2], float(sys.argv[3]))))
