"""The picture of an episode: it shows what the log says, no two names touch, and it is the same each time."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from PIL import Image

from thenar.errors import InputError
from thenar.hand.episode import Episode
from thenar.hand.picture import Mark, draw_episode, figure, marks, phases, save, spread

Episodes = Callable[..., Episode]
SHOWN = [
    ("paper", "nominal"),
    ("paper", "misaligned-thrice"),
    ("paper", "too-heavy"),
    ("paper", "shaken"),
    ("paper", "missing"),
    ("extended", "table-gone"),
]


@cache
def drawn(episode: Episodes, variant: str, name: str) -> Figure:
    return figure(episode(variant, name), scenario=name)


def texts(picture: Figure, axes: int) -> list[Any]:
    return [t for t in picture.axes[axes].texts if t.get_text()]


def corners(text: Any, renderer: Any) -> np.ndarray[Any, Any]:
    """The corners of a slanted text, in pixels, in a frame that lies along it."""
    angle = text.get_rotation()
    anchor = text.get_transform().transform(text.get_position())
    text.set_rotation(0.0)
    box = text.get_window_extent(renderer).get_points() - anchor
    text.set_rotation(angle)
    turn = np.radians(angle)
    along = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) @ anchor
    found: np.ndarray[Any, Any] = box + along
    return found


@pytest.mark.parametrize(("variant", "name"), SHOWN)
def test_no_two_names_overlap_and_none_leaves_the_page(episode: Episodes, variant: str, name: str) -> None:
    picture = drawn(episode, variant, name)
    renderer = picture.canvas.get_renderer()  # type: ignore[attr-defined]
    names = texts(picture, 0)
    assert len(names) == len(marks(episode(variant, name).run.entries)) > 0
    boxes = [corners(text, renderer) for text in names]
    for (low, high), (next_low, next_high) in pairwise(boxes):  # all lean alike, and come in order
        apart = low[1] >= next_high[1] or high[0] <= next_low[0] or next_high[0] <= low[0]
        assert apart
    page = picture.bbox
    everywhere = [*names, *texts(picture, 1), *picture.texts]
    for text in everywhere:
        box = text.get_window_extent(renderer)
        assert page.x0 <= box.x0
        assert box.x1 <= page.x1
        assert box.y1 <= page.y1
    top = min(text.get_window_extent(renderer).y0 for text in picture.texts)
    assert max(text.get_window_extent(renderer).y1 for text in names) <= top


@pytest.mark.parametrize(("variant", "name"), SHOWN)
def test_the_names_of_phases_do_not_overlap(episode: Episodes, variant: str, name: str) -> None:
    picture = drawn(episode, variant, name)
    renderer = picture.canvas.get_renderer()  # type: ignore[attr-defined]
    boxes = sorted((t.get_window_extent(renderer) for t in texts(picture, 1)), key=lambda box: float(box.x0))
    assert boxes
    for box, after in pairwise(boxes):
        assert box.x1 <= after.x0 or not (box.y0 < after.y1 and after.y0 < box.y1)


def test_the_phases_of_a_complete_run_are_the_papers(episode: Episodes) -> None:
    run = episode().run
    found = phases(run.entries, run.time_s)
    assert [name for name, _, _ in found] == [
        "approach", "loading", "manipulation", "squeezing", "replace", "unloading", "release",
    ]  # fmt: skip


@pytest.mark.parametrize(("variant", "name"), SHOWN)
def test_the_phases_cover_the_run_without_a_gap(episode: Episodes, variant: str, name: str) -> None:
    run = episode(variant, name).run
    found = phases(run.entries, run.time_s)
    assert found[0][1] == 0.0
    assert found[-1][2] == run.time_s
    for (phase, _, end), (after, begin, _) in pairwise(found):
        assert end == begin
        assert phase != after
    assert len(phases([], 1.0)) == 1


def test_a_mark_says_what_kind_of_event_it_is(episode: Episodes) -> None:
    found = {mark.name: mark.kind for mark in marks(episode().run.entries)}
    assert found["remote_breakC"] == found["prox_make_C1"] == "contact"
    assert found["incip_slip"] == "surprise"
    assert found["move_to_Z"] == "other"
    assert marks(episode("paper", "missing").run.entries)[-1] == Mark(6.164, "safe stop", "surprise")
    assert marks([{"kind": "violation", "t": 1.0, "event": "incip_slip*"}])[0].name == "violation: incip_slip"


@given(st.lists(st.floats(0, 100), max_size=40).map(sorted), st.floats(0.1, 10))
def test_spread_places_are_apart_within_and_nearest(wanted: list[float], gap: float) -> None:
    places = spread(wanted, gap, 0.0, 100.0)
    assert len(places) == len(wanted)
    gap = min(gap, 100.0 / max(len(wanted) - 1, 1))
    assert all(b - a >= gap - 1e-9 for a, b in pairwise(places))
    assert all(-1e-9 <= x <= 100 + 1e-9 for x in places)
    # nearest: no other arrangement is cheaper (the problem is convex: a small step towards any of a few suffices)
    cost = sum((x - w) ** 2 for x, w in zip(places, wanted, strict=True))
    even = [k * 100.0 / max(len(wanted) - 1, 1) for k in range(len(wanted))]
    packed = [k * gap for k in range(len(wanted))]
    for other in (even, packed, [x + 100.0 - packed[-1] for x in packed]):
        mixed = [0.99 * x + 0.01 * y for x, y in zip(places, other, strict=True)]
        assert cost <= sum((x - w) ** 2 for x, w in zip(mixed, wanted, strict=True)) + 1e-6


def test_a_place_that_is_free_is_taken() -> None:
    assert spread([10.0, 20.0, 90.0], 5.0, 0.0, 100.0) == [10.0, 20.0, 90.0]
    assert spread([], 5.0, 0.0, 100.0) == []


def test_the_panels_show_the_recording_and_the_truth(episode: Episodes) -> None:
    shown = episode()
    grip, load, height, _ = figure(shown).axes[2:]
    assert np.array_equal(height.lines[0].get_ydata(), 1e3 * shown.truth.height_m)
    lines = {str(line.get_label()): np.asarray(line.get_ydata()) for axes in (grip, load) for line in axes.lines}
    assert np.array_equal(lines["command"], shown.recording[:, shown.channels.index("grip_command")])
    up = next(round(1000 * e["t"]) for e in shown.run.entries if e["kind"] == "event" and e["event"] == "move_to_Z*")
    held = slice(up - 300, up)  # in the air: both fingers carry the weight, and press as they are told
    assert lines["both fingers"][held].mean() == pytest.approx(shown.block.weight_n, rel=0.02)
    for i in (1, 2):
        assert lines[f"finger {i}"][held] == pytest.approx(lines["command"][held], abs=0.15)


def test_the_title_says_how_it_went_and_what_was_found(episode: Episodes) -> None:
    said = [t.get_text() for t in figure(episode("extended", "table-gone"), scenario="table-gone").texts]
    assert said[0] == "scenario table-gone, seed 1: gave up; in truth dropped"
    assert said[1].startswith("ended in marked state")
    assert "± " in said[2]
    assert "truth" in said[2]
    for name, truth in (
        ("nominal", "complete; in truth lifted and replaced"),
        ("too-heavy", "gave up; in truth not lifted"),
    ):
        assert drawn(episode, "paper", name).texts[0].get_text() == f"scenario {name}, seed 1: {truth}"
    assert drawn(episode, "paper", "missing").texts[0].get_text().endswith("stopped; in truth there was no object")
    assert figure(episode("paper", "misaligned-thrice")).texts[0].get_text().startswith("seed 1: gave up")


def test_the_same_episode_gives_the_same_bytes_whatever_the_settings(episode: Episodes) -> None:
    import matplotlib

    shown = episode("paper", "misaligned-thrice")
    picture = draw_episode(shown)
    with matplotlib.rc_context({"font.size": 20.0, "axes.facecolor": "black", "savefig.dpi": 30}):
        assert draw_episode(shown) == picture
    image = Image.open(BytesIO(picture))
    assert image.size == (1650, 1290)
    assert not any(key in image.info for key in ("Software", "Creation Time", "date"))


def test_pyplot_is_not_needed(episode: Episodes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    assert draw_episode(episode("paper", "misaligned-thrice"))


def test_save_is_all_or_nothing(episode: Episodes, tmp_path: Path) -> None:
    save(tmp_path / "episode.png", episode("paper", "misaligned-thrice"))
    assert (tmp_path / "episode.png").read_bytes() == draw_episode(episode("paper", "misaligned-thrice"))
    with pytest.raises(InputError, match="cannot be written"):
        save(tmp_path / "nowhere" / "episode.png", episode("paper", "misaligned-thrice"))
