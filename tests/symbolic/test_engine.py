"""The symbolic engine: what it finds is what the explicit engine and the slow oracle find, whatever the size."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random

import pytest

import thenar
from thenar._native import kernel
from thenar.errors import InputError, LimitReached
from thenar.explicit import exploration
from thenar.model.automaton import Automaton
from thenar.model.expressions import parse
from thenar.model.limits import Limits, Progress
from thenar.symbolic import levels
from thenar.symbolic.encode import Encoding
from thenar.symbolic.order import METHODS
from thenar.symbolic.synthesis import explore
from thenar.synthesis import api
from thenar.synthesis.certificate import statement
from thenar.testing import extended_oracle
from thenar.testing.asserts import assert_same_supervisor
from thenar.testing.random_models import random_extended_problem, random_problem

BATCH = 100


def batches(total: int) -> list[range]:
    return [range(k, k + BATCH) for k in range(0, total, BATCH)]


@pytest.mark.parametrize("seeds", batches(500), ids=str)
def test_extended_problems_are_solved_as_the_oracle_does(seeds: range) -> None:
    for seed in seeds:
        problem = random_extended_problem(Random(seed))
        slow = extended_oracle.supcon(problem)
        fast = thenar.synthesize(problem, "symbolic").symbolic
        assert fast is not None
        assert fast.n_states == slow.n_states
        assert fast.reachable.count() == len(extended_oracle.explore(problem).states)
        listed = thenar.synthesize(problem, "explicit")
        assert listed.size == (fast.n_states, fast.n_transitions)
        assert bool(listed) == bool(slow) == (not fast.is_empty)


def test_an_extended_problem_is_explained_and_certified_by_its_states(tmp_path: Path) -> None:
    cat, mouse = (
        Automaton.from_transitions([f"a -{n}_b-> b -{n}_a-> a"], initial=i, marked=["a", "b"], name=n.upper())
        for n, i in (("cat", "a"), ("mouse", "b"))
    )
    apart = thenar.invariant("not (CAT.a and MOUSE.a) and not (CAT.b and MOUSE.b)")
    problem = thenar.ExtendedProblem([cat, mouse], [apart, thenar.needs("cat_b", "MOUSE.a")], name="apart")
    result = thenar.synthesize(problem, "explicit")
    assert result.size == (1, 0)  # each would walk in on the other
    why = thenar.explain_disabled(result, "mouse_a")
    assert why.verdict == "uncontrollable"
    assert "requirement" in str(why)
    certificate = tmp_path / "apart.cert"
    certificate.write_bytes(thenar.certificate(result))
    assert thenar.verify(certificate, statement(result.plain))


def test_more_initial_states_than_can_be_listed_end_at_a_limit() -> None:
    idle = thenar.ExtendedAutomaton.from_edges("IDLE", [("on", "go", "on")], initial="on", marked=["on"])
    variables = [thenar.Variable(f"v{k}", range(10), initial=range(10)) for k in range(12)]
    problem = thenar.ExtendedProblem([idle], [], variables=variables)
    none = thenar.ExtendedProblem([idle], [], variables=variables, initial=parse("v0 + v1 > 99"))
    with pytest.raises(LimitReached, match="limit of 20,000 states"):
        thenar.synthesize(problem, "explicit", limits=Limits(states=20_000))
    with pytest.raises(LimitReached, match="seconds"):
        thenar.synthesize(none, "explicit", limits=Limits(seconds=1))
    assert thenar.synthesize(problem, "symbolic").size.states == 10**12


@pytest.mark.parametrize("method", METHODS)
def test_the_order_changes_nothing_but_the_cost(method: str) -> None:
    for seed in range(40):
        problem = random_problem(Random(seed))
        found, listed = thenar.synthesize(problem, "symbolic", order=method), thenar.synthesize(problem, "explicit")
        assert_same_supervisor(found.supervisor, listed.supervisor)


def test_an_order_can_be_given_and_is_reproducible() -> None:
    problem = thenar.library.model("agv")
    names = [a.name for a in problem.automata]
    given = thenar.synthesize(problem, "symbolic", order=names[::-1])
    assert given.symbolic is not None
    assert [given.symbolic.encoding.parts[k].name for k in given.symbolic.encoding.order] == names[::-1]
    found = [thenar.synthesize(problem, "symbolic").symbolic for _ in range(2)]
    orders = [s.encoding.order.tolist() for s in found if s is not None]
    assert orders[0] == orders[1]
    assert given.size.states == 4406
    with pytest.raises(InputError, match="lists every automaton and variable once"):
        thenar.synthesize(problem, "symbolic", order=names[1:])
    with pytest.raises(InputError, match="unknown order 'forse'; did you mean 'force'"):
        thenar.synthesize(problem, "symbolic", order="forse")


def test_garbage_is_collected_without_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(levels, "COLLECT_AT", 64)
    monkeypatch.setattr(levels, "CACHE_BYTES", 1 << 12)
    for name, states in (("glr", 2809), ("agv", 4406), ("chain(20)", 2 * 3**19), ("dining(20)", pell_lucas(20) - 1)):
        result = thenar.synthesize(thenar.library.model(name), "symbolic")
        assert result.size.states == states
        assert result.symbolic is not None
        assert result.symbolic.encoding.forest.collections > 0
    for seed in range(100):
        problem = random_extended_problem(Random(seed))
        assert thenar.synthesize(problem, "symbolic").size.states == extended_oracle.supcon(problem).n_states


def pell_lucas(n: int) -> int:
    """Return Q(n): Q(0) = Q(1) = 2, Q(k) = 2 Q(k-1) + Q(k-2)."""
    a, b = 2, 2
    for _ in range(n - 1):
        a, b = b, 2 * b + a
    return b


@pytest.mark.parametrize(
    ("model", "states"),
    [
        ("transfer_line(300)", 28**300),
        ("dining(1000)", pell_lucas(1000) - 1),
        ("chain(100)", 2 * 3**99),
        ("small_factory(200)", 3 * 4**199),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_families_have_as_many_states_as_their_formulas_say(model: str, states: int) -> None:
    """Closed forms fitted to what several tools find at small sizes; the counts are exact integers."""
    assert counted(thenar.library.model(model)) == states


def counted(problem: thenar.Problem) -> int:
    found = thenar.synthesize(problem, "symbolic").symbolic
    assert found is not None
    return found.n_states


def glr_states(fingers: int) -> int:
    """The number of states that the library's page gives for the task with so many fingers."""
    m: int = fingers - 1
    return sum(c * base**m for c, base in ((4, 115), (4, 99), (13, 63), (66, 18), (-6, 9)))


