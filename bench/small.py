"""Small things: the start, one question, one certificate."""

import resource
import subprocess
import sys
import time
from collections.abc import Callable

from rich.console import Console

import thenar
from thenar.model.automaton import Automaton
from thenar.model.problem import Problem

ASKED_MS = {"import thenar": 150.0}


def small(console: Console) -> dict[str, float]:
    """The times of the main job's parts, in milliseconds of CPU."""
    problem = thenar.library.glr.problem()
    result = thenar.synthesize(problem)
    simulation = "approach_1, approach_2, align_finger2*, prox_make_C1, unstable_contact_1, prox_breakC_1"
    blocked = Problem(
        problem.plants, [*problem.specs, _never("incip_slip*"), _never("apply_loadF*")], alphabet=problem.alphabet
    )
    figures = {
        "import thenar": min([_imported() for _ in range(9)]),
        "GLR: synthesis": _milliseconds(lambda: thenar.synthesize(problem)),
        "GLR: one explanation": _milliseconds(lambda: thenar.explain_disabled(result, "approach_1", after=simulation)),
        "GLR: certificate": _milliseconds(lambda: thenar.certificate(result), 3),
        "GLR made impossible: synthesis": _milliseconds(lambda: thenar.synthesize(blocked)),
        "GLR made impossible: reason": _milliseconds(lambda: thenar.explain_empty(thenar.synthesize(blocked))),
    }
    for what, ms in figures.items():
        asked = f"   asked: < {ASKED_MS[what]:.0f}" if what in ASKED_MS else ""
        console.print(f"{what:<48}{ms:8.2f} ms{asked}")
    return figures


def _imported() -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", "import thenar"], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1000 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def _milliseconds(work: Callable[[], object], repeat: int = 30) -> float:
    times = []
    for _ in range(repeat):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return 1000 * min(times)


def _never(event: str) -> Automaton:
    alphabet = thenar.library.glr.EVENTS
    return Automaton.from_transitions(
        [], initial="q", marked=[], events=alphabet, alphabet=[event], name=f"NEVER_{event}"
    )
