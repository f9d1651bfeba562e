"""A certificate made of diagrams is accepted exactly if what it claims is so; a slow twin of the checker decides."""

import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import thenar
from thenar.errors import CertificateError, InputError
from thenar.model.problem import Problem
from thenar.symbolic.synthesis import Removal, SymbolicSupervisor
from thenar.synthesis.api import SynthesisResult
from thenar.synthesis.certificate import pack, statement
from thenar.synthesis.proof.container import read
from thenar.synthesis.verify import Verdict
from thenar.testing.random_models import random_extended_problem, random_problem

BATCH = 50
State = tuple[int, ...]
States = frozenset[State]
PROVED = "controllable, nonblocking, within the specifications and largest"


class Claim(NamedTuple):
    """What a certificate claims, state by state."""

    K: States
    rounds: list[tuple[str, States, States]]


class Product:
    """What a problem's automata do, found out state by state and kept."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.initial = tuple(a.initial for a in problem.automata)
        self.moves = [
            {(q, a.alphabet[e].name): t for q in range(a.n_states) for e, t in a.row(q)} for a in problem.automata
        ]
        self.known: dict[State, list[tuple[str, bool, State | None]]] = {}

    def marked(self, state: State) -> bool:
        return all(a.marked[q] for a, q in zip(self.problem.automata, state, strict=True))

    def steps(self, state: State) -> list[tuple[str, bool, State | None]]:
        """Events that the plants can do: name, whether uncontrollable, and the state reached; None if forbidden."""
        if state not in self.known:
            self.known[state] = list(self._steps(state))
        return self.known[state]

    def _steps(self, state: State) -> Iterator[tuple[str, bool, State | None]]:
        n_plants = len(self.problem.plants)
        for event in self.problem.alphabet:
            owners = [k for k, a in enumerate(self.problem.automata) if event.name in a.alphabet]
            lacking = [k for k in owners if (state[k], event.name) not in self.moves[k]]
            if not owners or any(k < n_plants for k in lacking):
                continue
            after = None
            if not lacking:
                after = tuple(self.moves[k][q, event.name] if k in owners else q for k, q in enumerate(state))
            yield event.name, not event.controllable, after

    def breaks(self, state: State) -> bool:
        return any(free and after is None for _, free, after in self.steps(state))

    def after(self, state: State, *, free_only: bool = False) -> set[State]:
        return {after for _, free, after in self.steps(state) if after is not None and (free or not free_only)}

    def backward(self, goal: States, within: States, *, free_only: bool = False) -> set[State]:
        found = set(goal & within)
        while more := {q for q in within - found if self.after(q, free_only=free_only) & found}:
            found |= more
        return found


def wrong_with(product: Product, claim: Claim) -> str:
    """Return how the checker's complaint about ``claim`` begins; empty if all of it is so."""
    gone: set[State] = set()
    for reason, seeds, states in claim.rounds:
        if reason == "illegal":
            fine = all(product.breaks(q) for q in seeds)
        else:
            fine = not any(product.marked(q) or product.after(q) - seeds - gone for q in seeds)
        if not (fine and seeds <= states == product.backward(seeds, states, free_only=True)):
            return "not largest"
        gone |= states
    K = claim.K
    if not K:
        return "" if product.initial in gone else "not largest"
    if product.initial not in K:
        return "the supervisor does not begin in the initial state"
    if any(product.breaks(q) for q in K):
        return "not within the specifications"
    if any(product.after(q, free_only=True) - K for q in K):
        return "not controllable"
    if any(product.after(q) - K - gone for q in K):
        return "not largest"
    if product.backward(frozenset(q for q in K if product.marked(q)), K) != K:
        return "not nonblocking"
    ahead, seen = [product.initial], {product.initial}
    while ahead:
        new = product.after(ahead.pop()) & K - seen
        seen |= new
        ahead += new
    return "" if seen == K else "the supervisor has"


def claimed(supervisor: SymbolicSupervisor) -> Claim:
    order = supervisor.encoding.order

    def listed(states: Any) -> States:
        by_level = states.vectors(1 << 20).reshape(-1, len(order))
        rows = np.empty_like(by_level)
        rows[:, order] = by_level
        return frozenset(map(tuple, rows.tolist()))

    return Claim(
        listed(supervisor.controlled), [(r.reason, listed(r.seeds), listed(r.states)) for r in supervisor.removals]
    )


