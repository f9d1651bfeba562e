"""What thenar finds on this machine."""

from __future__ import annotations

import platform
import shutil
import subprocess
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

__all__ = ["Finding", "examine"]

REQUIRED = (
    "numpy",
    "click",
    "rich",
    "pydantic",
    "tree-sitter-toml",
    "tree-sitter-json",
    "mujoco",
    "matplotlib",
    "mcap",
)


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing looked for: ``found`` is its version or place, empty if it is missing."""

    what: str
    found: str
    needed_for: str
    get: str
    required: bool = False


def examine() -> list[Finding]:
    """Return what is there and what is not, the required things first."""
    return [
        Finding("python", platform.python_version(), "everything", "install Python 3.11 or later", required=True),
        Finding("kernel", _kernel(), "everything", "pip install --force-reinstall thenar", required=True),
        *(Finding(name, _version(name), "everything", f"pip install {name}", required=True) for name in REQUIRED),
        Finding("dot", _dot(), "drawings laid out by Graphviz", "install Graphviz (Debian: apt-get install graphviz)"),
        Finding("imageio-ffmpeg", _version("imageio-ffmpeg"), "thenar run --video", "pip install 'thenar[video]'"),
        Finding("robosuite", _version("robosuite"), "thenar run --hand panda", "pip install 'thenar[panda]'"),
        Finding("distributed", _version("distributed"), "thenar campaign --scheduler", "pip install 'thenar[cluster]'"),
        Finding("hypothesis", _version("hypothesis"), "thenar.testing", "pip install 'thenar[testing]'"),
        Finding("pitct", _version("pitct"), "comparisons with TCT", "pip install 'thenar[oracles]'"),
        Finding("faudes", _version("faudes"), "comparisons with libFAUDES", "pip install 'thenar[oracles]'"),
    ]


def _kernel() -> str:
    """Return whether the kernel finds its way along a chain of two events."""
    try:
        from thenar.explicit.reach import shortest_trace
        from thenar.model.automaton import Automaton

        found = shortest_trace(Automaton.from_transitions(["a -x-> b -y-> c"], initial="a", marked=["c"]))
    except ImportError:
        return ""
    return "works" if str(found) == "x, y" else ""


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def _dot() -> str:
    path = shutil.which("dot")
    if path is None:
        return ""
    try:
        done = subprocess.run([path, "-V"], capture_output=True, text=True, timeout=5, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stderr.strip()
