"""The file of a campaign: SQLite, a row an episode, and the configuration that they all have in common."""

from __future__ import annotations

import fcntl
import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import astuple, fields
from pathlib import Path
from types import TracebackType
from typing import Any

from thenar.errors import InputError
from thenar.hand.campaign.row import Row

__all__ = ["Store", "read_rows"]

FILE = "campaign.sqlite"
BUSY_S = 60.0  # how long a commit waits for another program that is just reading the file
_TYPES = {"int": "INTEGER", "bool": "INTEGER", "float": "REAL", "float | None": "REAL", "str": "TEXT"}
_COLUMNS = {f.name: str(f.type) for f in fields(Row)}


class Store:
    """The open file of a campaign, ours alone to write; a context manager.

    Each row is committed on its own: once :meth:`add` has returned, not even a power cut loses it.  Raises
    InputError if ``folder`` cannot be written, holds a campaign of another ``configuration``, or is in use.

    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with Store(folder, {"seed": "1"}) as store:
    ...     store.done()
    frozenset()
    >>> Store(folder, {"seed": "2"})
    Traceback (most recent call last):
    thenar.errors.InputError: ...: holds another campaign: seed is 1 there, 2 here; choose another folder
    """

    def __init__(self, folder: Path, configuration: Mapping[str, str]) -> None:
        self.path = folder / FILE
        self._lock = _locked(folder)
        try:
            with _readable(self.path):
                self._db = sqlite3.connect(self.path, timeout=BUSY_S)
            try:
                with _readable(self.path):
                    self._open(configuration)
            except BaseException:
                self._db.close()
                raise
        except BaseException:
            os.close(self._lock)
            raise

    def _open(self, configuration: Mapping[str, str]) -> None:
        """Check that the file is of this campaign; if it is new, make its tables in one step."""
        db = self._db
        tables = {name for (name,) in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        if not tables:
            columns = ", ".join(f"{name} {_TYPES[kind]}" for name, kind in _COLUMNS.items())
            columns = columns.replace("episode INTEGER", "episode INTEGER PRIMARY KEY", 1)
            with db:
                db.execute("BEGIN EXCLUSIVE")
                db.execute("CREATE TABLE configuration (name TEXT PRIMARY KEY, value TEXT)")
                db.execute(f"CREATE TABLE episodes ({columns})")
                db.executemany("INSERT INTO configuration VALUES (?, ?)", configuration.items())
        if tables and tables != {"configuration", "episodes"}:
            raise InputError(f"{self.path}: not the file of a campaign; choose another folder")
        there = dict(db.execute("SELECT name, value FROM configuration"))
        names = [*configuration, *(n for n in there if n not in configuration)]
        other = [
            f"{n} is {there.get(n, 'unknown')} there, {configuration.get(n, 'unknown')} here"
            for n in names
            if there.get(n) != configuration.get(n)
        ]
        if other:
            raise InputError(f"{self.path.parent}: holds another campaign: {'; '.join(other)}; choose another folder")

    def done(self) -> frozenset[int]:
        """Return the episodes that are in the file."""
        return frozenset(k for (k,) in self._db.execute("SELECT episode FROM episodes"))

    def rows(self, episodes: int) -> tuple[Row, ...]:
        """Return the rows up to ``episodes``, in order."""
        return _rows(self._db, episodes)

    def add(self, row: Row) -> None:
        """Keep ``row``."""
        values = astuple(row)
        try:
            with self._db:
                self._db.execute(f"INSERT INTO episodes VALUES ({', '.join('?' * len(values))})", values)
        except sqlite3.OperationalError as error:
            raise InputError(f"{self.path}: cannot be written: {error}") from error

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._db.close()
        os.close(self._lock)


def read_rows(path: str | os.PathLike[str]) -> tuple[Row, ...]:
    """Return all rows of a campaign's file, in the order of their episodes."""
    with _readable(path):
        # not mode=ro: after a kill, what was half written must first be rolled back
        db = sqlite3.connect(f"{Path(path).resolve().as_uri()}?mode=rw", uri=True, timeout=BUSY_S)
        try:
            return _rows(db, -1)
        finally:
            db.close()


def _rows(db: sqlite3.Connection, episodes: int) -> tuple[Row, ...]:
    names = ", ".join(_COLUMNS)
    where = "" if episodes < 0 else f"WHERE episode <= {episodes:d}"
    found = db.execute(f"SELECT {names} FROM episodes {where} ORDER BY episode")
    kinds = _COLUMNS.values()
    return tuple(_row([bool(v) if k == "bool" else v for v, k in zip(row, kinds, strict=True)]) for row in found)


def _row(values: list[Any]) -> Row:
    return Row(*values)


@contextmanager
def _readable(path: str | os.PathLike[str]) -> Iterator[None]:
    """Turn what SQLite complains of into one error that names the file."""
    try:
        yield
    except sqlite3.Error as error:
        raise InputError(f"{path}: cannot be used as the file of a campaign: {error}") from error


def _locked(folder: Path) -> int:
    """Return an open handle of ``folder``, locked; the lock goes with the process, however that ends."""
    handle = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        raise InputError(f"{folder}: another process is running a campaign there") from None
    return handle
