"""Redraw the pictures of the documentation; the same input gives the same bytes, and a test compares them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import thenar
from thenar.library import glr

HERE = Path(__file__).parent


def readme_example() -> str:
    """Return the Python example of the README."""
    readme = (HERE.parent / "README.md").read_text(encoding="utf-8")
    found = re.search(r"```python\n(.*?)```", readme, re.DOTALL)
    assert found is not None
    return found[1]


def egg() -> Any:
    """Return the supervisor of the README's example."""
    names: dict[str, Any] = {"print": lambda *_: None}
    exec(readme_example(), names)
    return names["result"].supervisor


def pictures() -> Iterator[tuple[str, str]]:
    """Yield the file name and the SVG text of each picture."""
    yield "egg.svg", thenar.svg(egg())
    for automaton in glr.problem().automata:
        yield f"{automaton.name.lower()}.svg", thenar.svg(automaton)
    three = glr.problem(fingers=3)
    for name in ("FINGER1", "REFERENCE2"):
        yield f"{name.lower()}-of-three.svg", thenar.svg(three.automaton(name))


if __name__ == "__main__":
    for name, text in pictures():
        (HERE / "pictures" / name).write_text(text, encoding="utf-8")
