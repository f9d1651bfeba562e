"""The native kernel where it is easy to get wrong: many events, wide states, long chains, limits, interrupts."""

import _thread
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from random import Random

import numpy as np
import pytest

import thenar
from thenar._native import kernel
from thenar.explicit.exploration import Exploration, ticker
from thenar.model.automaton import Automaton
from thenar.testing import oracle
from thenar.testing.random_models import random_problem


def toggles(n: int, *, uncontrollable: bool = False) -> list[Automaton]:
    """n independent two-state automata."""
    return [
        Automaton.from_transitions(
            [f"0 -up{k}-> 1 -down{k}-> 0"],
            initial="0",
            marked=["0"],
            uncontrollable=[f"down{k}"] if uncontrollable else [],
            name=f"T{k}",
        )
        for k in range(n)
    ]


def token_ring(n: int) -> list[Automaton]:
    """n two-state automata in a ring that pass a token on: n states of n bits."""
    return [
        Automaton.from_transitions(
            [("1", f"pass{k}", "0"), ("0", f"pass{(k - 1) % n}", "1")],
            initial="1" if k == 0 else "0",
            marked=["0", "1"],
            name=f"P{k}",
        )
        for k in range(n)
    ]


def ring(name: str, n: int, events: list[str]) -> Automaton:
    """n states in a ring, all events moving on together."""
    lines = [(str(q), e, str((q + 1) % n)) for q in range(n) for e in events]
    return Automaton.from_transitions(lines, initial="0", marked=["0"], events=events, name=name)


@pytest.mark.parametrize("n", [31, 32, 33, 63, 64, 65, 130])
def test_events_beyond_a_machine_word_are_no_different(n: int) -> None:
    """The marker bit lies behind the last event: 63, 64 and 65 events are the edges."""
    events = [f"e{k}" for k in range(n)]
    a = Automaton.from_transitions(
        [("0", e, "1") for e in events[::2]] + [("1", e, "0") for e in events[1::2]],
        initial="0",
        marked=["1"],
        events=events,
        name="A",
    )
    b = ring("B", 3, events)
    product = thenar.sync(a, b)
    expected = oracle.sync(a, b)
    assert (product.n_states, product.n_transitions) == (expected.n_states, expected.n_transitions)
    assert oracle.isomorphic(product, expected)


@pytest.mark.parametrize("n", [40, 64, 65, 100, 300, 1500])
def test_states_of_many_words_are_no_different(n: int) -> None:
    """n two-state automata in a ring that pass a token: n states of n bits."""
    product = thenar.sync(*token_ring(n))
    assert (product.n_states, product.n_transitions) == (n, n)
    assert product.states[1].split("|").index("1") == 1


def test_more_uncontrollable_events_in_a_state_than_a_short_counter_holds() -> None:
    n = 65_537
    events = [thenar.Event(f"u{k}", controllable=False) for k in range(n)]
    plant = Automaton.from_arrays(
        thenar.Alphabet(events), [0, n, n], np.arange(n), np.r_[np.zeros(n - 1, int), 1], marked=[True, False], name="G"
    )
    assert thenar.supcon(plant, []).is_empty  # the last event blocks, and cannot be prevented
    assert thenar.is_sublanguage(plant, plant)


def test_an_event_that_no_automaton_has_never_happens(tmp_path: Path) -> None:
    a = Automaton.from_transitions(["0 -x-> 1 -y-> 0"], initial="0", marked=["0"], name="A")
    problem = thenar.Problem(a, alphabet=thenar.Alphabet(["x", "unused", "y"]))
    result = thenar.synthesize(problem)
    assert (result.size.states, result.size.transitions) == (2, 2)
    assert thenar.explain_disabled(result, "unused").verdict == "impossible"
    path = tmp_path / "a.cert"
    path.write_bytes(thenar.certificate(result))
    assert thenar.verify(path)


def test_an_event_of_specifications_alone_is_hindered_by_no_plant() -> None:
    plant = Automaton.from_transitions(["0 -x-> 0"], initial="0", marked=["0"], name="G")
    spec = Automaton.from_transitions(["0 -w-> 1"], initial="0", marked=["0", "1"], uncontrollable=["w"], name="E")
    check = thenar.is_controllable(spec, plant)
    assert check.witness == thenar.Trace("w, w")
    assert thenar.supcon(plant, spec).is_empty
    assert oracle.supcon([plant], [spec]).is_empty


