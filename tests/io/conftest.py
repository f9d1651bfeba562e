"""A small model to make mistakes in, and the promise that each message is shown in the documentation."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from thenar.errors import InputError
from thenar.io import load, loads

DOCUMENTATION = (Path(__file__).parents[2] / "docs" / "model-file.md").read_text()

HAND = """\
[events]
approach_1 = {}
slip = { controllable = false }

[automata.FINGER1]
kind = "plant"
initial = "neutral"
marked = ["neutral"]
transitions = [
  "neutral -approach_1-> near",
  "near -slip-> neutral",
]
"""

CUP = """\
[events]
fill = {}
pour = {}

[variables]
stock = { values = "0..5" }
lamp = { values = ["red", "green"] }

[automata.CUP]
kind = "plant"
initial = "up"
marked = ["up"]
transitions = [
  { arrow = "up -fill-> up", when = "stock < 3", do = { stock = "stock + 1" } },
  "up -pour-> down",
]

[[conditions]]
kind = "spec"
invariant = "stock < 5"

[[conditions]]
kind = "spec"
event = "pour"
needs = "CUP.up and stock > 0"
"""

Hand = Callable[[str, str], str]
Says = Callable[..., None]


@pytest.fixture
def hand() -> Hand:
    """The small model with one piece of its text replaced."""

    def replaced(old: str, new: str) -> str:
        assert old in HAND
        return HAND.replace(old, new)

    return replaced


@pytest.fixture
def cup() -> Callable[..., str]:
    """A small model with variables and conditions, pieces of its text replaced: old, new, old, new ..."""

    def replaced(*replacements: str) -> str:
        text = CUP
        for old, new in zip(replacements[::2], replacements[1::2], strict=True):
            assert old in text
            text = text.replace(old, new, 1)
        return text

    return replaced


@pytest.fixture
def says() -> Says:
    """Assert that reading a text, called hand.toml or hand.json, fails with exactly one message."""

    def check(text: str, *messages: str, format: str = "toml", error: type[InputError] = InputError) -> None:
        with pytest.raises(error) as caught:
            loads(text, format, f"hand.{format}")
        _compare(str(caught.value), messages)

    return check


@pytest.fixture
def files_say(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Says:
    """Assert that loading files, in a folder of their own, fails with exactly one message."""

    def check(
        files: dict[str, str | bytes],
        *messages: str,
        load_names: tuple[str | os.PathLike[str], ...] | None = None,
        error: type[InputError] = InputError,
    ) -> None:
        monkeypatch.chdir(tmp_path)
        for name, content in files.items():
            Path(name).write_bytes(content.encode() if isinstance(content, str) else content)
        with pytest.raises(error) as caught:
            load(*(tuple(files) if load_names is None else load_names))
        _compare(str(caught.value), messages)

    return check


def _compare(message: str, expected: tuple[str, ...]) -> None:
    n = len(expected)
    counted = [f"{line}   ({k} of {n} problems)" if n > 1 else line for k, line in enumerate(expected, 1)]
    assert message.split("\n") == counted
    undocumented = [line for line in expected if _reason(line) not in DOCUMENTED]
    assert not undocumented, "docs/model-file.md shows every kind of message"


def _reason(line: str) -> str:
    """Return what a message says apart from the place, the names and the numbers."""
    line = re.sub(r"'[^']*'", "'_'", re.sub(r"\d[\d,]*", "0", line))
    return re.sub(
        r"^([\w.<>/, -]+(:0)*: )?((event|automaton|variable|computed size|published size) '_'(, [\w' ]+)*: "
        r"|condition 0,?( \w+)?: |\w+: )?",
        "",
        line,
    )


DOCUMENTED = {_reason(re.sub(r"   \(\d+ of .*", "", line)) for line in DOCUMENTATION.split("\n")}


@pytest.fixture
def glr() -> Path:
    """The Grasp-Lift-Replace task as it was first recorded: in JSON, all triples, with sizes for reference."""
    return Path(__file__).parent / "data" / "grasp_lift_replace.json"
