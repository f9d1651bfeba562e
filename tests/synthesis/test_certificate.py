"""A certificate of a true result is accepted; whatever is changed in it, it is rejected."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

import thenar
from thenar.library import glr
from thenar.model.problem import Problem
from thenar.synthesis.certificate import pack, statement
from thenar.synthesis.proof.container import read
from thenar.synthesis.verify import Verdict
from thenar.testing.strategies import problems

Arrays = dict[str, np.ndarray[Any, Any]]


@pytest.fixture(scope="module")
def glr_certificate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("certificates") / "glr.cert"
    path.write_bytes(thenar.certificate(thenar.synthesize(glr.problem())))
    return path


def forge(path: Path, arrays: Arrays, header: dict[str, Any]) -> Path:
    """Write a certificate whose digest is right, whatever it says."""
    path.write_bytes(pack(arrays, header))
    return path


@settings(max_examples=150, deadline=None)
@given(problem=problems())
def test_every_result_is_certified(tmp_path_factory: pytest.TempPathFactory, problem: Problem) -> None:
    result = thenar.synthesize(problem)
    path = tmp_path_factory.getbasetemp() / "one.cert"
    path.write_bytes(thenar.certificate(result))
    verdict = thenar.verify(path)
    assert verdict, verdict.reason
    assert (verdict.states, verdict.transitions) == (result.supervisor.n_states, result.supervisor.n_transitions)


def test_the_glr_certificate_is_accepted_and_is_about_glr(glr_certificate: Path) -> None:
    verdict = thenar.verify(glr_certificate)
    assert verdict, verdict.reason
    assert (verdict.states, verdict.transitions) == (2809, 6076)
    assert thenar.verify(glr_certificate, statement(glr.problem()))
    other = thenar.verify(glr_certificate, statement(Problem(glr.finger(1), name="glr")))
    assert other.reason == "the certificate is about another problem"


def test_a_flipped_bit_anywhere_in_the_file_is_detected(glr_certificate: Path, tmp_path: Path) -> None:
    rng, whole = random.Random(7), glr_certificate.read_bytes()
    places = [*range(200), *rng.sample(range(len(whole)), 1000), len(whole) - 1]
    for place in places:
        flipped = bytearray(whole)
        flipped[place] ^= 1 << rng.randrange(8)
        (tmp_path / "flipped").write_bytes(flipped)
        with pytest.raises(thenar.CertificateError):
            thenar.verify(tmp_path / "flipped")


@pytest.mark.parametrize(
    "array", ["coords", "reason", "rank", "way", "origin", "sup_offsets", "sup_events", "sup_targets", "sup_marked"]
)
def test_a_lie_with_a_right_digest_is_caught_unless_it_is_true(
    glr_certificate: Path, tmp_path: Path, array: str
) -> None:
    """Change one number at a time; a certificate that is still accepted must still prove the same supervisor."""
    arrays, header = read(glr_certificate)
    truth = {k: v.copy() for k, v in arrays.items()}
    rng = np.random.default_rng(7)
    rejected = 0
    for _ in range(60):
        lie = {k: v.copy() for k, v in truth.items()}
        flat = lie[array].reshape(-1)
        k = rng.integers(len(flat))
        old = flat[k]
        flat[k] = old + rng.choice([-1, 1]) if array != "sup_marked" else 1 - old
        if flat[k] == old:
            continue
        verdict = thenar.verify(forge(tmp_path / "lie.cert", lie, header))
        if verdict:
            # ranks and distances are hints: other true ones do as well. What is claimed must not change.
            assert array in ("rank", "way"), f"{array}[{k}]: {old} -> {flat[k]} was accepted"
        else:
            assert verdict.reason
            rejected += 1
    assert rejected >= (1 if array in ("rank", "way") else 50)


def tampered(problem: Problem, tmp_path: Path, change: Any) -> Verdict:
    path = tmp_path / "true.cert"
    path.write_bytes(thenar.certificate(thenar.synthesize(problem)))
    arrays, header = read(path)
    arrays = {k: v.copy() for k, v in arrays.items()}
    change(arrays, header)
    return thenar.verify(forge(tmp_path / "false.cert", arrays, header))


def test_a_supervisor_that_is_too_small_is_not_the_largest(tmp_path: Path) -> None:
    """Declare the initial state removed, and the supervisor empty."""

    def change(arrays: Arrays, header: dict[str, Any]) -> None:
        arrays["reason"][0], arrays["rank"][0], arrays["way"][0] = 3, arrays["rank"].max() + 1, -1
        for name in ("origin", "sup_events", "sup_targets", "sup_marked"):
            arrays[name] = arrays[name][:0]
        arrays["sup_offsets"] = arrays["sup_offsets"][:1]

    verdict = tampered(glr.problem(), tmp_path, change)
    assert verdict.reason.startswith("not largest: state 0 (FINGER1:0")


def test_a_survivor_that_breaks_a_specification_is_named(tmp_path: Path) -> None:
    """Declare a state in which the plant can slip, which the specification forbids, a survivor."""
    plant = thenar.Automaton.from_transitions(
        ["0 -go-> 1 -slip-> 2"], initial="0", marked=["0", "1", "2"], uncontrollable=["slip"], name="HAND"
    )
    dry = thenar.Automaton.from_transitions(
        [], initial="0", marked=["0"], events=[thenar.Event("slip", controllable=False)], alphabet=["slip"], name="DRY"
    )

    def change(arrays: Arrays, header: dict[str, Any]) -> None:
        assert arrays["reason"].tolist() == [0, 1]
        arrays["reason"][1], arrays["rank"][1], arrays["way"][1] = 0, -1, 0

    verdict = tampered(Problem(plant, dry), tmp_path, change)
    assert verdict.reason == "not within the specifications: slip breaks one in state 1 (HAND:1, DRY:0)"


def test_an_uncontrollable_event_that_became_controllable_is_noticed(tmp_path: Path) -> None:
    def change(arrays: Arrays, header: dict[str, Any]) -> None:
        for event in header["events"]:
            event["controllable"] = True

    assert "not largest" in tampered(glr.problem(), tmp_path, change).reason


def test_a_controllability_that_is_no_truth_value_is_not_read_with_good_will(tmp_path: Path) -> None:
    """In Python 0 == False, so 0 would make an event controllable here and leave the problem the same there."""
    problem = glr.problem()

    def change(arrays: Arrays, header: dict[str, Any]) -> None:
        for event in header["events"]:
            event["controllable"] = int(event["controllable"])

    assert tampered(problem, tmp_path, change).reason == "malformed: events"


@pytest.mark.parametrize(
    "name", ["coords", "reason", "rank", "way", "origin", "sup_offsets", "events_0", "own_0", "marked_1"]
)
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
        lambda a: np.concatenate((a, a)),
        lambda a: a.astype("U3"),
        lambda a: np.array(3),
        lambda a: np.full_like(a, 1),
    ],
)
def test_hostile_arrays_are_rejected_and_nothing_breaks(
    glr_certificate: Path, tmp_path: Path, name: str, hostile: Callable[[Any], Any]
) -> None:
    arrays, header = read(glr_certificate)
    lie = hostile(arrays[name])
    if np.array_equal(lie, arrays[name]):
        pytest.skip("says the same")
    verdict = thenar.verify(forge(tmp_path / "lie.cert", {**arrays, name: lie}, header))
    assert not verdict
    assert verdict.reason


@pytest.mark.parametrize("name", ["coords", "way", "origin", "sup_marked", "own_1", "targets_0"])
def test_a_missing_array_is_noticed(glr_certificate: Path, tmp_path: Path, name: str) -> None:
    arrays, header = read(glr_certificate)
    del arrays[name]
    assert thenar.verify(forge(tmp_path / "lie.cert", arrays, header)).reason == f"malformed: {name}"


def test_what_is_no_certificate_is_refused(tmp_path: Path) -> None:
    junk = tmp_path / "junk"
    junk.write_bytes(bytes(range(256)) * 10)
    with pytest.raises(thenar.CertificateError, match="not a certificate; write one with"):
        thenar.verify(junk)
    forge(tmp_path / "other", {"x": np.arange(3)}, {})
    with pytest.raises(thenar.CertificateError, match="malformed: its digest is right"):
        thenar.verify(tmp_path / "other")
    with pytest.raises(thenar.CertificateError, match="No such file"):
        thenar.verify(tmp_path / "missing")
    whole = thenar.certificate(thenar.synthesize(glr.problem()))
    (tmp_path / "cut").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(thenar.CertificateError, match="damaged: the contents do not match their digest"):
        thenar.verify(tmp_path / "cut")


def test_wide_products_are_indexed_without_overflow(tmp_path: Path) -> None:
    """70 components of two states: a state has 70 bits, more than one integer holds."""
    parts = [
        thenar.Automaton.from_transitions(
            [("1", f"pass{k}", "0"), ("0", f"pass{(k - 1) % 70}", "1")],
            initial="1" if k == 0 else "0",
            marked=["0", "1"],
            name=f"P{k}",
        )
        for k in range(70)
    ]
    path = tmp_path / "wide.cert"
    path.write_bytes(thenar.certificate(thenar.synthesize(Problem(parts))))
    verdict = thenar.verify(path)
    assert verdict, verdict.reason
    assert verdict.states == 70