def test_components_of_one_state_take_no_room() -> None:
    idle = [
        Automaton.from_transitions([("q", f"x{k}", "q")], initial="q", marked=["q"], name=f"I{k}") for k in range(5000)
    ]
    product = thenar.sync(*toggles(3), *idle, *toggles_named("U", 2))
    assert (product.n_states, product.n_transitions) == (32, 32 * 5005)


def test_a_last_component_without_bits_does_not_shorten_the_key() -> None:
    """64 bits of state fill a whole word, the component behind them takes none; only upper bits tell states apart."""

    def still(name: str) -> Automaton:
        return Automaton.from_transitions([("1", name, "0")], initial="0", marked=["0"], name=name)

    idle = Automaton.from_transitions([("q", "idle", "q")], initial="q", marked=["q"], name="I")
    product = thenar.sync(*(still(f"S{k}") for k in range(48)), *toggles(16), idle)
    assert (product.n_states, product.n_transitions) == (1 << 16, 17 << 16)


def toggles_named(name: str, n: int) -> list[Automaton]:
    return [
        Automaton.from_transitions([f"0 -{name}{k}-> 1 -{name}{k}-> 0"], initial="0", marked=["0"], name=f"{name}{k}")
        for k in range(n)
    ]


def test_more_bits_than_the_explicit_engine_packs_is_a_clear_error() -> None:
    with pytest.raises(thenar.InputError, match="explicit engine packs 4096"):
        thenar.sync(*toggles(4097))


def test_states_beyond_a_near_cache_are_numbered_breadth_first_all_the_same() -> None:
    """Two rings of 23 stages with 100 steps each, each at its own pace, go to the next stage together."""
    n, stage = 2300, 100

    def staged(own: str) -> Automaton:
        rows = [(str(q), own if (q + 1) % stage else "both", str((q + 1) % n)) for q in range(n)]
        return Automaton.from_transitions(rows, initial="0", marked=["0"], name=own.upper())

    product = thenar.sync(staged("a"), staged("b"))
    assert product.alphabet.names == ("a", "both", "b")
    number, targets = {(0, 0): 0}, []
    for p, q in (queue := [(0, 0)]):
        ends = ((p + 1) % stage == 0, (q + 1) % stage == 0)
        steps = [((p + 1) % n, q)] * (not ends[0]) + [((p + 1) % n, (q + 1) % n)] * all(ends)
        for state in [*steps, *[(p, (q + 1) % n)] * (not ends[1])]:
            if state not in number:
                number[state] = len(queue)
                queue.append(state)
            targets.append(number[state])
    assert product.n_states == len(queue) == n * stage
    assert np.array_equal(product.targets, targets)
    assert product.states[n] == "|".join(map(str, queue[n]))


@pytest.mark.parametrize("forward", [True, False])
def test_a_long_chain_is_solved_in_linear_time(forward: bool) -> None:
    """Removal that creeps along 200 000 states, one a sweep, would take hours by sweeps alone."""
    n = 200_000
    order = np.arange(n) if forward else np.roll(np.arange(n)[::-1], 1)
    target = np.empty(n, np.int32)
    target[order[:-1]] = order[1:]
    target[order[-1]] = order[-1]
    # every state can also jump anywhere near the start, so that breadth-first numbers do not follow the chain
    events = np.tile(np.array([0, 1], np.int32), n)
    jumps = np.stack([(np.arange(n) * 7919 + 13) % n, target], axis=1).astype(np.int32).ravel()
    alphabet = thenar.Alphabet([thenar.Event("jump"), thenar.Event("next", controllable=False)])
    marked = np.ones(n, np.bool_)
    plant = Automaton.from_arrays(alphabet, np.arange(n + 1) * 2, events, jumps, marked=marked, name="CHAIN")
    last = Automaton.from_transitions(
        [], initial="q", marked=["q"], events=[thenar.Event("end", controllable=False)], alphabet=["end"], name="NEVER"
    )
    with_end = Automaton.from_arrays(
        alphabet | last.alphabet,
        np.concatenate((np.arange(n) * 2, [2 * n + 1])),
        np.concatenate((events, [2])),
        np.concatenate((jumps, [0])),
        marked=marked,
        name="CHAIN",
    )
    assert thenar.supcon(plant, []).n_states == n
    assert thenar.supcon(with_end, last).is_empty  # "next" leads to the end from everywhere, uncontrollably


