"""The certificate checker: a short, independent proof check in NumPy.

It shares no code with the kernel, nor with the rest of thenar but for the exception it raises.  A certificate
holds the automata of a problem; states of their product, each one a *survivor* or *removed* with a reason and
a rank; and the supervisor.  Checked is, for every state and event at once,

* *legal*:        no survivor has an uncontrollable event that the plants can do and a specification forbids,
* *controllable*: every uncontrollable event that is possible in a survivor leads to a survivor,
* *nonblocking*:  every survivor is marked or has a transition to a survivor that is one step nearer to one,
* *largest*:      every removed state has a reason of lower rank: a specification broken by an uncontrollable
  event; an uncontrollable event to a removed state of lower rank; or not being marked, and having all its
  transitions to removed states that are of lower rank or are removed for this same reason at this same rank,
* *faithful*:     the supervisor is the survivors that can be reached from the initial state, with all the
  transitions between them.

By induction over the rank no removed state can be in any controllable, nonblocking subset, so what is left
is the largest.   [Ramadge and Wonham 1987]
"""

from __future__ import annotations

import hashlib
import io
import json
import math
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

__all__ = ["FORMAT", "Verdict", "digest", "read", "verify"]

FORMAT = b"thenar certificate 1"  # the first line of the file; the second is the digest of the rest
MAX_BYTES = 4 << 30  # a file that is larger, packed or unpacked, is refused before it is read
CHUNK = 1 << 24
SURVIVES, ILLEGAL, UNCONTROLLABLE, BLOCKING = range(4)

Arrays = Mapping[str, NDArray[Any]]
Mask = NDArray[np.bool_]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Verdict:
    """True if the certificate proves what it claims; otherwise ``reason`` names the first thing that is wrong.

    ``states`` and ``transitions`` are those of the supervisor, ``checked`` the states of the product gone through.

    >>> bool(Verdict(False, "not largest: ..."))
    False
    """

    holds: bool
    reason: str
    problem: str = ""
    states: int = 0
    transitions: int = 0
    checked: int = 0

    def __bool__(self) -> bool:
        return self.holds


class _Wrong(Exception):
    """What the certificate gets wrong."""


def verify(path: str | Path, about: tuple[Arrays, dict[str, Any]] | None = None) -> Verdict:
    """Check the certificate in the file ``path``; with ``about``, also that it is about that problem.

    ``about`` is what :func:`thenar.synthesis.certificate.statement` says of a problem.  Time and memory
    O(states x events) in NumPy.  Raises CertificateError for a file that is no certificate, or a damaged one; a
    whole certificate that proves nothing gives a false Verdict.

    >>> import tempfile, thenar
    >>> path = Path(tempfile.mkdtemp(), "factory.cert")
    >>> _ = path.write_bytes(thenar.certificate(thenar.synthesize(thenar.library.model("small_factory"))))
    >>> verify(path).reason
    'controllable, nonblocking, within the specifications and largest'
    """
    arrays, header = read(path)
    try:
        checker = _Checker(arrays, header)
        if about is not None and not _same_problem(arrays, header, *about):
            raise _Wrong("the certificate is about another problem")
        checker.check_states()
        checker.check_removed()
        checker.check_survivors()
        checker.check_supervisor()
    except _Wrong as wrong:
        return Verdict(False, str(wrong), header["problem"])
    n, m = len(arrays["origin"]), len(arrays["sup_events"])
    exists = "controllable, nonblocking, within the specifications and largest" if n else "no supervisor exists"
    return Verdict(True, exists, header["problem"], n, m, len(arrays["reason"]))


def _same_problem(arrays: Arrays, header: dict[str, Any], wanted: Arrays, wanted_header: dict[str, Any]) -> bool:
    def written(h: dict[str, Any]) -> str:  # as text, for Python takes 0 for False
        return json.dumps([h["events"], h["automata"]], sort_keys=True)

    return written(header) == written(wanted_header) and all(
        name in arrays and np.array_equal(arrays[name], array) for name, array in wanted.items()
    )


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