@pytest.mark.parametrize("fingers", [2, 3, 10, 30, 100])
def test_more_fingers(fingers: int) -> None:
    problem = thenar.library.glr.problem(fingers=fingers)
    assert counted(problem) == glr_states(fingers)


def test_auto_says_why() -> None:
    def chosen(model: str) -> tuple[str, str]:
        result = thenar.synthesize(thenar.library.model(model))
        return result.engine, result.engine_reason

    assert chosen("small_factory(2)") == ("explicit", "the product has at most 18 states")
    reachable = thenar.sync(*thenar.library.model("chain(11)").automata).n_states
    assert chosen("chain(11)") == ("explicit", f"the product has {reachable:,} reachable states")
    assert chosen("transfer_line(20)")[0] == "symbolic"
    assert "reachable states" in chosen("transfer_line(20)")[1]


def test_after_a_trace_both_say_the_same() -> None:
    problem = thenar.library.glr.problem()
    explicit, symbolic = (thenar.synthesize(problem, engine) for engine in ("explicit", "symbolic"))
    assert symbolic.symbolic is not None
    for seed in range(10):
        trace = thenar.random_trace(explicit.supervisor, 30, seed)
        for k in range(len(trace) + 1):
            assert symbolic.symbolic.after(trace[:k]) == explicit.supervisor.after(trace[:k])
    assert symbolic.symbolic.after("incip_slip*") is None


def test_bytes_and_seconds_are_limits() -> None:
    problem = thenar.library.model("agv")
    with pytest.raises(LimitReached, match="bytes"):
        thenar.synthesize(problem, "symbolic", limits=Limits(bytes=50_000))
    with pytest.raises(LimitReached, match="seconds"):
        thenar.synthesize(hard(), "symbolic", order="model", limits=Limits(seconds=0.2))


def hard() -> thenar.Problem:
    """A problem that takes long in the order of the model."""
    return thenar.library.glr.problem(fingers=12)


