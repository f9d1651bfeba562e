import os
import shutil
from pathlib import Path
from time import perf_counter

import pytest

from thenar.library.glr import finger
from thenar.model.automaton import Automaton
from thenar.render.graphviz import graphviz_or_own
from thenar.render.layout import layered
from thenar.render.scene import scene
from thenar.render.svg import svg


@pytest.fixture
def fake_dot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program called dot, the only one on PATH; write a shell script into it."""
    program = tmp_path / "dot"
    program.write_text("")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}/bin{os.pathsep}/usr/bin")
    return program


def test_a_slow_dot_is_not_waited_for(fake_dot: Path) -> None:
    fake_dot.write_text("#!/bin/sh\nexec sleep 60\n")
    picture = scene(finger(1))
    start = perf_counter()
    layout = graphviz_or_own(picture, time_limit=0.2)
    assert perf_counter() - start < 5
    assert layout.engine == "own (dot took longer than 0.2 s)"
    assert (layout.boxes, layout.routes) == (layered(picture).boxes, layered(picture).routes)


@pytest.mark.parametrize(
    "script",
    [
        "exit 3",
        "echo nonsense",
        "echo '{}'",
        "echo '[]'",
        """echo '{"bb": "0,0,9,9", "objects": []}'""",
        "echo '\\377'",
    ],
)
def test_a_dot_that_fails_is_replaced(fake_dot: Path, script: str) -> None:
    fake_dot.write_text(f"#!/bin/sh\ncat >/dev/null\n{script}\n")
    assert 'data-layout="own (dot failed)"' in svg(finger(1), layout="dot")


def test_dot_is_not_needed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert 'data-layout="own (dot is not installed)"' in svg(finger(1), layout="dot")


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
def test_dot_draws_the_same_scene() -> None:
    hostile = Automaton.from_transitions(
        [("a", "x", 'b"];'), ('b"];', "</table>", "a"), ("a", "loop", "a")], initial="a", uncontrollable=["x"]
    )
    for automaton in (finger(1), hostile):
        picture = scene(automaton, path=automaton.alphabet.names[0])
        layout = graphviz_or_own(picture)
        assert layout.engine == "dot"
        assert layout.entry is not None
        assert len(layout.boxes) == len(picture.nodes)
        assert all(route.label for route in layout.routes)
        assert not any(a.overlaps(b) for k, a in enumerate(layout.boxes) for b in layout.boxes[:k])
        assert 'data-layout="dot"' in svg(automaton, layout="dot")