class _Checker:
    def __init__(self, arrays: Arrays, header: dict[str, Any]) -> None:
        self.arrays, self.header = arrays, header
        self._check_header()
        self.events = [e["name"] for e in header["events"]]
        self.free = [not e["controllable"] for e in header["events"]]
        self.plant = [a["kind"] == "plant" for a in header["automata"]]
        self.names = [a["name"] for a in header["automata"]]
        self.tables = [self._table(k) for k in range(len(self.names))]
        self.coords = self._ints("coords", 2)
        self.reason, self.rank, self.way = (self._ints(n) for n in ("reason", "rank", "way"))
        n = len(self.coords)
        sizes = [len(t) for t in self.tables]
        self._claim(self.coords.shape[1] == len(sizes), "malformed: states without coordinates")
        self._claim(all(len(a) == n for a in (self.reason, self.rank, self.way)), "malformed: arrays of unequal length")
        self._claim(n > 0 and any(self.plant), "malformed: nothing to check")
        inside = (self.coords >= 0) & (self.coords < sizes)
        self._claim(bool(inside.all()), "a state has a component outside its automaton")
        initial = [a["initial"] for a in header["automata"]]
        self._claim(self.coords[0].tolist() == initial, "state 0 is not the initial state")
        self._claim(bool(np.isin(self.reason, range(4)).all()), "malformed: unknown reason")
        self.index = _Rows(self.coords, sizes)
        self.alive = self.reason == SURVIVES
        self.marked = np.ones(n, np.bool_)
        for k in range(len(sizes)):
            self.marked &= self._mask(f"marked_{k}")[self.coords[:, k]]

    def _check_header(self) -> None:
        """Hold the header to its types: what is not exactly so is not read with good will."""
        fields = {"events": {"name": str, "controllable": bool}, "automata": {"name": str, "kind": str, "initial": int}}
        for part, wanted in fields.items():
            entries = self.header.get(part)
            self._claim(isinstance(entries, list), f"malformed: {part}")
            for entry in entries or ():
                fits = isinstance(entry, dict) and {k: type(v) for k, v in entry.items()} == wanted
                self._claim(fits, f"malformed: {part}")
        kinds = {a["kind"] for a in self.header["automata"]}
        self._claim(kinds <= {"plant", "spec"}, "malformed: kind of automaton")
        names = [e["name"] for e in self.header["events"]]
        self._claim(len(set(names)) == len(names), "malformed: an event is listed twice")

    def _ints(self, name: str, ndim: int = 1) -> Ints:
        """Return an array of whole numbers, checked to be one."""
        array = self.arrays.get(name)
        if array is None or array.ndim != ndim or array.dtype.kind not in "iu":
            raise _Wrong(f"malformed: {name}")
        self._claim(bool((array <= np.iinfo(np.int32).max).all()), f"malformed: {name}")
        return array.astype(np.int64)

    def _mask(self, name: str) -> Mask:
        array = self._ints(name)
        self._claim(bool(np.isin(array, (0, 1)).all()), f"malformed: {name}")
        return array.astype(np.bool_)

    @staticmethod
    def _claim(holds: bool, otherwise: str) -> None:
        if not holds:
            raise _Wrong(otherwise)

    def _table(self, k: int) -> Ints:
        """Return (n_states, n_events) int64: target, -1 undefined, -2 not in the alphabet of automaton k."""
        offsets, events, targets = (self._ints(f"{n}_{k}") for n in ("offsets", "events", "targets"))
        own, n = self._mask(f"own_{k}"), len(self._mask(f"marked_{k}"))
        where = f"malformed: automaton {k}"
        rows = len(offsets) == n + 1 and offsets[0] == 0 and bool((np.diff(offsets) >= 0).all())
        self._claim(rows and len(events) == len(targets) == offsets[-1], where)
        self._claim(len(own) == len(self.events) and n > 0, where)
        self._claim(bool(((targets >= 0) & (targets < n)).all()), f"{where} leads outside")
        self._claim(bool(((events >= 0) & (events < len(own))).all()), f"{where} has an unknown event")
        self._claim(bool(own[events].all()), f"{where} has a foreign event")
        source = np.repeat(np.arange(n), np.diff(offsets))
        self._claim(len(np.unique(source * len(own) + events)) == len(events), f"{where} is not deterministic")
        table = np.full((n, len(own)), -2, np.int64)
        table[:, own] = -1
        table[source, events] = targets
        return table

    def moves(self, event: int, states: Ints) -> tuple[Mask, Mask, Ints]:
        """Return for each of ``states``: can the plants do ``event``; may they; the state reached (-1: none listed)."""
        owners = [k for k, table in enumerate(self.tables) if table[0, event] != -2]
        can = np.full(len(states), bool(owners))  # an event that no automaton has never happens
        may = np.ones(len(states), np.bool_)
        changed: dict[int, tuple[Ints, Ints]] = {}  # of each owner, its state before and after
        for k in owners:
            before = self.coords[states, k]
            after = self.tables[k][before, event]
            ok = after != -1
            if self.plant[k]:
                can &= ok
            else:
                may &= ok
            changed[k] = before, after
        both = np.flatnonzero(can & may)
        reached = np.full(len(states), -1, np.int64)
        reached[both] = self.index.find(states[both], {k: (q[both], t[both]) for k, (q, t) in changed.items()})
        return can, may, reached

    def where(self, bad: Mask, states: Ints) -> str:
        """Name the first of ``states`` at which ``bad`` holds, if there is one."""
        if not bad.any():
            return ""
        x = int(states[np.argmax(bad)])
        return f"state {x} ({', '.join(f'{n}:{q}' for n, q in zip(self.names, self.coords[x].tolist(), strict=True))})"

    def check_states(self) -> None:
        """No state is listed twice, and ranks and reasons go together."""
        self._claim(self.index.distinct, "a state of the product is listed twice")
        self._claim(bool(((self.rank < 0) == self.alive).all()), "a survivor has a rank, or a removed state has none")

    def check_removed(self) -> None:
        """Every removed state has a reason of lower rank."""
        removed = np.flatnonzero(~self.alive)
        proved = np.zeros(len(removed), np.bool_)
        reason, rank = self.reason[removed], self.rank[removed]
        blocked = (reason == BLOCKING) & ~self.marked[removed]
        for e, free in enumerate(self.free):
            can, may, reached = self.moves(e, removed)
            inside = reached >= 0
            gone = inside & ~self.alive[reached]
            lower = gone & (self.rank[reached] < rank)
            if free:
                proved |= (reason == ILLEGAL) & can & ~may
                proved |= (reason == UNCONTROLLABLE) & lower
            same = gone & (self.rank[reached] == rank) & (self.reason[reached] == BLOCKING)
            blocked &= ~(can & may) | lower | same
        proved |= blocked
        if not proved.all():
            words = {
                ILLEGAL: "breaking a specification",
                UNCONTROLLABLE: "an uncontrollable event",
                BLOCKING: "blocking",
            }
            first = int(reason[np.argmin(proved)])
            raise _Wrong(
                f"not largest: {self.where(~proved, removed)} was removed for {words[first]} without that being so"
            )

    def check_survivors(self) -> None:
        """The survivors are legal, controllable and nonblocking."""
        alive = np.flatnonzero(self.alive)
        nearer = self.marked[alive] & (self.way[alive] == 0)
        for e, free in enumerate(self.free):
            can, may, reached = self.moves(e, alive)
            lost = can & may & (reached < 0)
            self._claim(
                not lost.any(), f"{self.events[e]} leads from {self.where(lost, alive)} to a state that is not listed"
            )
            to_alive = (reached >= 0) & self.alive[reached]
            if free:
                broken, uncontrolled = can & ~may, can & may & ~to_alive
                name, breaks, leads = self.events[e], self.where(broken, alive), self.where(uncontrolled, alive)
                self._claim(not broken.any(), f"not within the specifications: {name} breaks one in {breaks}")
                self._claim(not uncontrolled.any(), f"not controllable: {name} leads from {leads} to a removed state")
            nearer |= to_alive & (self.way[reached] >= 0) & (self.way[reached] < self.way[alive])
        self._claim(
            bool(nearer.all()), f"not nonblocking: no way to a marked state is shown from {self.where(~nearer, alive)}"
        )

    def check_supervisor(self) -> None:
        """The supervisor is the reachable survivors with all transitions between them, and its marks are theirs."""
        names = ("origin", "sup_offsets", "sup_events", "sup_targets")
        origin, offsets, events, targets = (self._ints(name) for name in names)
        marked = self._mask("sup_marked")
        n = len(origin)
        if not self.alive[0]:
            empty = n == len(events) == len(targets) == len(marked) == 0
            self._claim(empty, "the initial state is removed, but the supervisor is not empty")
            return
        self._claim(n > 0 and origin[0] == 0, "the supervisor does not begin in the initial state")
        self._claim(
            bool(((origin >= 0) & (origin < len(self.reason))).all()), "the supervisor has a state that is not listed"
        )
        self._claim(len(np.unique(origin)) == n, "two states of the supervisor are the same")
        gone = ~self.alive[origin]
        self._claim(not gone.any(), f"the supervisor enters {self.where(gone, origin)}, a removed state")
        self._claim(np.array_equal(marked, self.marked[origin]), "the supervisor marks other states")
        self._claim(
            len(offsets) == n + 1 and offsets[0] == 0 and bool((np.diff(offsets) >= 0).all()), "malformed: supervisor"
        )
        self._claim(len(events) == len(targets) == offsets[-1], "malformed: supervisor")
        self._claim(
            bool(((targets >= 0) & (targets < n) & (events >= 0) & (events < len(self.events))).all()),
            "malformed: supervisor",
        )
        source = np.repeat(np.arange(n), np.diff(offsets))
        total = 0
        for e, name in enumerate(self.events):
            _, _, reached = self.moves(e, origin)
            expected = np.where((reached >= 0) & self.alive[reached], reached, -1)
            mine = events == e
            stated = np.full(n, -1, np.int64)
            stated[source[mine]] = origin[targets[mine]]
            wrong = stated != expected
            self._claim(not wrong.any(), f"the supervisor is wrong about {name} in {self.where(wrong, origin)}")
            total += int((expected >= 0).sum())
        self._claim(total == len(events), "the supervisor lists a transition twice")
        entered = np.full(n, n, np.int64)
        np.minimum.at(entered, targets, source)
        # numbered breadth-first: each state is entered from one with a smaller number, so all are reachable
        self._claim(bool((entered[1:] < np.arange(1, n)).all()), "the supervisor has a state that is never entered")