def symbolic(problem: Problem) -> tuple[SynthesisResult, SymbolicSupervisor]:
    result = thenar.synthesize(problem, "symbolic")
    assert result.symbolic is not None
    return result, result.symbolic


def checked(path: Path, result: SynthesisResult, about: Problem | None = None) -> Verdict:
    path.write_bytes(thenar.certificate(result))
    return thenar.verify(path, None if about is None else statement(about))


@pytest.mark.parametrize("seeds", [range(k, k + BATCH) for k in range(0, 400, BATCH)], ids=str)
def test_every_result_is_certified_empty_or_not(tmp_path: Path, seeds: range) -> None:
    empty = 0
    for seed in seeds:
        problem = random_problem(random.Random(seed))
        result, supervisor = symbolic(problem)
        verdict = checked(tmp_path / "one.cert", result, problem)
        assert verdict, verdict.reason
        assert (verdict.states, verdict.transitions) == result.size
        assert verdict.reason == ("no supervisor exists" if supervisor.is_empty else PROVED)
        removed = frozenset[State]().union(*(states for _, _, states in claimed(supervisor).rounds))
        assert verdict.checked == len(claimed(supervisor).K | removed)
        empty += supervisor.is_empty
    assert empty


def forgeries(supervisor: SymbolicSupervisor, rng: random.Random) -> Iterator[tuple[str, Any, list[Removal]]]:
    """Yield what is forged, K and the rounds; what is put into a set is any state of the product."""
    K, rounds, forest = supervisor.controlled, list(supervisor.removals), supervisor.encoding.forest

    def one_of(states: Any) -> Any:
        rows = states.vectors(4096).reshape(-1, len(supervisor.encoding.order))
        row = np.empty(rows.shape[1], np.int64)
        row[supervisor.encoding.order] = rows[rng.randrange(len(rows))]
        return supervisor.encoding.only(row.tolist())

    def less(states: Any) -> Any:
        return states - one_of(states) if states else states

    def more(states: Any) -> Any:
        return states | one_of(~states) if ~states else states

    yield "a state fewer", less(K), rounds
    yield "a state more", more(K), rounds
    yield "all that can be reached", supervisor.reachable, rounds
    yield "all that survives", supervisor.safe, rounds
    yield "nothing", forest.nothing, rounds
    yield "no round", K, []
    for k, r in enumerate(rounds):

        def instead(*new: Removal, k: int = k) -> list[Removal]:
            return [*rounds[:k], *new, *rounds[k + 1 :]]

        yield "a removed state more", K | one_of(r.states), rounds
        yield "a dropped round", K, instead()
        yield "a round twice", K, instead(r, r)
        yield "another reason", K, instead(r._replace(reason="blocking" if r.reason == "illegal" else "illegal"))
        yield "a seed fewer", K, instead(r._replace(seeds=less(r.seeds)))
        yield "a seed more", K, instead(r._replace(seeds=more(r.seeds)))
        seed = one_of(~r.seeds) if ~r.seeds else forest.nothing
        yield "a seed removed too", K, instead(r._replace(seeds=r.seeds | seed, states=r.states | seed))
        yield "all are seeds", K, instead(r._replace(seeds=r.states))
        yield "other seeds", K, instead(r._replace(seeds=r.states - r.seeds))
        yield "a removal fewer", K, instead(r._replace(states=less(r.states)))
        yield "a removal more", K, instead(r._replace(states=more(r.states)))
        yield "K is removed too", K - r.states, instead(r._replace(states=r.states | K))
        if k:
            swapped = rounds.copy()
            swapped[k - 1], swapped[k] = swapped[k], swapped[k - 1]
            yield "swapped rounds", K, swapped


@pytest.mark.parametrize("seeds", [range(k, k + BATCH) for k in range(0, 300, BATCH)], ids=str)
def test_a_forged_certificate_is_rejected_for_what_is_wrong_with_it(tmp_path: Path, seeds: range) -> None:
    """A claim about K is never accepted unless K is right; rounds may be others, if they are true."""
    rejected: dict[str, int] = {}
    for seed in seeds:
        rng = random.Random(seed)
        result, supervisor = symbolic(random_problem(rng))
        product = Product(result.plain)
        for what, K, rounds in forgeries(supervisor, rng):
            forged = SymbolicSupervisor(supervisor.encoding, supervisor.reachable, supervisor.safe, K, rounds)
            verdict = checked(tmp_path / "lie.cert", replace(result, symbolic=forged))
            truth = wrong_with(product, claimed(forged))
            assert bool(verdict) == (not truth), f"{seed}, {what}: {verdict.reason}, but really: {truth}"
            assert verdict.reason.startswith(truth)
            assert not verdict or supervisor.controlled == K
            rejected[what] = rejected.get(what, 0) + (not verdict)
    assert sum(rejected.values()) > 100
    assert {
        "a state fewer",
        "a state more",
        "all that survives",
        "another reason",
        "a dropped round",
        "a removal more",
    } <= {what for what, times in rejected.items() if times}


