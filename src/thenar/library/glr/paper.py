"""The paper's published results, each beside what the library computes for it at this moment.

Source: *A Discrete-Event Systems Approach to Modeling Dexterous Manipulation*, sections 5 and 6.  Its automata
are lost; a row whose published figure the reconstruction is known not to reach has the status ``open``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from thenar.explicit.control import supcon
from thenar.explicit.language import is_sublanguage
from thenar.explicit.products import meet, sync
from thenar.library import glr
from thenar.model.automaton import Automaton
from thenar.model.trace import Trace
from thenar.synthesis.api import synthesize
from thenar.synthesis.simulate import Step, simulate

__all__ = ["SIMULATIONS", "Row", "Simulation", "results", "simulations"]


@dataclass(frozen=True, slots=True)
class Row:
    """One published result: ``status`` is ``"exact"`` if the reconstruction must reach it, else ``"open"``."""

    what: str
    published: str
    computed: str
    status: str

    @property
    def match(self) -> bool:
        """Whether the computed result is the published one."""
        return self.published == self.computed


@dataclass(frozen=True, slots=True)
class Simulation:
    """A simulation of section 6: the events offered, and the lines printed, as (event, status, state)."""

    title: str
    trace: Trace
    published: tuple[tuple[str, str, int], ...]


def _printed(*lines: str) -> tuple[tuple[str, str, int], ...]:
    fields = (line.split() for line in lines)
    return tuple((event, status, int(state)) for event, status, state in fields)


SIMULATIONS = (
    Simulation(
        "6.1 Problems aligning the fingers",
        Trace(["approach_1", "approach_2", *["detect_misalignment*", "re-align_with_finger1*"] * 3]),
        _printed(
            "approach_1 enabled 0",
            "approach_2 disabled 0",
            "approach_2 enabled 1",
            "detect_misalignment* enabled 2",
            "re-align_with_finger1* enabled 6",
            "detect_misalignment* enabled 12",
            "re-align_with_finger1* enabled 24",
            "detect_misalignment* enabled 42",
            "re-align_with_finger1* disabled 69",
        ),
    ),
    Simulation(
        "6.2 Problems lifting the block",
        Trace(
            "approach_1, approach_2, align_finger2*, prox_make_C1, prox_make_C2, suppress_vib1, suppress_vib2, "
            "orient_normal1, orient_normal2, apply_gripF*, apply_loadF*, "
            "incip_slip*, inc_gripF*, incip_slip*, inc_gripF*, incip_slip*, inc_gripF*"
        ),
        _printed(
            "approach_1 enabled 0",
            "approach_2 disabled 0",
            "approach_2 enabled 1",
            "align_finger2* enabled 2",
            "prox_make_C1 enabled 3",
            "prox_make_C2 enabled 8",
            "suppress_vib1 enabled 17",
            "suppress_vib2 enabled 29",
            "orient_normal1 enabled 49",
            "orient_normal2 enabled 73",
            "apply_gripF* enabled 106",
            "apply_loadF* enabled 147",
            "incip_slip* enabled 194",
            "inc_gripF* enabled 248",
            "incip_slip* enabled 313",
            "inc_gripF* enabled 390",
            "incip_slip* enabled 472",
            "inc_gripF* disabled 564",
        ),
    ),
)

TRY = Trace("approach_1, approach_2, align_finger2*, prox_make_C1")  # the paper's s
FAIL = Trace("unstable_contact_1, prox_breakC_1")
S_PRIME = Trace([*(*TRY, *FAIL) * 3, *TRY])
# FINGER2 is still aligned when finger 1 breaks contact, so it has to retract before it can approach again;
# the paper's string leaves that out.
S_PRIME_IN_FULL = Trace([*(*TRY, *FAIL, "retract_finger_2") * 3, *TRY])
SIGMA = "unstable_contact_1"


def results() -> list[Row]:
    """Compute every published result with the library's own operations.

    >>> [row.what for row in results() if row.status == "exact" and not row.match]
    []
    """
    problem = glr.problem()
    G, E = sync(*problem.plants, name="G"), glr.legal()
    K = supcon(G, E)
    free = sum(not e.controllable for e in problem.alphabet)
    rows = [
        Row("events (uncontrollable)", "28 (6)", f"{len(problem.alphabet)} ({free})", "exact"),
        Row("G = FINGER1 || FINGER2: states / transitions", "90 / 242", _size(G), "exact"),
        Row("G: marker states", "2", str(int(G.marked.sum())), "exact"),
        Row("legal language E: states / transitions", "1412 / 13724", _size(E), "open"),
        Row("supC(E, G): states / transitions", "1318 / 2684", _size(K), "open"),
        Row("A is within supC(E, G)", "yes", _yes(bool(is_sublanguage(glr.adequate(), K))), "exact"),
        Row("supC(E, G) differs from E", "yes", _yes(not is_sublanguage(meet(G, E), K)), "exact"),
        Row(
            "s' is legal, s'σ is in L(G) but not legal; s' is prevented",
            "yes",
            _s_prime(S_PRIME_IN_FULL, G, E, K),
            "exact",
        ),
        Row("... and so for s' as printed, without retract_finger_2", "yes", _s_prime(S_PRIME, G, E, K), "open"),
    ]
    for simulation, steps in zip(SIMULATIONS, simulations(), strict=True):
        lines = [status for step in steps for status in step.statuses]
        short = simulation.title.split()[0]
        published = [f"{event} {status}" for event, status, _ in simulation.published]
        computed = [f"{s.event} {s.status}" for s in lines]
        rows.append(Row(f"simulation {short}: what is enabled and disabled", *_verdicts(published, computed), "exact"))
        numbers = " ".join(dict.fromkeys(str(state) for *_, state in simulation.published))
        mine = " ".join(dict.fromkeys(str(s.state) for s in lines))
        rows.append(Row(f"simulation {short}: state numbers", numbers, mine, "open"))
    return rows


def simulations() -> list[list[Step]]:
    """Run the simulations of section 6 on the synthesised supervisor."""
    supervisor = synthesize(glr.problem()).supervisor
    return [simulate(supervisor, simulation.trace) for simulation in SIMULATIONS]


def _size(automaton: Automaton) -> str:
    return f"{automaton.n_states} / {automaton.n_transitions}"


def _yes(holds: bool) -> str:
    return "yes" if holds else "no"


def _s_prime(s: Trace, G: Automaton, E: Automaton, K: Automaton) -> str:
    """Check the paper's claims about its string s' one by one, and name the first that fails."""
    claims: list[tuple[str, Callable[[], bool]]] = [
        (f"s' is not in L(G): it ends after {len(G.run(s)) - 1} of {len(s)} events", lambda: G.generates(s)),
        ("s' is not legal", lambda: E.generates(s)),
        ("s'σ is not in L(G)", lambda: G.generates([*s, SIGMA])),
        ("s'σ is legal", lambda: not E.generates([*s, SIGMA])),
        ("s' is not prevented", lambda: not K.generates(s)),
    ]
    return next((f"no: {failure}" for failure, holds in claims if not holds()), "yes")


def _verdicts(published: list[str], computed: list[str]) -> tuple[str, str]:
    """Return both lists of lines as short texts that are equal exactly if the lists are."""
    summary = f"{len(published)} lines, the last: {published[-1]}"
    if published == computed:
        return summary, summary
    k = next(
        (k for k, (p, c) in enumerate(zip(published, computed, strict=False)) if p != c),
        min(len(published), len(computed)),
    )
    there = computed[k] if k < len(computed) else "nothing more"
    return summary, f"{len(computed)} lines; line {k + 1} is {there}"
