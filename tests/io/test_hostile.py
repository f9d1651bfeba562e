"""Hostile and damaged files of every format that is read: refused with a sentence, in bounded time and memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.fuzz.harness import SOURCE, check
from tests.fuzz.hostile import SECONDS
from tests.fuzz.seeds import dictionary, seeds, small_seeds

from thenar.errors import InputError
from thenar.io import dumps, load, loads
from thenar.io.foreign import tct
from thenar.io.formats import FORMATS, Format, format_named
from thenar.io.side import ENDING
from thenar.model.extended import ExtendedProblem

ROOT = Path(__file__).parents[2]
READ = [format for format in FORMATS if format.reads]
every_format = pytest.mark.parametrize("format", READ, ids=lambda format: format.name)
DEEP = 100_000


@cache
def valid(format: Format) -> list[bytes]:
    """Return valid files of some kilobytes at most."""
    return [seed for seed in seeds(format) if len(seed) < 4_000]


@cache
def words(format: Format) -> list[bytes]:
    """Return the words that the format's reader knows."""
    quoted = (line[1:-1].replace('\\"', '"') for line in dictionary(format.name).splitlines())
    return [word.encode().decode("unicode_escape").encode("latin-1", "ignore") for word in quoted]


# -- damaged files -------------------------------------------------------------------------------------------------


@every_format
def test_what_our_writers_write_is_read(format: Format) -> None:
    assert valid(format)
    for seed in seeds(format):
        loads(seed, format.name)
        check(seed, format.name)


@every_format
@given(data=st.data())
@settings(max_examples=100, deadline=None)
def test_any_bytes_are_read_or_refused(format: Format, data: st.DataObject) -> None:
    pieces = st.one_of(st.binary(max_size=40), st.sampled_from(words(format)), st.text(max_size=10).map(_encoded))
    check(b"".join(data.draw(st.lists(pieces, max_size=12))), format.name)


@every_format
@given(data=st.data())
@settings(max_examples=200, deadline=None)
def test_a_damaged_file_is_read_or_refused(format: Format, data: st.DataObject) -> None:
    content = data.draw(st.sampled_from(valid(format)))
    for _ in range(data.draw(st.integers(1, 4))):
        begin = data.draw(st.integers(0, len(content)))
        end = min(len(content), begin + data.draw(st.sampled_from([0, 1, 1, 2, 8, 100, 10_000])))
        other = data.draw(st.sampled_from(valid(format)))
        start = data.draw(st.integers(0, len(other)))
        splice = other[start : start + data.draw(st.sampled_from([1, 8, 100, 10_000]))]
        new = data.draw(st.one_of(st.binary(max_size=4), st.sampled_from(words(format)), st.just(splice)))
        content = content[:begin] + new + content[end:]
    check(content, format.name)