def test_ctrl_c_stops_saturation_at_once() -> None:
    code = (
        "import thenar, sys\n"
        "problem = thenar.library.glr.problem(fingers=12)\n"
        "print('go', flush=True)\n"
        "thenar.synthesize(problem, 'symbolic', order='model')"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(1.5)
        start = time.monotonic()
        os.kill(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=20)
        assert time.monotonic() - start < 5  # a fifth of a second on a quiet machine
    assert b"KeyboardInterrupt" in err


@pytest.mark.parametrize("engine", ["explicit", "symbolic"])
def test_python_may_end_while_a_thread_is_at_work(engine: str) -> None:
    code = (
        "import thenar, threading, time\n"
        f"explicit = {engine == 'explicit'}\n"
        "problem = thenar.library.model('chain(16)') if explicit else thenar.library.glr.problem(fingers=12)\n"
        f"ask = lambda: thenar.synthesize(problem, {engine!r}, order='model', progress=lambda n, m: None)\n"
        "threading.Thread(target=ask, daemon=True).start()\n"
        "time.sleep(0.7)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=60, check=False)
    assert (found.returncode, found.stderr) == (0, b"")


def test_limits_and_progress_are_those_of_the_synthesis_alone() -> None:
    calls: list[int] = []
    for engine in ("symbolic", "auto"):
        result = thenar.synthesize(
            thenar.library.model("transfer_line(20)"),
            engine,
            limits=Limits(seconds=1.5, bytes=10_000_000),
            progress=lambda nodes, _: calls.append(nodes),
        )
        assert result.symbolic is not None
        time.sleep(1.5)
        calls.clear()
        encoding = result.symbolic.encoding
        encoding.tick.look(1, 1)  # what asks the clock
        assert result.size.states == 28**20
        assert len(thenar.guards(result.symbolic)) == 60
        assert calls == []
        assert encoding.forest.max_bytes == (1 << 63) - 1


def test_auto_counts_within_less_memory_than_it_solves(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = thenar.library.model("transfer_line(100)")
    counted = explore(Encoding(problem, kernel.Ticker()))[0].forest.bytes
    monkeypatch.setattr(api, "TRIED_BYTES", counted)
    assert thenar.synthesize(problem).size.states == 28**100
    assert thenar.synthesize(problem, limits=Limits(bytes=10 * counted)).size.states == 28**100
    with pytest.raises(LimitReached, match=f"{counted:,} bytes"):
        thenar.synthesize(problem, limits=Limits(bytes=counted))


def test_auto_hands_on_what_is_left_of_the_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(LimitReached, match="3 seconds"):
        kernel.Ticker(seconds=3, spent=4).look(1, 1)
    spent: list[float] = []

    def ticker(limits: Limits | None, progress: Progress | None, already: float = 0.0) -> kernel.Ticker:
        spent.append(already)
        return exploration.ticker(limits, progress, already)

    monkeypatch.setattr(api, "ticker", ticker)
    assert thenar.synthesize(thenar.library.model("chain(11)")).engine == "explicit"
    assert 0 == spent[0] < spent[1] < spent[2]  # listed a few, counted, listed all


def test_an_order_or_its_reverse_whichever_is_faster() -> None:
    problem = thenar.library.model("small_factory(500)")
    found = [thenar.synthesize(problem, "symbolic").symbolic for _ in range(2)]
    first, second = (s.encoding for s in found if s is not None)
    assert first.order.tolist() == second.order.tolist()
    names = [first.parts[k].name for k in first.order]
    steps = [explore(Encoding(problem, kernel.Ticker(), order=x))[0].forest.work for x in (names, names[::-1])]
    assert 100 * steps[0] < steps[1]  # taken as it is, an order has no rival
    for size in range(200_000, 2_000_000, 200_000):  # one of them may have to give up, or both
        with contextlib.suppress(LimitReached):
            assert thenar.synthesize(problem, "symbolic", limits=Limits(bytes=size)).size.states == 3 * 4**499


def test_large_supervisors_are_not_listed() -> None:
    result = thenar.synthesize(thenar.library.model("transfer_line(10)"))
    with pytest.raises(LimitReached, match="2,000,000 states"):
        _ = result.supervisor
    assert repr(result).startswith("SynthesisResult 'transfer_line(10)': 296,196,766,695,424 states")


def test_an_empty_automaton_means_no_supervisor() -> None:
    plant = Automaton.from_transitions(["0 -a-> 0"], initial="0", marked=["0"], name="P")
    empty = Automaton.empty(thenar.Alphabet(["a"]), "NOTHING")
    assert not thenar.synthesize(thenar.Problem([plant], [empty]), "symbolic")
