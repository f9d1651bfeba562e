"""Files in and out: reading with a limit, writing all or nothing."""

from __future__ import annotations

import contextlib
import os
import secrets
import sys
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import BinaryIO, TypeAlias

from thenar.errors import InputError, did_you_mean

__all__ = ["MAX_BYTES", "atomic_write", "atomic_write_all", "check_writable", "read_bytes", "read_stdin"]

Data: TypeAlias = bytes | str | Iterable[str] | Iterable[bytes]

MAX_BYTES = 256 * 2**20  # bytes; some millions of transitions, and what a parser still holds in memory
_CHUNK = 2**20  # bytes read at a time, so that a stream without end stops soon after the limit
_NEIGHBOURS = 10_000  # names of a folder looked at for the nearest one


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """Return what the file at ``path`` holds.

    Raises InputError for a missing file (with the nearest name in its folder), a folder, a file above
    :data:`MAX_BYTES` (refused before it is read) and one that the system does not let us read.

    >>> read_bytes("nowhere/hand.toml")
    Traceback (most recent call last):
    thenar.errors.InputError: nowhere/hand.toml: no such file; there is no folder 'nowhere'
    """
    file = Path(path)
    try:
        if not file.exists():
            raise InputError(f"{path}: no such file{_nearest(file)}")
        if file.is_dir():
            raise InputError(f"{path}: a folder, not a file; name the model files in it")
        if (size := file.stat().st_size) > MAX_BYTES:
            raise InputError(f"{path}: {_too_large(f'{size:,} bytes')}")
        with file.open("rb") as stream:
            return _read(stream, str(path))
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        raise InputError(f"{path}: cannot be read: {_reason(error)}") from error


def read_stdin() -> bytes:
    """Return what standard input holds; InputError as soon as it passes :data:`MAX_BYTES`."""
    return _read(sys.stdin.buffer, "<stdin>")


def atomic_write(path: str | os.PathLike[str], data: Data) -> None:
    """Write ``data`` (text as UTF-8; whole, or piece by piece) to ``path``: then the file is all new, or untouched.

    The data goes to a temporary file in the same folder, which then takes the name ``path`` in one step;
    so neither a full disk nor a crash leaves half a file.  A symbolic link keeps pointing where it did.
    Raises InputError if the system does not let us write there, and for text that UTF-8 does not have.

    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp(), "lamp.toml")
    >>> atomic_write(file, ["name = ", "'lamp'"])
    >>> file.read_text()
    "name = 'lamp'"
    """
    atomic_write_all([(path, data)])


def atomic_write_all(files: Iterable[tuple[str | os.PathLike[str], Data]]) -> None:
    """Write several files as :func:`atomic_write` does one: the first takes its name when all are written.

    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> atomic_write_all([(folder / "a", "1"), (folder / "b", "2")])
    >>> sorted(file.name for file in folder.iterdir())
    ['a', 'b']
    """
    with contextlib.ExitStack() as stack:
        staged = []
        for path, data in files:
            with _complaining(path):
                target = Path(path).resolve()
                if target.exists() and not target.is_file() and not target.is_dir():
                    with target.open("wb") as stream:  # a device or a pipe: taking its name would destroy it
                        stream.writelines(_bytes(data))
                else:
                    staged.append((path, target, _stage(target, _bytes(data), stack)))
        for path, target, temporary in staged:
            with _complaining(path):
                os.replace(temporary, target)


def _stage(target: Path, content: Iterable[bytes], stack: contextlib.ExitStack) -> Path:
    """Write a temporary file beside ``target``, which goes when ``stack`` is closed, and return it."""
    temporary = target.parent / f".{secrets.token_hex(8)}.tmp"
    stack.callback(_remove, temporary)
    with temporary.open("xb") as stream:  # not tempfile: its files are private, a model file is not
        if target.is_file():
            temporary.chmod(target.stat().st_mode & 0o7777)
        stream.writelines(content)
        stream.flush()
        os.fsync(stream.fileno())
    return temporary


def _remove(temporary: Path) -> None:
    with contextlib.suppress(OSError):
        temporary.unlink(missing_ok=True)


def _bytes(data: Data) -> Iterator[bytes]:
    pieces = [data] if isinstance(data, bytes | str) else data
    return (piece.encode() if isinstance(piece, str) else piece for piece in pieces)


@contextlib.contextmanager
def _complaining(path: str | os.PathLike[str]) -> Iterator[None]:
    try:
        yield
    except UnicodeEncodeError as error:
        wrong = error.object[error.start : error.end]
        raise InputError(f"a name has the character {wrong!r}, which UTF-8 does not have; rename it") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written: {_reason(error)}") from error


def check_writable(path: str | os.PathLike[str]) -> None:
    """Raise InputError if ``path`` can hardly be written: to be asked before the work whose result goes there.

    >>> check_writable("nowhere/lamp.toml")
    Traceback (most recent call last):
    thenar.errors.InputError: nowhere/lamp.toml: cannot be written: there is no folder 'nowhere'
    """
    target = Path(path)
    if target.is_dir():
        raise InputError(f"{path}: cannot be written: it is a folder")
    if not target.parent.is_dir():
        raise InputError(f"{path}: cannot be written: there is no folder {str(target.parent)!r}")
    if not os.access(target if target.exists() else target.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written: no permission")


def _read(stream: BinaryIO, source: str) -> bytes:
    chunks: list[bytes] = []
    size = 0
    while chunk := stream.read(_CHUNK):
        chunks.append(chunk)
        size += len(chunk)
        if size > MAX_BYTES:
            raise InputError(f"{source}: {_too_large('it goes on')}")
    return b"".join(chunks)


def _too_large(size: str) -> str:
    limit = f"{MAX_BYTES:,} bytes ({MAX_BYTES // 2**20} MiB)"
    return f"larger than {limit}: {size}; split the model, several files load as one problem"


def _nearest(file: Path) -> str:
    if not file.parent.is_dir():
        return f"; there is no folder {str(file.parent)!r}"
    return did_you_mean(file.name, sorted(islice((p.name for p in file.parent.iterdir()), _NEIGHBOURS)))


def _reason(error: OSError | ValueError) -> str:
    return (isinstance(error, OSError) and error.strerror) or str(error)
