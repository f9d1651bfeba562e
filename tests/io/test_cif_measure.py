"""CIF texts that go on without measure, and imports that lead astray: one clear error, soon."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest

import thenar
from thenar.errors import InputError, ModelError
from thenar.io import cif


def mistakes(text: str) -> list[str]:
    with pytest.raises(ModelError) as caught:
        cif.loads(text, "m.cif")
    return [str(m) for m in caught.value.mistakes]


MANY = 100_000
EVENT = "controllable c;"
ROOM = "controllable c; plant p: disc int[0..9] n; disc bool b; {} location: initial; edge c when {}; end"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ROOM.format("", "(" * MANY + "b" + ")" * MANY), "nested deeper than 100"),
        (ROOM.format("", "not " * MANY + "b"), "nested deeper than 100"),
        (ROOM.format("", "if b: " * 3000 + "b" + " else b end" * 3000), "nested deeper than 100"),
        (ROOM.format("", " or ".join(["b"] * MANY)), "more than 50,000 operations"),
        (ROOM.format("", "n" + " - n" * 400 + " = 1"), "more than 150 operations in one another"),
        (ROOM.format("", "n = " + "9" * MANY), "is too large"),
        (
            ROOM.format(
                "alg int a0 = n; " + "".join(f"alg int a{k + 1} = a{k} + a{k}; " for k in range(40)), "a40 = 1"
            ),
            "more than 50,000 operations",
        ),
        (ROOM.format("disc int[0..2000000000] x;", "b"), "int[0..2000000000] has more than 1,000,000 values"),
        (ROOM.format("".join(f"disc int[0..999998] x{k};" for k in range(100)), "b"), "more than 2,000,000 values"),
        (f"input int[0..99999] x; {ROOM.format('', 'b')}", "an input variable with more than 10,000 values"),
        ("group def A(): x: A(); end y: A();", "definition 'A' holds an instance of itself"),
        ("a: b.D(); b: a.D();", "'a' is an instance of what has to be looked up in itself"),
        (
            "group def D(D g): end a: D(a.g); plant q: location: initial; marked a.g.x; end",
            "is a parameter that is given",
        ),
        ("alg bool x = y; alg bool y = x; plant q: location: initial; marked x; end", "'x' is defined by itself"),
        ("const int x = y, y = x; plant q: location: initial; marked x = 1; end", "'x' is defined by itself"),
        ("type a = b; type b = a; plant q: disc a v; location: initial; marked; end", "type 'a' is made of itself"),
        (
            "".join(
                f"group def A{k}(): " + "".join(f"x{j}: A{k + 1}(); " for j in range(10)) + "end " for k in range(9)
            )
            + "group def A9(): end z: A0();",
            "more than 20,000 components",
        ),
        ("group g: " * 5000 + "end " * 5000, "components nested deeper than 100"),
        ("print " + "// a comment\n" * 20_000, "ends too early"),
        ("@a(" * 50_000, "cannot stand here"),
        (
            f"plant p: disc bool b; location: initial; edge c do {'if b: ' * 999} b := b {'end ' * 999}; end {EVENT}",
            "ifs nested",
        ),
        ("x" * 5_000_001, "more than 5,000,000 characters"),
    ],
    ids=lambda value: value[:40] if value.count(" ") < 9 else "",
)
def test_a_text_without_measure_is_refused_soon(text: str, message: str) -> None:
    start = time.process_time()
    assert message in "\n".join(mistakes(text))
    assert time.process_time() - start < 15


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("../other.cif", "leaves the folder"),
        ("/etc/passwd", "leaves the folder"),
        ("link.cif", "leaves the folder"),
        ("main.cif", "that file imports this one already; an import has no way back"),
        ("back.cif", "that file imports this one already"),
        ("nowhere.cif", "no such file"),
        (".", "a folder, not a file"),
        ("", "write a path"),
        ("a\\\\b.cif", "write a path"),
        ("latin.cif", "not UTF-8 text: byte 0xe4"),
        ("wrong.cif", "wrong.cif:2:3: 'end' cannot stand here"),
    ],
)
def test_an_import_that_cannot_be_is_refused(tmp_path: Path, name: str, message: str) -> None:
    folder = tmp_path / "models"
    folder.mkdir()
    (tmp_path / "other.cif").write_text("controllable c;")
    (folder / "link.cif").symlink_to(tmp_path / "other.cif")
    (folder / "back.cif").write_text('import "main.cif";')
    (folder / "latin.cif").write_bytes("controllable c; // ä".encode("latin-1"))
    (folder / "wrong.cif").write_text("plant g:\n  end")
    (folder / "main.cif").write_text(f'import "{name}"; plant p: location: initial; end')
    with pytest.raises(InputError) as caught:
        cif.load(folder / "main.cif")
    assert message in str(caught.value)


def test_a_file_that_is_no_text_or_not_there_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.cif").write_bytes(b"\xff\xfe\x00")
    for name, message in (("x.cif", "not UTF-8"), ("y.cif", "no such file; did you mean 'x.cif'?")):
        with pytest.raises(InputError, match=re.escape(message)):
            thenar.load(tmp_path / name)


def test_a_cif_model_and_another_file_are_one_problem(tmp_path: Path) -> None:
    (tmp_path / "lamp.cif").write_text("controllable on; plant lamp: location: initial; marked; edge on; end")
    (tmp_path / "rule.toml").write_text(
        "[events]\non = {}\nrest = {}\n"
        '[automata.REST]\nkind = "plant"\ninitial = "0"\nmarked = ["0"]\ntransitions = ["0 -rest-> 0"]\n'
        '[automata.ONCE]\nkind = "spec"\ninitial = "0"\nmarked = ["0", "1"]\ntransitions = ["0 -on-> 1"]\n'
    )
    problem = thenar.load(tmp_path / "lamp.cif", tmp_path / "rule.toml")
    assert [a.name for a in problem.plants] == ["lamp", "REST"]
    assert thenar.synthesize(problem).size.states == 2