def test_what_is_true_of_another_problem_is_no_proof(tmp_path: Path) -> None:
    """Say the sets of one problem of a second, where an event changed sides, or an automaton lost a transition."""
    rejected = 0
    for seed in range(150):
        rng = random.Random(seed)
        problem = random_problem(rng)
        result, supervisor = symbolic(problem)
        (tmp_path / "true.cert").write_bytes(thenar.certificate(result))
        arrays, header = read(tmp_path / "true.cert")
        if seed % 2:
            event = rng.choice(header["events"])
            event["controllable"] = not event["controllable"]
        else:
            k = rng.randrange(len(problem.automata))
            if not len(arrays[f"events_{k}"]):
                continue
            lost = rng.randrange(len(arrays[f"events_{k}"]))
            for name in ("events", "targets"):
                arrays[f"{name}_{k}"] = np.delete(arrays[f"{name}_{k}"], lost)
            arrays[f"offsets_{k}"] = arrays[f"offsets_{k}"] - (arrays[f"offsets_{k}"] > lost)
        (tmp_path / "lie.cert").write_bytes(pack(arrays, header))
        truth = wrong_with(Product(stated(arrays, header)), claimed(supervisor))
        verdict = thenar.verify(tmp_path / "lie.cert")
        assert bool(verdict) == (not truth)
        assert verdict.reason.startswith(truth)
        about = thenar.verify(tmp_path / "lie.cert", statement(problem))
        assert about.reason == "the certificate is about another problem"
        rejected += not verdict
    assert rejected > 50


def stated(arrays: dict[str, Any], header: dict[str, Any]) -> Problem:
    """Return the problem that a certificate states."""
    events = [thenar.Event(e["name"], controllable=e["controllable"]) for e in header["events"]]
    automata: dict[str, list[thenar.Automaton]] = {"plant": [], "spec": []}
    for k, a in enumerate(header["automata"]):
        own = np.flatnonzero(arrays[f"own_{k}"])
        automata[a["kind"]].append(
            thenar.Automaton.from_arrays(
                alphabet=thenar.Alphabet([events[e] for e in own]),
                offsets=arrays[f"offsets_{k}"],
                events=np.searchsorted(own, arrays[f"events_{k}"]),
                targets=arrays[f"targets_{k}"],
                initial=a["initial"],
                marked=arrays[f"marked_{k}"].astype(bool),
                name=a["name"],
            )
        )
    return Problem(automata["plant"], automata["spec"], alphabet=thenar.Alphabet(events))


@pytest.mark.parametrize(
    ("model", "states"),
    [
        ("small_factory", 12),
        ("cat_and_mouse", 6),
        ("agv", 4406),
        ("glr", 2809),
        ("chain(20)", 2 * 3**19),
        ("transfer_line(100)", 28**100),
        ("dining(100)", 189482250299273866835746159841800035873),
        ("glr(fingers=10)", None),
        ("dining(1000)", None),
    ],
)
def test_the_library_is_certified(tmp_path: Path, model: str, states: int | None) -> None:
    """Numbers of states: as in tests/symbolic/test_engine.py."""
    problem = thenar.library.model(model)
    result, supervisor = symbolic(problem)
    verdict = checked(tmp_path / "one.cert", result, problem)
    assert verdict, verdict.reason
    assert verdict.states == supervisor.n_states
    assert states is None or verdict.states == states
    assert verdict.nodes
    other = thenar.verify(tmp_path / "one.cert", statement(thenar.library.model("small_factory(3)")))
    assert other.reason == "the certificate is about another problem"