@every_format
def test_a_truncated_file_is_read_or_refused(format: Format) -> None:
    for seed in small_seeds(format):
        for length in range(0, len(seed), 1 if format.name == "tct" else 1 + len(seed) // 200):
            check(seed[:length], format.name)


def test_a_truncated_binary_is_never_read() -> None:
    for seed in small_seeds(format_named("tct")):
        marker = seed.rfind(b"\xff" * 4)  # what stands behind the last is not looked at
        for length in range(len(seed) - 1 if marker < 0 else marker - 8):
            with pytest.raises(InputError, match=SOURCE):
                loads(seed[:length], "tct", SOURCE)


@every_format
def test_every_flipped_bit_is_read_or_refused(format: Format) -> None:
    seed = min(small_seeds(format), key=len)
    for k in range(0, len(seed), 1 + len(seed) // 150):
        for bit in (1, 32, 128):
            check(seed[:k] + bytes([seed[k] ^ bit]) + seed[k + 1 :], format.name)


@given(data=st.data())
@settings(max_examples=300, deadline=None)
def test_damaged_control_data_is_read_or_refused(data: st.DataObject) -> None:
    automata = [seed for seed in valid(format_named("tct")) if b"\xa4init\x00" in seed]
    content = data.draw(st.sampled_from(automata)).replace(b"\xa4init\x00", b"\xa4init\xff")
    begin = data.draw(st.integers(0, len(content)))
    end = begin + data.draw(st.integers(0, 2))
    with suppress(InputError):
        tct.loads_control_data(content[:begin] + data.draw(st.binary(max_size=2)) + content[end:], SOURCE)


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", "surrogatepass")


# -- files made to hurt --------------------------------------------------------------------------------------------


@every_format
def test_a_hostile_file_is_refused_in_bounded_time_and_memory(format: Format) -> None:
    """In a process of its own with little memory, which prints a line for each file: name, seconds, what is wrong."""
    command = [sys.executable, "-m", "tests.fuzz.hostile", format.name]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    ran = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300, check=False)
    rows = [line.rsplit("\t", 2) for line in ran.stdout.splitlines()]
    assert ran.returncode == 0, f"ended within {rows[-1:]}: {ran.stderr[-2000:]}"
    assert len(rows) > 50
    assert not [row for row in rows if row[2]]
    assert not [row for row in rows if float(row[1]) > SECONDS]


# -- files beside files --------------------------------------------------------------------------------------------

PLANT = b"plant p: location: initial; marked; end\n"


def refused(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        load(path)
    assert str(path.parent) in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("way", ["../{}", "../models/../{}", "{parent}/{}", "./../{}", "link.cif", "folder/../../{}"])
def test_an_import_stays_in_its_folder(way: str, tmp_path: Path) -> None:
    folder = tmp_path / "models"
    (folder / "folder").mkdir(parents=True)
    (tmp_path / "secret.cif").write_bytes(PLANT)
    (folder / "link.cif").symlink_to("../secret.cif")
    name = way.format("secret.cif", parent=tmp_path)
    (folder / "a.cif").write_bytes(f'import "{name}";'.encode())
    assert "leaves the folder" in refused(folder / "a.cif")


@pytest.mark.parametrize("special", ["/dev/zero", "/dev/stdin", "/proc/self/environ", "/etc/passwd"])
def test_an_import_reads_no_device(special: str, tmp_path: Path) -> None:
    (tmp_path / "a.cif").write_bytes(f'import "{special}";'.encode())
    assert "leaves the folder" in refused(tmp_path / "a.cif")


def test_imports_that_import_one_another_end(tmp_path: Path) -> None:
    for k in range(200):
        (tmp_path / f"a{k}.cif").write_bytes(f'import "a{(k + 1) % 200}.cif";'.encode())
    assert "that import one another" in refused(tmp_path / "a0.cif")
    (tmp_path / "a1.cif").write_bytes(b'import "a0.cif";')
    assert "no way back" in refused(tmp_path / "a0.cif")


TABLES: list[str | bytes] = [
    b"",
    b"\0\xff\xfe",
    b"[" * DEEP,
    b'{"a":' * DEEP,
    b"null",
    b"[]",
    b"{}",
    b'{"kind": "plant", "name": ' + b"9" * 10_000 + b"}",
    b'{"kind": "plant", "name": "\\ud800"}',
    b'{"kind": "spec", "name": "A", "states": ["q", "q"]}',
    b'{"kind": "spec", "name": "A", "states": []}',
    b'{"kind": "spec", "name": "A", "states": [' + b'"q",' * DEEP + b'"q"]}',
    b'{"kind": "spec", "name": "A", "events": {}}',
    b'{"kind": "nothing", "name": "A"}',
    b'{"kind": "spec", "name": "A", "unknown": 1}',
    b'{"kind": "spec", "kind": "plant", "name": "A"}',
    *(
        json.dumps(
            {"kind": "plant", "name": "A", "events": {label: {"name": name} for label in ("on", "off", "1", "2")}}
        )
        for name in ("", " ", "a b", "ε", "one for all", 1, None)
    ),
    json.dumps({"name": "A", "events": {}, "automata": {}}).encode(),
    json.dumps({"events": {"on": {"name": "x"}, "off": {"name": "x"}}, "automata": {"LAMP": {"name": "A"}}}).encode(),
    json.dumps({"events": {"on": {"name": "x"}, "off": {"name": "y"}}, "automata": {"LAMP": {"name": ""}}}).encode(),
]


@pytest.mark.parametrize("format", [f for f in READ if f.module], ids=lambda format: format.name)
def test_a_hostile_table_of_names_is_read_or_refused(format: Format, tmp_path: Path) -> None:
    file = tmp_path / f"lamp{format.endings[0]}"
    file.write_bytes(next(iter(small_seeds(format))))
    beside = tmp_path / (file.name + ENDING)
    messages = []
    for table in TABLES:
        beside.write_bytes(table if isinstance(table, bytes) else table.encode())
        try:
            load(file, format=format.name)
        except InputError as error:
            messages.append(str(error))
    assert len(messages) > 10
    assert not [message for message in messages if beside.name not in message]


@pytest.mark.parametrize("name", ["", " ", "a b", "1", "ε", "true", "and", "open", "n", "a[b]", "\ud800", "x" * DEEP])
@pytest.mark.parametrize("ending", [".cif", ".wmod"])
def test_hostile_names_of_a_whole_problem_are_read_or_refused(ending: str, name: str, tmp_path: Path) -> None:
    file = tmp_path / f"cup{ending}"
    file.write_bytes(list(small_seeds(format_named(ending[1:])))[1])
    cup = load(file)
    assert isinstance(cup, ExtendedProblem)
    first, *others = cup.variables
    events = {e: {"name": e} for e in cup.alphabet.names}
    plain: dict[str, object] = {"events": events, "automata": {a.name: {"name": a.name} for a in cup.automata}}
    states = {a.name: {"name": a.name, "states": dict.fromkeys(a.states, name)} for a in cup.automata}
    tables: list[dict[str, object]] = [
        {"variables": {first.name: name}},
        {"variables": dict.fromkeys([v.name for v in cup.variables], name)},
        {"literals": dict.fromkeys(map(str, others[0].values), name)},
        {"automata": {a.name: {"name": name} for a in cup.automata}},
        {"automata": states},
        {"events": {e: {"name": name} for e in cup.alphabet.names}},
        {"name": name, "description": name},
    ]
    beside = tmp_path / (file.name + ENDING)
    messages = []
    for table in tables:
        beside.write_text(json.dumps(plain | table))
        try:
            renamed = load(file)
        except InputError as error:
            messages.append(str(error))
        else:
            with suppress(InputError):
                dumps(renamed, "json")
    assert not [message for message in messages if beside.name not in message]


@pytest.mark.parametrize("format", [f for f in READ if f.module], ids=lambda format: format.name)
def test_a_table_of_names_that_is_no_file_is_not_read(format: Format, tmp_path: Path) -> None:
    file = tmp_path / f"lamp{format.endings[0]}"
    file.write_bytes(next(iter(small_seeds(format))))
    (tmp_path / (file.name + ENDING)).symlink_to("/dev/zero")
    assert load(file, format=format.name).alphabet