def test_blocking_that_creeps_along_a_chain_is_found() -> None:
    """Only the last of 100 000 states is marked, and the numbers run against the chain."""
    n = 100_000
    offsets = np.concatenate(([0], np.cumsum(np.where(np.arange(n) == n - 1, 0, 1))))
    alphabet = thenar.Alphabet(["next"])
    marked = np.arange(n) == n - 1
    chain = Automaton.from_arrays(alphabet, offsets, np.zeros(n - 1, int), np.arange(1, n), marked=marked, name="CHAIN")
    assert thenar.supcon(chain, []).n_states == n
    assert thenar.is_nonblocking(chain)
    unmarked = Automaton.from_arrays(alphabet, offsets, np.zeros(n - 1, int), np.arange(1, n), marked=np.zeros(n, bool))
    assert thenar.supcon(unmarked, []).is_empty


@pytest.mark.parametrize(
    ("limits", "name"),
    [
        (thenar.Limits(states=1000), "states"),
        (thenar.Limits(transitions=5000), "transitions"),
        (thenar.Limits(bytes=1 << 20), "bytes"),
        (thenar.Limits(seconds=0.05), "seconds"),
    ],
)
def test_a_limit_stops_the_work_and_says_what_was_found(limits: thenar.Limits, name: str) -> None:
    with pytest.raises(thenar.LimitReached, match=f"stopped at the limit of .* {name}") as stopped:
        thenar.sync(*toggles(24), limits=limits)
    assert stopped.value.limit == name
    assert stopped.value.states > 0
    assert stopped.value.transitions > 0


def test_illegal_states_are_left_out_before_a_fixpoint_too() -> None:
    """They are not expanded, and so have no row to be taken out."""
    met = 0
    for seed in range(300):
        problem = random_problem(Random(seed))
        tick = ticker()
        exploration = Exploration(problem.plants, problem.specs, problem.alphabet, tick)
        illegal = exploration.native.illegal.view(np.bool_)
        part = exploration.extract("", tick)
        assert not illegal[part.origin].any()
        met += bool(illegal.any())
    assert met > 50


def test_a_limit_stops_a_projection() -> None:
    """The n-th symbol from the end: the classic automaton whose projection has 2^n states."""
    n = 18
    lines = [("0", "a", "0"), ("0", "b", "0"), ("0", "h", "1")]
    lines += [(str(k), e, str(k + 1)) for k in range(1, n) for e in "ab"]
    a = Automaton.from_transitions(lines, initial="0", marked=[str(n)])
    with pytest.raises(thenar.LimitReached, match="states"):
        thenar.project(thenar.sync(a), ["a", "b"], limits=thenar.Limits(states=10))


def test_progress_is_reported_and_may_stop_the_work() -> None:
    seen: list[tuple[int, int]] = []

    def watch(states: int, transitions: int) -> None:
        seen.append((states, transitions))
        if len(seen) == 3:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        thenar.sync(*toggles(26), progress=watch)
    assert seen == sorted(seen)
    assert seen[0][0] > 0


def test_an_interrupt_is_heeded_at_once() -> None:
    asked = []

    def interrupt() -> None:
        asked.append(time.monotonic())
        _thread.interrupt_main()

    timer = threading.Timer(0.2, interrupt)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            thenar.sync(*toggles(30))
    finally:
        timer.cancel()
    assert asked


def test_other_threads_run_while_the_kernel_does() -> None:
    ticks = 0

    def count() -> None:
        nonlocal ticks
        while not done.is_set():
            ticks += 1
            time.sleep(0.001)

    done = threading.Event()
    thread = threading.Thread(target=count)
    thread.start()
    thenar.sync(*toggles(20))
    done.set()
    thread.join()
    assert ticks > 10


def test_the_same_input_gives_the_same_arrays() -> None:
    a, b = thenar.sync(*toggles(9)), thenar.sync(*toggles(9))
    for name in ("offsets", "events", "targets", "marked"):
        assert np.array_equal(getattr(a, name), getattr(b, name))


