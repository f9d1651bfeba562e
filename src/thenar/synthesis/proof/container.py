"""The file of a certificate, and the problem that it states; every reader of it is as strict as this one."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thenar.errors import CertificateError

__all__ = [
    "FORMAT",
    "Arrays",
    "Automaton",
    "Ints",
    "Mask",
    "Statement",
    "Wrong",
    "claim",
    "digest",
    "ints",
    "mask",
    "read",
]

FORMAT = b"thenar certificate 1"  # the first line of the file; the second is the digest of the rest
MAX_BYTES = 4 << 30  # a file that is larger, packed or unpacked, is refused before it is read
CHUNK = 1 << 24

Arrays = Mapping[str, NDArray[Any]]
Mask = NDArray[np.bool_]
Ints = NDArray[np.int64]


class Wrong(Exception):
    """What the certificate gets wrong."""


def claim(holds: bool, otherwise: str) -> None:
    """Raise Wrong with ``otherwise`` unless ``holds``."""
    if not holds:
        raise Wrong(otherwise)


def read(path: str | Path) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Return the arrays and the header of a certificate; raise CertificateError if it is none, or damaged."""
    try:
        with Path(path).open("rb") as stream:
            chunks = iter(lambda: stream.read(CHUNK), b"")
            file = b"".join(islice(chunks, MAX_BYTES // CHUNK + 1))  # /dev/zero has an end here
    except OSError as error:
        raise CertificateError(f"{path}: {error.strerror or error}") from None
    magic, claimed, archive = (*file.split(b"\n", 2), b"", b"")[:3]
    if magic != FORMAT or len(file) > MAX_BYTES:
        raise CertificateError(f"{path}: not a certificate; write one with 'thenar synth MODEL --certificate FILE'")
    if claimed != digest(archive):
        raise CertificateError(f"{path}: damaged: the contents do not match their digest")
    try:
        with zipfile.ZipFile(io.BytesIO(archive)) as members:
            size = sum(member.file_size for member in members.infolist())
        if size > MAX_BYTES:
            raise CertificateError(f"{path}: unpacks to {size:,} bytes, more than the {MAX_BYTES:,} that are read")
        with np.load(io.BytesIO(archive), allow_pickle=False) as loaded:
            arrays = {name: loaded[name] for name in loaded.files}
        header = json.loads(arrays.pop("header").tobytes())
        if not isinstance(header["problem"], str):
            raise TypeError
    except CertificateError:
        raise
    except (ValueError, KeyError, TypeError, OSError, EOFError, MemoryError, zipfile.BadZipFile, zlib.error):
        raise CertificateError(f"{path}: malformed: its digest is right, but its contents are no certificate") from None
    return arrays, header


def digest(archive: bytes) -> bytes:
    """Return the SHA-256 of the contents, as it stands in the second line of the file."""
    return hashlib.sha256(archive).hexdigest().encode()


def ints(arrays: Arrays, name: str, ndim: int = 1) -> Ints:
    """Return an array of whole numbers, checked to be one."""
    array = arrays.get(name)
    if array is None or array.ndim != ndim or array.dtype.kind not in "iu":
        raise Wrong(f"malformed: {name}")
    claim(bool((array <= np.iinfo(np.int32).max).all()), f"malformed: {name}")
    return array.astype(np.int64)


def mask(arrays: Arrays, name: str) -> Mask:
    """Return an array of truths, checked to be one."""
    array = ints(arrays, name)
    claim(bool(((array == 0) | (array == 1)).all()), f"malformed: {name}")
    return array.astype(np.bool_)


@dataclass(frozen=True, slots=True)
class Automaton:
    """An automaton of the problem: transition k leads from ``source[k]`` by ``events[k]`` to ``targets[k]``.

    ``own`` (n_events,) are the events of its alphabet, ``marked`` (n_states,) its marked states; deterministic.
    """

    name: str
    plant: bool
    initial: int
    own: Mask
    marked: Mask
    source: Ints
    events: Ints
    targets: Ints


class Statement:
    """The problem that a certificate is about; raises Wrong if it is none.

    * ``events``: their names; ``free``: for each whether it is uncontrollable
    * ``automata``: plants and specifications
    """

    def __init__(self, arrays: Arrays, header: dict[str, Any]) -> None:
        self.arrays, self.header = arrays, header
        self._check_header()
        self.events: list[str] = [e["name"] for e in header["events"]]
        self.free: list[bool] = [not e["controllable"] for e in header["events"]]
        self.automata = [self._automaton(k, a) for k, a in enumerate(header["automata"])]
        claim(any(a.plant for a in self.automata), "malformed: nothing to check")

    def is_that_of(self, arrays: Arrays, header: dict[str, Any]) -> bool:
        """Return whether the other arrays and header state the same problem."""

        def written(h: dict[str, Any]) -> str:  # as text, for Python takes 0 for False
            return json.dumps([h["events"], h["automata"]], sort_keys=True)

        return written(self.header) == written(header) and all(
            name in self.arrays and np.array_equal(self.arrays[name], array) for name, array in arrays.items()
        )

    def state(self, coordinates: list[int]) -> str:
        """Return how a state of the product is written: the number of the state of each automaton."""
        return ", ".join(f"{a.name}:{q}" for a, q in zip(self.automata, coordinates, strict=True))

    def _check_header(self) -> None:
        """Hold the header to its types: what is not exactly so is not read with good will."""
        fields = {"events": {"name": str, "controllable": bool}, "automata": {"name": str, "kind": str, "initial": int}}
        for part, wanted in fields.items():
            entries = self.header.get(part)
            claim(isinstance(entries, list), f"malformed: {part}")
            for entry in entries or ():
                fits = isinstance(entry, dict) and {k: type(v) for k, v in entry.items()} == wanted
                claim(fits, f"malformed: {part}")
        kinds = {a["kind"] for a in self.header["automata"]}
        claim(kinds <= {"plant", "spec"}, "malformed: kind of automaton")
        names = [e["name"] for e in self.header["events"]]
        claim(len(set(names)) == len(names), "malformed: an event is listed twice")

    def _automaton(self, k: int, entry: dict[str, Any]) -> Automaton:
        offsets, events, targets = (ints(self.arrays, f"{n}_{k}") for n in ("offsets", "events", "targets"))
        own, marked = mask(self.arrays, f"own_{k}"), mask(self.arrays, f"marked_{k}")
        n, where = len(marked), f"malformed: automaton {k}"
        rows = len(offsets) == n + 1 and offsets[0] == 0 and bool((np.diff(offsets) >= 0).all())
        claim(rows and len(events) == len(targets) == offsets[-1], where)
        claim(len(own) == len(self.events) and n > 0, where)
        claim(bool(((targets >= 0) & (targets < n)).all()), f"{where} leads outside")
        claim(bool(((events >= 0) & (events < len(own))).all()), f"{where} has an unknown event")
        claim(bool(own[events].all()), f"{where} has a foreign event")
        claim(0 <= entry["initial"] < n, f"{where} begins outside")
        source = np.repeat(np.arange(n), np.diff(offsets))
        claim(len(np.unique(source * len(own) + events)) == len(events), f"{where} is not deterministic")
        return Automaton(
            entry["name"], entry["kind"] == "plant", entry["initial"], own, marked, source, events, targets
        )
