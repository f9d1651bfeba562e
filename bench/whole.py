"""The whole job in a process of its own: load a model, synthesise with diagrams, write the guards to a file.

``python -m bench.whole MODEL GUARDS`` prints JSON; MODEL is a CIF file or the tower of :mod:`bench.tower`.
"""

import time

STARTED_S = time.process_time()  # what the interpreter took

import json  # noqa: E402
import sys  # noqa: E402
from pathlib import Path  # noqa: E402

import thenar  # noqa: E402

IMPORTED_S = time.process_time()


def load(name: str) -> thenar.ExtendedProblem:
    if not name.startswith("tower("):
        problem = thenar.load(name)
        assert isinstance(problem, thenar.ExtendedProblem)
        return problem
    from bench.tower import tower

    levels, animals = name[6:-1].split(",")
    return tower(int(levels), int(animals))


def main() -> None:
    name, guards = sys.argv[1:]
    problem = load(name)
    loaded = time.process_time()
    result = thenar.synthesize(problem, "symbolic")
    assert result.symbolic is not None
    states = result.symbolic.n_states
    synthesised = time.process_time()
    Path(guards).write_text(str(thenar.guards(result.symbolic)))
    written = time.process_time()
    # the kernel tells wall seconds of its phases: the CPU seconds are split as they are
    phases = {what: (synthesised - loaded) * s / result.seconds for what, s in result.timings.items()}
    from bench.fresh import peak

    parts = {"start": IMPORTED_S, "interpreter": STARTED_S, "load": loaded - IMPORTED_S, **phases}
    parts["guards"] = written - synthesised
    sizes = {"states": states, "nodes": result.symbolic.controlled.n_nodes, "guards_bytes": Path(guards).stat().st_size}
    print(json.dumps({**sizes, "parts_s": parts, "peak_bytes": peak()}))


if __name__ == "__main__":
    main()
