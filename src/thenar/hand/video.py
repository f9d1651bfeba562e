"""An episode as a video: the recorded trajectory, rendered by a process of its own that has an OpenGL library.

MuJoCo chooses its OpenGL library (``MUJOCO_GL``) when it is imported, and by then a run has long imported it.  So
``python -m thenar.hand.video JOB`` renders in a fresh interpreter; the parent gives it a folder with the model, the
frames' joint positions and their captions.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.io.files import atomic_write, check_writable

if TYPE_CHECKING:
    from thenar.hand.episode import Episode

__all__ = ["check_video", "write_video"]

LIBRARIES = ("osmesa", "egl") if sys.platform == "linux" else ("",)  # "": MuJoCo's own choice
PACKAGES = {"imageio_ffmpeg": "imageio-ffmpeg", "PIL": "pillow"}
FOUND = "MUJOCO_GL works"
MODEL, FRAMES, JOB, VIDEO = "model.mjb", "frames.npy", "job.json", "video.mp4"
PROBE_S, FRAME_S = 30.0, 2.0  # s after which a process is given up: for the probe, and for each frame
LOOK_AT, DISTANCE_M, ELEVATION_DEG = (0.0, 0.0, 0.04), 0.28, -12.0  # both fingers at rest are in the picture
AMBIENT, DIFFUSE = 0.35, 0.45  # of the light at the camera
SKY = (0.80, 0.85, 0.92, 1.0)
SAMPLES, SHADOW_PX = 0, 1024  # with two samples a pixel, software OpenGL renders a third of the frames a second


def check_video() -> str:
    """Return the OpenGL library (a value of ``MUJOCO_GL``) that renders here.

    To be called before the run, so that the error comes before any work; about 1 s, once in a process.

    ``MUJOCO_GL`` is respected where it is set.  Raises InputError if the package that writes mp4 or every OpenGL
    library is missing, and says how to get it.
    """
    missing = [package for module, package in PACKAGES.items() if find_spec(module) is None]
    if missing:
        raise InputError(f"a video needs {' and '.join(missing)}: pip install 'thenar[video]'")
    chosen = os.environ.get("MUJOCO_GL")
    for library in (chosen,) if chosen else LIBRARIES:
        if _works(library):
            return library
    asked = f"MUJOCO_GL={chosen} does not work here" if chosen else "there is none"
    raise InputError(
        f"a video needs an OpenGL library, and {asked}: apt install libosmesa6 (or run without the video; "
        f"everything else needs none)"
    )


def write_video(
    path: str | os.PathLike[str], episode: Episode, *, fps: int = 30, size: tuple[int, int] = (960, 720)
) -> None:
    """Render what really happened in ``episode`` to an mp4 file (H.264), in real time, written all or nothing.

    ``size``: width and height in pixels, both even.  A caption shows time, phase and last event.  With a software
    OpenGL about 50 frames a second, so 8 s for an episode of 14 s.

    Raises InputError for a rate or a size that no video has, if the path cannot be written, and as
    :func:`check_video` does.
    """
    width, height = size
    if not 1 <= fps <= 1000:
        raise InputError(f"fps must be between 1 and 1000, not {fps!r}")
    if not all(16 <= n <= 4096 and n % 2 == 0 for n in size):
        raise InputError(f"size must be two even numbers of pixels between 16 and 4096, not {width} x {height}")
    check_writable(path)
    library = check_video()
    times = np.arange(int(episode.world.time_s * fps) + 1) / fps
    with tempfile.TemporaryDirectory(prefix="thenar-video-") as name:
        folder = Path(name)
        _prepare(folder, episode, times, {"fps": fps, "width": width, "height": height})
        done = _start(library, name, limit_s=PROBE_S + FRAME_S * len(times))
        if done.returncode:
            raise InputError(f"{path}: the video could not be rendered: {_last_line(done.stderr)}")
        atomic_write(path, (folder / VIDEO).read_bytes())


def captions(entries: Any, times: NDArray[np.float64]) -> list[str]:
    """Return for each time (s, ascending) the line to be shown: time, phase and last event.

    >>> captions([{"kind": "event", "t": 1.0, "event": "prox_make_C1"}], np.array([0.5, 1.5]))
    ['  0.50 s   approach', '  1.50 s   loading   prox_make_C1']
    """
    from thenar.hand.phases import phase_after

    events = [(entry["t"], entry["event"]) for entry in entries if entry["kind"] == "event"]
    found, phase, last, k = [], phase_after(None), "", 0
    for t in times:
        while k < len(events) and events[k][0] <= t:
            last = events[k][1]
            phase = phase_after(last, phase)
            k += 1
        found.append(f"{t:6.2f} s   {phase}   {last.removesuffix('*')}".rstrip())
    return found


def _prepare(folder: Path, episode: Episode, times: NDArray[np.float64], job: dict[str, Any]) -> None:
    """Write what the rendering process needs into ``folder``."""
    import mujoco

    world = episode.world
    mujoco.mj_saveModel(world.model, str(folder / MODEL), None)
    rows = np.clip(np.rint(times * 1000).astype(int) - 1, 0, world.ticks - 1)
    np.save(folder / FRAMES, world.trajectory[rows])
    job |= {"captions": captions(episode.run.entries, times)}
    (folder / JOB).write_text(json.dumps(job), encoding="utf-8")


def _start(library: str, argument: str, limit_s: float) -> subprocess.CompletedProcess[str]:
    """Run this module in a process with ``MUJOCO_GL=library``; one that takes longer than ``limit_s`` has failed."""
    environment = os.environ | ({"MUJOCO_GL": library} if library else {})
    command = [sys.executable, "-m", "thenar.hand.video", argument]
    try:
        return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=limit_s, check=False)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 1, "", f"it did not end within {limit_s:.0f} s")


@cache
def _works(library: str) -> bool:
    return FOUND in _start(library, "--probe", limit_s=PROBE_S).stdout


def _last_line(text: str) -> str:
    return (text.strip().splitlines() or ["no reason was given"])[-1]


# what follows runs in the process that has the OpenGL library


def _main(argument: str) -> None:
    if argument == "--probe":
        import mujoco

        model = mujoco.MjModel.from_xml_string("<mujoco/>")
        with mujoco.Renderer(model, 16, 16) as renderer:
            renderer.update_scene(mujoco.MjData(model))
            renderer.render()
        print(FOUND)
    else:
        _render(Path(argument))


def _render(folder: Path) -> None:
    import imageio_ffmpeg

    job = json.loads((folder / JOB).read_text(encoding="utf-8"))
    size = job["width"], job["height"]
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}", "-r", str(job["fps"]), "-i", "-"]
    coded = ["-c:v", "libx264", "-crf", "20", "-preset", "veryfast", "-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    bare = ["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"]  # neither date nor version
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", *raw, *coded, *bare, str(folder / VIDEO)]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as encoder:
        assert encoder.stdin is not None
        for picture in _pictures(folder, size, job["captions"]):
            encoder.stdin.write(picture)
    if encoder.returncode:
        sys.exit(f"ffmpeg ended with {encoder.returncode}")


def _pictures(folder: Path, size: tuple[int, int], captions: list[str]) -> Iterator[bytes]:
    """Yield each frame: height rows of width pixels of three bytes."""
    import mujoco
    from PIL import Image, ImageDraw, ImageFont

    model = mujoco.MjModel.from_binary_path(str(folder / MODEL))
    data = mujoco.MjData(model)
    width, height = size
    model.vis.global_.offwidth, model.vis.global_.offheight = size
    model.vis.quality.offsamples, model.vis.quality.shadowsize = SAMPLES, SHADOW_PX
    model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = AMBIENT, DIFFUSE
    option = mujoco.MjvOption()
    option.sitegroup[:] = 0
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance = LOOK_AT, DISTANCE_M
    camera.azimuth, camera.elevation = 90.0, ELEVATION_DEG
    font = ImageFont.load_default(size=max(height // 30, 10))
    margin = height // 36
    with mujoco.Renderer(model, height, width) as renderer:
        for qpos, caption in zip(np.load(folder / FRAMES), captions, strict=True):
            data.qpos[:] = qpos
            mujoco.mj_kinematics(model, data)
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera, option)
            _add_sky(mujoco, renderer.scene)
            frame = Image.fromarray(renderer.render())
            ImageDraw.Draw(frame).text(
                (margin, margin), caption, fill=(31, 35, 40), font=font, stroke_width=2, stroke_fill=(255, 255, 255)
            )
            yield frame.tobytes()


def _add_sky(mujoco: Any, scene: Any) -> None:
    """Put a bright wall behind everything: without a sky MuJoCo's background is black."""
    wall = scene.geoms[scene.ngeom]
    pose = np.array([0.0, 1.5, 0.0]), np.eye(3).ravel()
    mujoco.mjv_initGeom(wall, mujoco.mjtGeom.mjGEOM_BOX, np.array([5.0, 0.01, 5.0]), *pose, np.array(SKY, np.float32))
    wall.emission = 0.3
    scene.ngeom += 1


if __name__ == "__main__":
    _main(sys.argv[1])
