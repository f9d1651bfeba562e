"""Redraw the pictures of the documentation; the same input gives the same bytes, and a test compares them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import thenar
from thenar.explicit.regular import concatenation, kleene_star
from thenar.explicit.timed import timed
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


def job() -> thenar.Automaton:
    """Return the job of docs/languages.md: pick and place, again and again."""
    pick = thenar.Automaton.from_transitions(
        ["away -close-> closed -slip-> away", "closed -hold-> held"],
        initial="away", marked=["held"], uncontrollable=["hold", "slip"], name="PICK",
    )  # fmt: skip
    place = thenar.Automaton.from_transitions(
        ["up -lower-> down -open-> away"], initial="up", marked=["away"], name="PLACE"
    )
    return kleene_star(concatenation(pick, place), name="JOB")


def street() -> thenar.Automaton:
    """Return the bus and the pedestrian of docs/timed.md."""
    bus = thenar.Automaton.from_transitions(
        ["coming -pass-> gone"], initial="coming", marked=["gone"], uncontrollable=["pass"], name="BUS"
    )
    man = thenar.Automaton.from_transitions(["road -jump-> curb"], initial="road", marked=["curb"], name="MAN")
    return thenar.sync(timed(bus, {"pass": (2, 2)}), timed(man, {"jump": (1, None)}))


def toss() -> thenar.Automaton:
    """Return the hand of docs/optimal.md: carry, or toss."""
    return thenar.Automaton.from_transitions(
        ["held -carry-> above -lower-> placed", "held -toss-> air -lands-> placed",
         "air -falls-> table -pick_up-> held"],
        initial="held", marked=["placed"], uncontrollable=["lands", "falls"], name="HAND",
    )  # fmt: skip


def press() -> thenar.Automaton:
    """Return the press of docs/fit-to-run.md, in which a part may come while the program decides."""
    return thenar.Automaton.from_transitions(
        ["empty -part-> ready -part-> jam -clear-> empty", "ready -press-> down -done-> empty"],
        initial="empty", marked=["empty"], uncontrollable=["part", "done"], name="PRESS",
    )  # fmt: skip


def pictures() -> Iterator[tuple[str, str]]:
    """Yield the file name and the SVG text of each picture."""
    yield "egg.svg", thenar.svg(egg())
    for automaton in glr.problem().automata:
        yield f"{automaton.name.lower()}.svg", thenar.svg(automaton)
    three = glr.problem(fingers=3)
    for name in ("FINGER1", "REFERENCE2"):
        yield f"{name.lower()}-of-three.svg", thenar.svg(three.automaton(name))
    yield "job.svg", thenar.svg(job())
    yield "pedestrian.svg", thenar.svg(street())
    yield "spec4-timed.svg", thenar.svg(glr.slip.spec4())
    yield "toss.svg", thenar.svg(toss())
    yield "press.svg", thenar.svg(press())


if __name__ == "__main__":
    for name, text in pictures():
        (HERE / "pictures" / name).write_text(text, encoding="utf-8")
