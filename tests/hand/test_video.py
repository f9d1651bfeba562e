"""The video: it shows the recorded trajectory, and where it cannot be made it says what is missing."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from thenar.errors import InputError
from thenar.hand import video
from thenar.hand.episode import Episode
from thenar.hand.video import captions, check_video, write_video

FPS, SIZE = 4, (320, 240)


@pytest.fixture(scope="module")
def library() -> str:
    try:
        return check_video()
    except InputError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def short(episode: Callable[..., Episode]) -> Episode:
    return episode("paper", "misaligned-thrice")


@pytest.fixture(scope="module")
def file(library: str, short: Episode, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("video") / "episode.mp4"
    write_video(path, short, fps=FPS, size=SIZE)
    return path


def read(path: Path) -> tuple[str, np.ndarray[Any, np.dtype[np.uint8]]]:
    """What ffmpeg says of the file, and its frames."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    frames = np.frombuffer(done.stdout, np.uint8).reshape(-1, SIZE[1], SIZE[0], 3)
    return done.stderr.decode(), frames


def test_the_video_is_as_long_as_the_run(file: Path, short: Episode) -> None:
    about, frames = read(file)
    assert all(said in about for said in ("Video: h264", f"{SIZE[0]}x{SIZE[1]}", f"{FPS} fps"))
    assert len(frames) == int(short.run.time_s * FPS) + 1
    assert file.read_bytes()[4:8] == b"ftyp"


def test_the_frames_show_what_moves_and_only_that(file: Path) -> None:
    _, frames = read(file)
    picture = frames[:, SIZE[1] // 6 :].astype(int)  # below the caption
    middle = SIZE[0] // 2
    changed = [np.abs(b - a).max(axis=2) > 60 for a, b in pairwise(picture)]
    still, first, second = changed[0], changed[2] | changed[3], changed[6] | changed[7]
    assert not still.any()  # the fingers are at rest for 0.4 s
    many, few = 100, 10  # pixels
    assert first[:, :middle].sum() > many  # then finger 1 comes, from the left
    assert first[:, middle:].sum() < few
    assert second[:, middle:].sum() > many  # finger 2 after 1.05 s
    assert second[:, :middle].sum() < few
    assert 40 < picture.mean() < 230


def test_the_same_episode_gives_the_same_bytes(file: Path, short: Episode) -> None:
    again = file.with_name("again.mp4")
    write_video(again, short, fps=FPS, size=SIZE)
    assert again.read_bytes() == file.read_bytes()


def test_a_caption_says_time_phase_and_last_event(short: Episode) -> None:
    lines = captions(short.run.entries, np.array([0.0, 1.0, 1.052, 2.2, 99.0]))
    assert [line.split() for line in lines] == [
        ["0.00", "s", "approach"],
        ["1.00", "s", "approach"],
        ["1.05", "s", "approach", "approach_1"],
        ["2.20", "s", "approach", "detect_misalignment"],
        ["99.00", "s", "approach", "retract_finger_2"],
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fps": 0}, "fps must be between 1 and 1000, not 0"),
        ({"size": (321, 240)}, "two even numbers"),
        ({"size": (320, 8000)}, "two even numbers"),
    ],
)
def test_a_rate_or_size_that_no_video_has_is_refused(
    short: Episode, tmp_path: Path, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        write_video(tmp_path / "episode.mp4", short, **options)
    assert not list(tmp_path.iterdir())


def test_a_path_that_cannot_be_written_is_refused_first(short: Episode, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no folder"):
        write_video(tmp_path / "nowhere" / "episode.mp4", short)


def test_without_the_package_the_message_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video, "find_spec", lambda name: None if name == "imageio_ffmpeg" else object())
    with pytest.raises(InputError, match=r"a video needs imageio-ffmpeg: pip install 'thenar\[video\]'"):
        check_video()


def test_without_an_opengl_library_the_message_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video, "find_spec", lambda name: object())
    monkeypatch.setattr(video, "LIBRARIES", ("no-such-library",))
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    with pytest.raises(InputError, match="there is none: apt install libosmesa6"):
        check_video()
    monkeypatch.setenv("MUJOCO_GL", "mesa-of-old")
    with pytest.raises(InputError, match="MUJOCO_GL=mesa-of-old does not work here: apt install libosmesa6"):
        check_video()


def test_a_rendering_that_fails_leaves_no_file_and_says_why(
    library: str, short: Episode, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(video, "check_video", lambda: library)
    monkeypatch.setattr(video, "FRAMES", "elsewhere.npy")  # the other process does not know of it
    path = tmp_path / "episode.mp4"
    path.write_bytes(b"before")
    with pytest.raises(InputError, match="could not be rendered: FileNotFoundError"):
        write_video(path, short, fps=1, size=SIZE)
    assert path.read_bytes() == b"before"
