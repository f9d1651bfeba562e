"""TCT's DES and DAT files: three generations, TCT itself, and the log of a session with its files."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from random import Random

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.io.foreign import peers
from tests.io.foreign.odd_automata import MODELS, odd_automaton, restored, said, several_starts, through_a_file

import thenar
from thenar.errors import InputError, ModelError
from thenar.io.foreign import tct
from thenar.io.foreign.written import Names
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import ExtendedAutomaton
from thenar.model.supervisor import Supervisor
from thenar.testing import assert_isomorphic, assert_same_numbering, oracle, random_automaton

FOLDER = MODELS / "tct" / "Transfer_Line_-_OK"
GENERATIONS: tuple[tct.Generation, ...] = ("pitct", "x64", "ctct")
MACHINE = Automaton.from_transitions(
    ["0 -1-> 1 -2-> 0", "1 -4-> 2"], initial="0", marked=["0", "2"], uncontrollable=["2", "4"], name="M"
)
everywhere = pytest.mark.parametrize("generation", GENERATIONS)


def written(automaton: Automaton | ExtendedAutomaton, generation: tct.Generation = "pitct") -> bytes:
    return b"".join(tct.dumps(automaton, generation=generation).chunks)  # type: ignore[arg-type]


def numbered(rng: Random, *, blocked: bool = False) -> Automaton:
    """Draw an automaton that is called by numbers throughout; unless ``blocked``, each event occurs."""
    alphabet = Alphabet(Event(str(k), k % 2 == 1) for k in sorted(rng.sample(range(1, 60), rng.randint(1, 6))))
    a = random_automaton(rng, alphabet, max_states=7, name="A")
    return a if blocked else over_what_occurs(a)


def over_what_occurs(a: Automaton) -> Automaton:
    """Return ``a`` over the events that its transitions carry, which are all that TCT knows."""
    occurring = np.unique(a.events)
    alphabet = Alphabet(a.alphabet[k] for k in occurring.tolist())
    return replace(a, alphabet=alphabet, events=np.searchsorted(occurring, a.events).astype(np.int32))


# -- round trip ----------------------------------------------------------------------------------------------


@everywhere
def test_an_automaton_of_numbers_is_read_as_it_was_written(generation: tct.Generation) -> None:
    for seed in range(350):
        a = numbered(Random(seed))
        b = tct.loads(written(a, generation), "A.DES")
        assert isinstance(b, Automaton)
        assert (b.alphabet, b.initial, said(b)) == (a.alphabet, a.initial, said(a))
        for name in ("offsets", "events", "targets", "marked"):
            assert np.array_equal(getattr(a, name), getattr(b, name))
        assert tct.dumps(a, generation=generation).names is None


@everywhere
def test_names_flags_and_blocked_events_come_back_with_the_table(generation: tct.Generation) -> None:
    for seed in range(1000):
        a = odd_automaton(Random(seed))
        if not several_starts(a):
            file = tct.dumps(a, generation=generation)
            assert said(restored(tct.loads(written(a, generation), "a.des"), file.names)) == said(a)


def test_the_table_is_found_beside_the_file(tmp_path: Path) -> None:
    for seed in range(40):
        a = odd_automaton(Random(seed))
        if not several_starts(a) and a.states:
            assert said(through_a_file(a, tmp_path / "a.des")) == said(a)


@everywhere
def test_nondeterminism_comes_back(generation: tct.Generation) -> None:
    a = ExtendedAutomaton.from_edges("A", ["0 -1-> 0", "0 -1-> 1", "1 -2-> 0"], initial="0", uncontrollable=["2"])
    assert said(tct.loads(written(a, generation), "A.DES")) == said(a)


@everywhere
def test_what_never_happens_is_looped_at_a_state_of_its_own(generation: tct.Generation) -> None:
    a = Automaton.from_transitions(["0 -1-> 0"], initial="0", alphabet=["3", "6"], uncontrollable=["6"])
    file = tct.dumps(a, generation=generation)
    b = tct.loads(b"".join(file.chunks), "a.des")  # type: ignore[arg-type]
    assert b.alphabet == a.alphabet
    assert list(thenar.reachable(b).transitions()) == list(a.transitions())  # type: ignore[arg-type]
    assert list(b.transitions())[1:] == [("1", "3", "1"), ("1", "6", "1")]  # type: ignore[union-attr]
    assert isinstance(file.names, Names)
    assert len(file.names.states) == 1
    assert "3, 6 never happen here" in file.notes[0]


@everywhere
def test_the_automaton_without_states_stays_empty(generation: tct.Generation) -> None:
    assert tct.loads(written(Automaton.empty(Alphabet(["1"])), generation), "a.des").n_states == 0  # type: ignore[union-attr]


def test_labels_rise_with_the_alphabet_and_are_odd_for_controllable_events() -> None:
    events = [Event("u", False), Event("a"), Event("b"), Event("v", False), Event("w", False)]
    a = Automaton.from_transitions([("0", e.name, "0") for e in events], initial="0", events=Alphabet(events))
    names = tct.dumps(a).names
    assert isinstance(names, Names)
    assert [label for label, _ in names.events] == ["2", "3", "5", "6", "8"]


def test_a_number_of_the_wrong_parity_is_a_name_only() -> None:
    a = Automaton.from_transitions(["0 -1-> 0"], initial="0", uncontrollable=["1"])
    names = tct.dumps(a).names
    assert isinstance(names, Names)
    assert names.events[0][0] == "2"


def test_files_over_one_alphabet_have_the_same_labels() -> None:
    events = Alphabet(["a", "b", "c"])
    a = Automaton.from_transitions(["0 -c-> 0"], initial="0", events=events)
    names = tct.dumps(a, alphabet=events).names
    assert isinstance(names, Names)
    assert names.events == (("5", Event("c")),)
    with pytest.raises(InputError, match="'c' of automaton '' is not in the given alphabet"):
        tct.dumps(a, alphabet=Alphabet(["a"]))


def test_label_1000_is_left_to_tct() -> None:
    a = Automaton.from_transitions([("0", f"e{k}", "0") for k in range(600)], initial="0")
    names = tct.dumps(replace(a, alphabet=Alphabet(Event(e.name, False) for e in a.alphabet))).names
    assert isinstance(names, Names)
    assert "1000" not in [label for label, _ in names.events]


def test_what_a_generation_cannot_hold_is_refused() -> None:
    many = Automaton.from_transitions([("0", f"e{k}", "0") for k in range(600)], initial="0")
    with pytest.raises(InputError, match="'e599' would be label 1,199, and the labels of TCT's ctct end at 999"):
        tct.dumps(many, generation="ctct")
    several = ExtendedAutomaton("A", Alphabet(), ("p", "q"), (True, True), (False, False), ())
    with pytest.raises(InputError, match="starts in 2 states"):
        tct.dumps(several)
    guarded = ExtendedAutomaton.from_edges("A", [("p", "a", "p", "n < 3")], initial="p")
    with pytest.raises(InputError, match="guard"):
        tct.dumps(guarded)
    with pytest.raises(InputError, match="unknown generation 'x32'"):
        tct.dumps(many, generation="x32")  # type: ignore[arg-type]


# -- TCT itself ----------------------------------------------------------------------------------------------


def test_files_are_those_that_tct_writes_byte_by_byte() -> None:
    automata = [numbered(Random(seed)) for seed in range(400)]
    rows = [
        (
            a.n_states,
            [(int(s), int(e), int(t)) for s, e, t in a.transitions()],
            np.flatnonzero(a.marked).tolist(),
        )
        for a in automata
    ]
    assert [written(a) for a in automata] == peers.tct_creates(rows)


def test_tct_reads_what_is_written() -> None:
    files = [written(numbered(Random(seed), blocked=True)) for seed in range(400)]
    assert peers.tct_rewrites(files) == files


def test_tct_synchronises_files_of_ours_as_we_do() -> None:
    pairs = [tuple(numbered(Random(seed * 2 + k), blocked=True) for k in range(2)) for seed in range(200)]
    answers = peers.tct_syncs([(written(a), written(b)) for a, b in pairs])
    for (a, b), answer in zip(pairs, answers, strict=True):
        theirs = tct.loads(answer, "AB.DES")
        assert isinstance(theirs, Automaton)
        assert_isomorphic(theirs, over_what_occurs(thenar.sync(a, b)))


def test_control_data_of_tct_is_ours() -> None:
    plant = Automaton.from_transitions(["0 -1,3,5-> 1 -2-> 0"], initial="0", marked=["0"], uncontrollable=["2"])
    spec = Automaton.from_transitions(
        ["0 -1-> 1 -2-> 2 -3-> 3 -2-> 0"], initial="0", marked=["0"], events=plant.alphabet
    )
    theirs = tct.loads_control_data(peers.tct_condat(written(plant), written(spec)), "S.DAT")
    assert theirs == disabled(thenar.condat(plant, over(spec, plant.alphabet)))


def disabled(supervisor: Supervisor) -> tuple[tuple[Event, ...], ...]:
    """Return the events that each state disables."""
    alphabet, cuts = supervisor.automaton.alphabet, supervisor.disabled_offsets
    return tuple(
        tuple(alphabet[k] for k in supervisor.disabled[cuts[q] : cuts[q + 1]].tolist())
        for q in range(supervisor.n_states)
    )


def over(a: Automaton, alphabet: Alphabet) -> Automaton:
    """Return ``a`` over the larger ``alphabet``, whose other events it blocks."""
    place = np.array([alphabet.index(e) for e in a.alphabet], np.int32)
    return replace(a, alphabet=alphabet, events=place[a.events])


# -- a session of other people -------------------------------------------------------------------------------

LOG = FOLDER / "MAKEIT.TXT"
needs_folder = pytest.mark.skipif(
    not FOLDER.is_dir(), reason=f"no {FOLDER}: models of others are no part of the project"
)


def steps() -> list[tuple[str, str, str, str]]:
    """Return (result, operation, arguments, what TCT says of it) for each step of the log."""
    text = re.sub(r"\s+", "", LOG.read_text())
    text = re.sub(r"Computingtime=\d\d:\d\d:\d\d", "", text)
    text = text.replace("Blocked_events=None", "")
    found = re.findall(r"(\w+)=([A-Z][a-z]+)\((.*?)\)(\(\d+,\d+(?:;slb=\d+)?\)|Controllable\.)", text)
    assert "".join(f"{r}={o}({a}){s}" for r, o, a, s in found) == text
    return found


def as_tct_numbers(a: Automaton) -> Automaton:
    """Return ``a`` with its events in the order of their labels, and its states as they follow from that."""
    return oracle.sync(a, alphabet=Alphabet(a.alphabet[e] for e in sorted(a.alphabet.names, key=int)))


def replayed(
    result: str, operation: str, arguments: str, made: dict[str, Automaton | Supervisor]
) -> Automaton | Supervisor | None:
    """Return what an operation of the log makes."""
    names = arguments.split(",")
    given: list[Automaton] = [a for name in names if isinstance(a := made.get(name), Automaton)]
    match operation:
        case "Create":
            triples = re.findall(r"\[(\d+),(\d+),(\d+)\]", arguments)
            events = Alphabet(Event(str(k), k % 2 == 1) for k in sorted({int(e) for _, e, _ in triples}))
            states = sorted({q for s, _, t in triples for q in (s, t)}, key=int)
            marked = re.search(r"\[mark([\d,]*)\]", arguments)
            assert marked
            return Automaton.from_transitions(
                triples, initial="0", marked=marked[1].split(","), events=events, states=states, name=result
            )
        case "Edit":
            a = given[0]
            mark = a.marked.copy()
            for sign, q in re.findall(r"([+-])\[(\d+)\]", arguments):
                mark[int(q)] = sign == "+"
            return replace(a, marked=mark)
        case "Sync":
            return as_tct_numbers(thenar.sync(*given))
        case "Trim":
            return thenar.trim(given[0])
        case "Supcon":
            return thenar.supcon(given[0], over(given[1], given[0].alphabet))
        case "Condat":
            return thenar.condat(given[0], over(given[1], given[0].alphabet))
    return None


@needs_folder
def test_every_step_of_the_log_gives_the_sizes_that_it_says() -> None:
    made: dict[str, Automaton | Supervisor] = {}
    control: dict[str, Supervisor] = {}
    counted = 0
    for result, operation, arguments, says in steps():
        made_now = replayed(result, operation, arguments, made)
        if isinstance(made_now, Supervisor):
            plant, automaton = (made[name] for name in arguments.split(","))
            assert isinstance(plant, Automaton)
            assert isinstance(automaton, Automaton)
            assert says == "Controllable."
            assert thenar.is_controllable(over(automaton, plant.alphabet), plant)
            control[result] = made_now
        elif isinstance(made_now, Automaton):
            assert f"({made_now.n_states},{made_now.n_transitions})" == says, (result, operation)
            made[result] = made_now
        counted += made_now is not None
    assert counted == len(steps()) - sum(operation == "Supreduce" for _, operation, _, _ in steps())
    for name, ours in made.items():
        theirs = tct.loads((FOLDER / f"{name}.DES").read_bytes(), f"{name}.DES")
        assert isinstance(theirs, Automaton)
        assert isinstance(ours, Automaton)
        assert_same_numbering(theirs, over_what_occurs(ours))
    for name, supervisor in control.items():
        assert tct.loads_control_data((FOLDER / f"{name}.DAT").read_bytes(), name) == disabled(supervisor)


@needs_folder
def test_every_file_loads_or_says_what_it_is() -> None:
    files = [file for file in FOLDER.rglob("*") if file.suffix in (".DES", ".DAT")]
    assert files
    for file in files:
        if file.suffix == ".DAT":
            with pytest.raises(ModelError, match="control data"):
                tct.loads(file.read_bytes(), file.name)
        else:
            a = tct.loads(file.read_bytes(), file.name)
            assert isinstance(a, Automaton)
            assert said(tct.loads(written(a, "ctct"), file.name)) == said(a)
            if file.stem in ("M1", "TU", "B1", "GT", "ST", "G", "E", "K"):
                content = slice(46, len(written(a, "ctct")) - 16)  # between the size, undefined in TCT's, and the end
                assert written(a, "ctct")[content] == file.read_bytes()[content]


# -- damaged and hostile files -------------------------------------------------------------------------------


def message(**changes: object) -> bytes:
    """Return the MessagePack file of MACHINE with some fields changed."""
    return bytes(msgpack.packb({**msgpack.unpackb(written(MACHINE), strict_map_key=False), **changes}))


def binary(*numbers: int, signature: bytes = b"Z8^0L;1") -> bytes:
    """Return a narrow binary file with these numbers in its block."""
    return b"\x1a" + signature + b"\x55\xaa\x00\xff" + struct.pack(f"<{len(numbers)}i", *numbers)


ROW = {"marked": True, "next": None, "vocal": 0}


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"", "no DES or DAT file"),
        (b"PK\x03\x04", "no DES or DAT file"),
        (written(MACHINE, "ctct")[:70], "offset 0x42: the file ends within a transition"),
        (written(MACHINE, "ctct")[:60], "the list of marker states does not end"),
        (written(MACHINE, "x64")[:110], "truncated"),
        (written(MACHINE)[:-4], "no whole MessagePack file"),
        (binary(0, 0, 10**9, 0, -1, -1, -1), "1,000,000,000 states are declared"),
        (binary(0, 0, -5, 0, -1, -1, -1), "-5 states are declared"),
        (binary(0, 0, 2, 1, -1, -1, -1), "the initial state is 1"),
        (binary(0, 0, 2, 0, 2, -1, -1, -1), "a marker state is 2"),
        (binary(0, 0, 2, 0, -1, -1, 1, 20), "state 1 has a vocal output"),
        (binary(-1, 8, 0, 0), "no block of type 0"),
        (binary(7, -8, 0, 0), "no block of type 0"),
        (binary(7, 100, 0, 0), "the file ends within"),
        (binary(0, signature=b"Z8^0L;3"), "no known generation"),
        (b"\x1aZ8^0L;1\xff\x00\xaa\x55" + bytes(40), "of another machine"),
        (message(name="lib"), "not of 'libtct' '2.0'"),
        (message(version="3.0"), "not of 'libtct' '2.0'"),
        (message(size=4), "size is 4, and 3 states follow"),
        (message(size=True), "size is True"),
        (message(init=2), "the initial state is 2"),
        (message(states={0: ROW, 1: ROW, 5: ROW}), "not numbered 0 .. 2"),
        (message(size=1, states={0: {**ROW, "next": [[1, 1]]}}), "an entrance state is 1, and there is 1 state"),
        (message(size=1, states={0: {**ROW, "next": [[70000, 0]]}}), "a label is 70000, and labels end at 65,535"),
        (message(size=1, states={0: {**ROW, "next": [[1.0, 0]]}}), "whole numbers"),
        (message(size=1, states={0: {**ROW, "next": [[2**63, 0]]}}), "no whole MessagePack file|whole numbers"),
        (message(size=1, states={0: {**ROW, "next": [[1]]}}), "pairs"),
        (message(size=1, states={0: {**ROW, "next": 5}}), "pairs"),
        (message(size=1, states={0: {**ROW, "vocal": 12}}), "state 0 has a vocal output"),
        (message(size=1, states={0: {**ROW, "strange": 1}}), "the fields marked, next and vocal"),
        (message(size=1, states={0: 5}), "the fields marked, next and vocal"),
        (message(states=5), "no whole MessagePack file"),
        (b"\x85" + b"\xdd\xff\xff\xff\xff" * 2000, "no whole MessagePack file"),
        (b"\x85\xa4size" + b"\x81\x01" * 3000, "no whole MessagePack file"),
    ],
)
def test_a_bad_file_is_refused_with_a_sentence(data: bytes, what: str) -> None:
    with pytest.raises(ModelError, match=what):
        tct.loads(data, "bad.des")


def test_a_dat_file_is_no_automaton_and_the_reverse() -> None:
    with pytest.raises(ModelError, match=r"load its file \.DES"):
        tct.loads(message(init=-1), "S.DAT")
    with pytest.raises(ModelError, match=r"load its file \.DAT"):
        tct.loads_control_data(written(MACHINE), "S.DES")


def mutations(data: bytes) -> st.SearchStrategy[bytes]:
    """``data`` cut short, or with some bytes replaced."""

    def replaced(changes: list[tuple[int, bytes]]) -> bytes:
        new = bytearray(data)
        for place, piece in changes:
            new[place : place + len(piece)] = piece
        return bytes(new)

    cut = st.integers(0, len(data)).map(lambda n: data[:n])
    return cut | st.lists(st.tuples(st.integers(0, len(data)), st.binary(max_size=5)), min_size=1, max_size=4).map(
        replaced
    )


def only_refuses(load: Callable[[bytes, str], object], data: bytes) -> None:
    with suppress(InputError):
        load(data, "fuzzed")


@given(st.one_of(st.binary(max_size=80), *(mutations(written(MACHINE, generation)) for generation in GENERATIONS)))
def test_no_file_does_harm(data: bytes) -> None:
    only_refuses(tct.loads, data)
    only_refuses(tct.loads_control_data, data)