def test_states_are_numbered_breadth_first_in_alphabet_order() -> None:
    product = thenar.sync(*toggles(6))
    met = [0]
    for q in range(product.n_states):
        met += [t for _, t in product.row(q) if t not in met]
    assert met == list(range(product.n_states))


def ladder(n: int) -> Automaton:
    """Blocking that creeps down a ladder of n rungs: each removal makes one more state block, a round later."""
    alphabet = thenar.Alphabet(["next", "go", "step", "back", thenar.Event("slip", controllable=False)])
    hub, foot, rung = np.arange(n), n + np.arange(n + 1), 2 * n + 1 + np.arange(n)
    edges = [
        (hub[:-1], 0, hub[1:]),
        (hub, 1, foot[:-1]),
        (foot[:-1], 2, rung),  # the last foot has no way on
        (rung, 3, np.zeros(n, int)),
        (rung, 4, foot[1:]),
    ]
    source = np.concatenate([s for s, _, _ in edges])
    event = np.concatenate([np.full(len(s), e) for s, e, _ in edges])
    order = np.lexsort((event, source))
    offsets = np.concatenate(([0], np.cumsum(np.bincount(source, minlength=3 * n + 1))))
    target = np.concatenate([t for _, _, t in edges])[order]
    marked = np.arange(3 * n + 1) < n
    return Automaton.from_arrays(alphabet, offsets, event[order], target, marked=marked, name="LADDER")


def test_many_rounds_of_blocking_take_linear_time() -> None:
    """A look at all states in each of the 100 000 rounds would take minutes."""
    n = 100_000
    assert thenar.supcon(ladder(n), []).n_states == n


@pytest.mark.parametrize("n", [1, 2, 5, 6, 7, 30])
def test_many_rounds_of_blocking_leave_what_the_oracle_leaves(n: int, tmp_path: Path) -> None:
    """From the sixth round on only what a removal touches is looked at again."""
    result = thenar.synthesize(thenar.Problem(ladder(n)))
    assert oracle.isomorphic(result.supervisor.automaton, oracle.supcon([ladder(n)], []))
    path = tmp_path / "ladder.cert"
    path.write_bytes(thenar.certificate(result))
    assert thenar.verify(path)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        pytest.param(toggles(8), toggles_named("U", 8), id="an array by index"),
        pytest.param(token_ring(14), toggles(12), id="slots by a short key"),
        pytest.param(token_ring(24), toggles(12), id="slots by index"),
        pytest.param(token_ring(40), toggles(12), id="slots by a long key"),
    ],
)
def test_all_ways_to_remember_states_agree(one: list[Automaton], other: list[Automaton]) -> None:
    """The same product of two halves that were multiplied out before has other keys and other tables."""
    product = thenar.sync(*one, *other)
    halves = thenar.sync(thenar.sync(*one), thenar.sync(*other))
    for name in ("offsets", "events", "targets", "marked"):
        assert np.array_equal(getattr(product, name), getattr(halves, name))


def explored(*parts: Automaton) -> Exploration:
    return Exploration(parts, (), thenar.Alphabet(e for a in parts for e in a.alphabet), ticker())


def test_a_stored_transition_takes_at_most_eight_bytes() -> None:
    problem = thenar.library.model("transfer_line(3)")
    exploration = Exploration(problem.plants, problem.specs, problem.alphabet, ticker())
    tables = 1 << 18  # what a product of this size spends on its components does not grow with it
    assert exploration.native.bytes - tables <= 8 * exploration.native.n_transitions


def test_the_limit_of_bytes_counts_what_follows_the_exploration() -> None:
    native = explored(*toggles(12)).native
    little_more = ticker(thenar.Limits(bytes=native.bytes + 1000))
    with pytest.raises(thenar.LimitReached, match="bytes"):
        native.fixpoint(little_more)
    with pytest.raises(thenar.LimitReached, match="bytes"):
        native.extract(little_more)


def graph(n: int, k: int) -> tuple[Automaton, np.ndarray]:
    """n states with at most k transitions anywhere, and the mask of its last state."""
    rng = np.random.default_rng(5)
    there = rng.random((n, k)) < 0.8
    alphabet = thenar.Alphabet([f"e{i}" for i in range(k)])
    offsets = np.concatenate(([0], np.cumsum(there.sum(axis=1))))
    events = np.tile(np.arange(k), (n, 1))[there]
    last = np.arange(n) == n - 1
    a = Automaton.from_arrays(alphabet, offsets, events, rng.integers(0, n, (n, k))[there], marked=last)
    return a, last.astype(np.uint8)