def test_both_engines_certify_the_same_supervisor(tmp_path: Path) -> None:
    listed = checked(tmp_path / "listed.cert", thenar.synthesize(thenar.library.model("agv"), "explicit"))
    sets = checked(tmp_path / "sets.cert", thenar.synthesize(thenar.library.model("agv"), "symbolic"))
    assert (listed.states, listed.transitions) == (sets.states, sets.transitions)
    assert (listed.nodes, sets.nodes > 0) == (0, True)


def test_the_reason_names_the_event_and_the_states(tmp_path: Path) -> None:
    result, supervisor = symbolic(thenar.library.model("dining(100)"))
    bare = SymbolicSupervisor(supervisor.encoding, supervisor.reachable, supervisor.safe, supervisor.controlled)
    verdict = checked(tmp_path / "lie.cert", replace(result, symbolic=bare))
    assert verdict.reason.startswith("not largest: take_")
    assert "leads from state (" in verdict.reason
    assert verdict.reason.endswith("192 more), which is neither in the supervisor nor removed")


def test_a_flipped_bit_anywhere_in_the_file_is_detected(tmp_path: Path) -> None:
    rng, whole = random.Random(7), thenar.certificate(symbolic(thenar.library.model("agv"))[0])
    for place in [*range(100), *rng.sample(range(len(whole)), 300), len(whole) - 1]:
        flipped = bytearray(whole)
        flipped[place] ^= 1 << rng.randrange(8)
        (tmp_path / "flipped").write_bytes(flipped)
        with pytest.raises(CertificateError):
            thenar.verify(tmp_path / "flipped")


@pytest.mark.parametrize("name", ["order", "node_levels", "node_children", "roots", "reasons"])
@pytest.mark.parametrize(
    "hostile",
    [
        lambda a: a.astype(float),
        lambda a: a.reshape(-1, 1, 1),
        lambda a: np.zeros(0, a.dtype),
        lambda a: a.astype(np.int64) - 2**40,
        lambda a: a.astype(np.uint64) + 2**40,
        lambda a: -1 - a.astype(np.int64),
        lambda a: a[:-1],
        lambda a: a[::-1],
        lambda a: np.concatenate((a, a)),
        lambda a: a.astype("U3"),
        lambda a: np.array(3),
        lambda a: np.full_like(a, 1),
        lambda a: np.arange(len(a)),
        lambda a: np.arange(len(a))[::-1],
    ],
)
def test_hostile_arrays_are_rejected_and_nothing_breaks(
    tmp_path: Path, name: str, hostile: Callable[[Any], Any]
) -> None:
    (tmp_path / "true.cert").write_bytes(thenar.certificate(symbolic(thenar.library.model("agv"))[0]))
    arrays, header = read(tmp_path / "true.cert")
    (tmp_path / "lie.cert").write_bytes(pack({**arrays, name: hostile(arrays[name])}, header))
    verdict = thenar.verify(tmp_path / "lie.cert")
    assert not verdict
    assert verdict.reason
    del arrays[name]
    (tmp_path / "lie.cert").write_bytes(pack(arrays, header))
    assert thenar.verify(tmp_path / "lie.cert").reason == f"malformed: {name}"


def test_one_kind_of_evidence_does_not_pass_for_the_other(tmp_path: Path) -> None:
    path, problem = tmp_path / "one.cert", thenar.library.model("agv")
    for engine, missing in (("symbolic", "coords"), ("explicit", "order")):
        path.write_bytes(thenar.certificate(thenar.synthesize(problem, engine)))
        arrays, header = read(path)
        header["evidence"] = {"symbolic": "states", "explicit": "diagrams"}[engine]
        path.write_bytes(pack(arrays, header))
        assert thenar.verify(path).reason == f"malformed: {missing}"


def test_a_problem_with_variables_is_certified_by_its_states(tmp_path: Path) -> None:
    problem = random_extended_problem(random.Random(3))
    with pytest.raises(InputError, match=r"listing its states: synthesize\(problem, 'explicit'\)"):
        thenar.certificate(thenar.synthesize(problem, "symbolic"))
    path = tmp_path / "one.cert"
    path.write_bytes(thenar.certificate(thenar.synthesize(problem, "explicit")))
    assert thenar.verify(path, statement(problem))
    assert not thenar.verify(path, statement(random_extended_problem(random.Random(4))))


def test_the_same_result_gives_the_same_bytes() -> None:
    one, two = (thenar.certificate(symbolic(thenar.library.model("agv"))[0]) for _ in range(2))
    assert one == two
