"""The log of a run: JSON lines, one entry a line, whole up to the last line whatever happens to the process."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol

from thenar.errors import InputError
from thenar.io.files import check_writable, read_bytes

__all__ = ["Entry", "Journal", "Log", "LogWriter", "Sink", "entry", "header", "read_log"]

FORMAT, VERSION = "thenar-log", 1
KINDS = ("begin", "event", "start", "abort", "stale", "violation", "prevented", "note", "end")
_STATES = ("plant_state", "supervisor_state")
_TEXTS = ("event", "plant", "chosen_by", "message", "why", "outcome", "policy")

Entry = dict[str, Any]


class Sink(Protocol):
    """What takes the entries of a run as they come: a LogWriter, or anything with its ``write``."""

    def write(self, entry: Mapping[str, Any]) -> None:
        """Take one entry."""


def header(task: str, *, events: Iterable[str], variant: str = "", seed: int = 0, **metadata: Any) -> Entry:
    """Return the first line of a log: what was run, ``metadata`` included, and the alphabet.

    No wall-clock time and no path belongs in it: the same run gives the same bytes.

    >>> header("glr", variant="paper", seed=7, scenario="nominal", events=["lift"])["scenario"]
    'nominal'
    """
    first = {"kind": "header", "format": FORMAT, "version": VERSION, "task": task, "variant": variant, "seed": seed}
    return {**first, **metadata, "events": list(events)}


def entry(kind: str, time_s: float, **fields: Any) -> Entry:
    """Return an entry: time in seconds to the microsecond, sensors to six significant digits, None for no number.

    >>> entry("event", 0.12345678, event="lift", sensors={"z_m": 0.0123456789, "force_n": float("nan")})
    {'kind': 'event', 't': 0.123457, 'event': 'lift', 'sensors': {'z_m': 0.0123457, 'force_n': None}}
    """
    if "sensors" in fields:
        fields["sensors"] = {name: _six_digits(value) for name, value in fields["sensors"].items()}
    return {"kind": kind, "t": round(time_s, 6) + 0.0, **fields}  # + 0.0: no minus zero


class Journal:
    """The entries of a run: kept, and passed on as they come to a log and to whoever watches.

    >>> seen = []
    >>> Journal(None, seen.append).note("start", 0.25, event="lift")
    >>> seen
    [{'kind': 'start', 't': 0.25, 'event': 'lift'}]
    """

    __slots__ = ("_on_entry", "_sink", "entries")

    def __init__(self, sink: Sink | None, on_entry: Callable[[Entry], object] | None) -> None:
        self._sink, self._on_entry = sink, on_entry
        self.entries: list[Entry] = []

    def note(self, kind: str, time_s: float, **fields: Any) -> None:
        """Make an entry of ``fields`` and hand it on."""
        found = entry(kind, time_s, **fields)
        self.entries.append(found)
        if self._sink is not None:
            self._sink.write(found)
        if self._on_entry is not None:
            self._on_entry(found)


class LogWriter:
    """Appends whole lines to a file, each at once: a killed process loses no line that was written.

    The file is begun, and an older one overwritten, with the first entry: a run that is refused before anything
    moves leaves no trace.  Raises InputError if the file cannot be written; a context manager.

    >>> import tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "run.jsonl")
    >>> with LogWriter(path, header("glr", events=["lift"])) as log:
    ...     log.write(entry("event", 0.5, event="lift"))
    >>> read_log(path).entries
    ({'kind': 'event', 't': 0.5, 'event': 'lift'},)
    """

    def __init__(self, path: str | os.PathLike[str], first: Mapping[str, Any]) -> None:
        check_writable(path)
        self.path, self._first, self._file = path, first, -1

    def write(self, entry: Mapping[str, Any]) -> None:
        """Append ``entry`` as one line; raises InputError if the system does not take it."""
        if self._file < 0:
            self._begin()
        self._append(entry)

    def _begin(self) -> None:
        try:
            self._file = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written: {error.strerror}") from error
        self._append(self._first)

    def _append(self, entry: Mapping[str, Any]) -> None:
        line = (json.dumps(entry, ensure_ascii=False, allow_nan=False) + "\n").encode("utf-8", "backslashreplace")
        try:
            while line:
                line = line[os.write(self._file, line) :]
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written: {error.strerror}") from error

    def close(self) -> None:
        """Close the file; may be called more than once."""
        if self._file >= 0:
            os.close(self._file)
        self._file = -1

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


@dataclass(frozen=True, slots=True)
class Log:
    """A log as it was read: entry k stands in line k + 2; ``torn`` is the half line that a kill left, or "".

    >>> Log("run.jsonl", {}, ({"kind": "end", "t": 1.5, "outcome": "complete"},)).end["outcome"]
    'complete'
    """

    source: str
    header: Entry
    entries: tuple[Entry, ...]
    torn: str = ""

    @property
    def end(self) -> Entry | None:
        """The last entry if it says how the run ended, None if the log breaks off."""
        return self.entries[-1] if self.entries and self.entries[-1]["kind"] == "end" else None


def read_log(path: str | os.PathLike[str]) -> Log:
    """Read a log; a last line that was cut off is reported in ``torn``, not an error.

    Raises InputError, naming file and line, for any other line that is no entry.

    >>> import tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "run.jsonl")
    >>> with open(path, "w") as file:
    ...     _ = file.write(json.dumps(header("glr", events=["lift"])) + '\\n{"kind": "event", "t": 0.1, "ev')
    >>> read_log(path).torn
    '{"kind": "event", "t": 0.1, "ev'
    """
    lines = read_bytes(path).split(b"\n")
    rest = lines.pop()  # empty, if the last line is whole
    first, *entries = [_parsed(line, f"{path}:{k}") for k, line in enumerate(lines, 1)] or [{}]
    if first.get("kind") != "header" or first.get("format") != FORMAT:
        raise InputError(f"{path}:1: not a {FORMAT}: its first line is no header")
    if first.get("version") != VERSION:
        raise InputError(f"{path}:1: version {first.get('version')!r} of {FORMAT}; this thenar reads version {VERSION}")
    for k, found in enumerate(entries, 2):
        if problem := _problem(found):
            raise InputError(f"{path}:{k}: {problem}")
    return Log(str(path), first, tuple(entries), rest.decode("utf-8", "replace"))


def _parsed(line: bytes, where: str) -> Entry:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: not a line of JSON: {error}") from None
    if not isinstance(value, dict):
        raise InputError(f"{where}: an entry is a JSON object")
    return value


def _problem(found: Entry) -> str:
    """Return what is wrong with an entry, "" if nothing is."""
    if found.get("kind") not in KINDS:
        return f"unknown kind {found.get('kind')!r}; there are: {', '.join(KINDS)}"
    t = found.get("t")
    if isinstance(t, bool) or not isinstance(t, (int, float)) or not math.isfinite(t):
        return f"the time t is {t!r}, no number"
    if found["kind"] in ("event", "violation") and "event" not in found:
        return "an event without a name"
    for name in _TEXTS:
        if not isinstance(found.get(name, ""), str):
            return f"{name} is {found[name]!r}, no text"
    for name in _STATES:
        if type(found.get(name, 0)) is not int:
            return f"{name} is {found[name]!r}, no whole number"
    enabled = found.get("enabled", [])
    if not (isinstance(enabled, list) and all(isinstance(e, str) for e in enabled)):
        return "enabled is no list of names"
    return ""


def _six_digits(value: float) -> float | None:
    return float(f"{value:.6g}") + 0.0 if math.isfinite(value) else None
