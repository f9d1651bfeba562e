"""Work in a fresh process: its CPU seconds, its peak memory, and a limit on both."""

import contextlib
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

ROOT = Path(__file__).parents[1]
MEMORY_SHARE = 0.8  # of the machine's, that one process may have
STUCK = 5  # times its limit on CPU seconds, and a process is given up that does not use them


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a process said (its last line, JSON), the CPU seconds of its whole life, and how it ended if not well.

    One that is stopped may have said something before.
    """

    said: dict[str, Any]
    cpu_s: float
    trouble: str = ""

    def __bool__(self) -> bool:
        return not self.trouble


def fresh(module: str, *arguments: str, limit_s: float = 600) -> Outcome:
    """Run ``python -m module`` until it ends or has used ``limit_s`` seconds of CPU."""
    memory = int(MEMORY_SHARE * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            stdout=output,
            stderr=errors,
            cwd=ROOT,
            # one system call, which no thread of this process can disturb
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (memory, memory)),  # noqa: PLW1509
        )
        try:
            process.returncode, cpu_s, stopped = _watched(process.pid, limit_s)
        finally:
            if process.returncode is None:
                process.kill()
                process.wait()
        lines, complaints = _lines(output), _lines(errors)
    said: dict[str, Any] = {}
    with contextlib.suppress(ValueError, IndexError):
        said = json.loads(lines[-1])
    if stopped:
        return Outcome(said, cpu_s, f"> {limit_s:g} s")
    if process.returncode == 0 and said:
        return Outcome(said, cpu_s)
    errors_said = [line for line in complaints if re.match(r"[\w.]+: ", line)]  # TypeError: ..., not what follows
    return Outcome(said, cpu_s, (errors_said or complaints or [f"ended with {process.returncode}"])[-1][:80])


def _watched(pid: int, limit_s: float) -> tuple[int, float, bool]:
    """Wait for a process, and kill it at the limit; return its exit code, CPU seconds, and whether it was killed.

    RLIMIT_CPU would do that too, but under it Linux moves the process's own CPU clock only at each tick.
    """
    start, stopped = time.monotonic(), False
    while True:
        done, status, used = os.wait4(pid, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, stopped
        if not stopped and (_cpu_seconds(pid, start) > limit_s or time.monotonic() - start > STUCK * limit_s):
            stopped = True
            os.kill(pid, signal.SIGKILL)
        time.sleep(0.02)


def _cpu_seconds(pid: int, start: float) -> float:
    """Return what a process has used so far; where the system does not tell, how long it has run."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return time.monotonic() - start
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _lines(file: IO[bytes]) -> list[str]:
    file.seek(0)
    return file.read().decode(errors="replace").strip().splitlines()


def rebase() -> int:
    """Forget the peak of this process's memory so far, if the system can; return what it has now, in bytes."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
    return peak()


def peak() -> int:
    """Return the most memory that this process has had, in bytes."""
    # VmHWM, for on Linux ru_maxrss starts with what the parent had when it forked
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return int(line.split()[1]) * 1024
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def megabytes(size: float | None) -> str:
    return "-" if size is None else f"{size / 1e6:,.1f}"