def forgetful(n: int) -> Automaton:
    """The n-th symbol from the end, which a projection that hides h must guess: 2^n sets."""
    lines = [("0", "a", "0"), ("0", "b", "0"), ("0", "h", "1")]
    lines += [(str(k), e, str(k + 1)) for k in range(1, n) for e in "ab"]
    return Automaton.from_transitions(lines, initial="0", marked=[str(n)])


def work(name: str) -> Callable[[kernel.Ticker], object]:
    """Return something that keeps one kernel busy for a while."""
    if name == "explore":
        components = [(a, k) for k, a in enumerate(toggles(30))]
        own = [np.repeat(np.arange(30) == k, 2).astype(np.uint8) for _, k in components]
        parts = [
            kernel.Component(a.offsets, a.events + 2 * k, a.targets, a.marked.astype(np.uint8), own[k], 0, True)
            for a, k in components
        ]
        return lambda tick: kernel.explore(parts, np.zeros(60, np.uint8), tick)
    if name in ("fixpoint", "extract", "path"):
        native = explored(*toggles(18)).native
        nowhere, everywhere = np.zeros(native.n_states, np.uint8), np.ones(native.n_states, np.uint8)
        native.fixpoint(ticker())
        return {
            "fixpoint": native.fixpoint,
            "extract": native.extract,
            "path": lambda tick: native.path(0, nowhere, everywhere, False, tick),
        }[name]
    if name == "project":
        a = forgetful(24)
        hidden = np.array([e.name == "h" for e in a.alphabet], np.uint8)
        marked = a.marked.astype(np.uint8)
        return lambda tick: kernel.project(a.offsets, a.events, a.targets, 3, 0, marked, hidden, tick)
    a, last = graph(200_000, 4)
    return {
        "minimize": lambda tick: kernel.minimize(a.offsets, a.events, a.targets, 4, last, tick),
        "distance_to": lambda tick: kernel.distance_to(a.offsets, a.events, a.targets, last, tick),
        "shortest_path": lambda tick: kernel.shortest_path(a.offsets, a.events, a.targets, 0, last * 0, tick),
        "random_reads": lambda tick: kernel.random_reads(1 << 20, 1 << 26, tick),
        "stream": lambda tick: kernel.stream(1 << 24, tick),
    }[name]


def repeat(run: Callable[[kernel.Ticker], object], tick: kernel.Ticker) -> None:
    """Use one ticker for all repetitions: a quick kernel ends before it looks up."""
    while True:
        run(tick)


KERNELS = [
    "explore",
    "fixpoint",
    "extract",
    "path",
    "project",
    "minimize",
    "distance_to",
    "shortest_path",
    "random_reads",
    "stream",
]


@pytest.mark.parametrize("name", KERNELS)
def test_every_kernel_reports_progress_and_can_be_stopped_by_it(name: str) -> None:
    def enough(states: int, transitions: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        repeat(work(name), ticker(progress=enough))


@pytest.mark.parametrize("name", KERNELS)
def test_every_kernel_stops_at_the_limit_of_seconds(name: str) -> None:
    with pytest.raises(thenar.LimitReached, match="seconds"):
        repeat(work(name), ticker(thenar.Limits(seconds=0.02)))


@pytest.mark.parametrize("name", KERNELS)
def test_every_kernel_heeds_ctrl_c(name: str) -> None:
    """The promise is 0.2 s; the bound leaves room for a busy machine."""
    script = f"""
import runpy, signal
from thenar.explicit.exploration import ticker
signal.signal(signal.SIGINT, signal.default_int_handler)
run = runpy.run_path({str(Path(__file__))!r})["work"]({name!r})
print("ready", flush=True)
try:
    while True:
        run(ticker())
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "ready\n"
        time.sleep(0.1)
        asked = time.monotonic()
        child.send_signal(signal.SIGINT)
        assert child.stdout.readline() == "interrupted\n"
        assert time.monotonic() - asked < 1