class _Rows:
    """Finds rows of small integers in a table by a key of one integer each, where that does not overflow."""

    def __init__(self, rows: Ints, sizes: list[int]) -> None:
        self.rows, self.sizes = rows, sizes
        self.strides: list[int] | None = []
        self.folds: list[Ints | None] = []
        key, span = np.zeros(len(rows), np.int64), 1
        for column, size in enumerate(sizes):
            if span * size >= 1 << 62:  # rank the keys so far; look-ups then go through every column
                known, key = np.unique(key, return_inverse=True)
                self.folds.append(known)
                self.strides = None
                span = len(known)
            else:
                self.folds.append(None)
            key, span = key * size + rows[:, column], span * size
        if self.strides is not None:
            self.strides = [math.prod(sizes[k + 1 :]) for k in range(len(sizes))]
        self.key = key
        self.order = np.argsort(key, kind="stable")
        self.sorted = key[self.order]
        self.distinct = bool((np.diff(self.sorted) > 0).all())
        self.place: NDArray[np.int32] | None = None
        if span <= 16 * len(rows):  # then a table is smaller than what is checked anyway, and quicker than a search
            self.place = np.full(span, -1, np.int32)
            self.place[key] = np.arange(len(rows))

    def find(self, states: Ints, changed: Mapping[int, tuple[Ints, Ints]]) -> Ints:
        """Return the number of each of ``states`` with the columns ``changed`` (from, to); -1: not there."""
        known_so_far = np.ones(len(states), np.bool_)
        if self.strides is not None:
            key = self.key[states]
            for column, (before, after) in changed.items():
                key += (after - before) * self.strides[column]
        else:
            key = np.zeros(len(states), np.int64)
            for column, (size, known) in enumerate(zip(self.sizes, self.folds, strict=True)):
                if known is not None:
                    place = np.minimum(np.searchsorted(known, key), len(known) - 1)
                    known_so_far &= known[place] == key
                    key = place
                value = changed[column][1] if column in changed else self.rows[states, column]
                key = key * size + value
        if self.place is not None:
            return self.place[key].astype(np.int64)
        place = np.minimum(np.searchsorted(self.sorted, key), len(self.sorted) - 1)
        return np.where(known_so_far & (self.sorted[place] == key), self.order[place], -1)
