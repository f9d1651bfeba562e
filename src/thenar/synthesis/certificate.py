"""Writing certificates: the evidence of a synthesis as a file that an independent checker can follow."""

from __future__ import annotations

import io
import json
import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.explicit.reach import distance_to_marked
from thenar.explicit.rows import bytemask, own_mask, rows_in_order_of
from thenar.model.problem import Problem
from thenar.synthesis.api import SynthesisResult
from thenar.synthesis.verify import FORMAT, digest

__all__ = ["certificate", "pack", "statement"]


def certificate(result: SynthesisResult) -> bytes:
    """Return the certificate of ``result``: the bytes of a file that ``thenar verify`` checks.

    It holds the problem, every explored state with the reason and rank of its removal, for each survivor the
    length of a shortest way to a marked state, and the supervisor; see :mod:`thenar.synthesis.verify`.
    O(states x components) memory.

    Raises InputError if an automaton of the problem is empty: then nothing was explored.

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> certificate(synthesize(small_factory())).split(b"\\n")[0]
    b'thenar certificate 1'
    """
    evidence, extract = result.evidence, result.extract
    if result.symbolic is not None:
        raise InputError("a certificate needs the evidence of the explicit engine: synthesize(problem, 'explicit')")
    if evidence is None or extract is None:
        raise InputError("nothing to certify: an automaton of the problem has no states")
    problem, native = result.plain, evidence.native
    arrays, header = statement(problem)
    widest = max(a.n_states for a in problem.automata)
    arrays["coords"] = evidence.layout.unpack(native.keys, np.min_scalar_type(widest))
    arrays["reason"] = np.array(native.reason)
    arrays["rank"] = np.array(native.rank)
    # Survivors that the supervisor does not reach are left out: no proof refers to them, for a reachable survivor
    # leads to reachable ones only, and a blocking state to removed ones only.
    s = extract.automaton
    way = np.full(evidence.n_states, -1, np.int32)
    way[extract.origin] = distance_to_marked(s)
    arrays["way"] = way
    keep = (arrays["reason"] != 0) | (way >= 0)
    number = np.cumsum(keep) - 1
    for name in ("coords", "reason", "rank", "way"):
        arrays[name] = arrays[name][keep]
    arrays["origin"] = number[extract.origin]
    arrays["sup_offsets"], arrays["sup_events"], arrays["sup_targets"] = s.offsets, s.events, s.targets
    arrays["sup_marked"] = bytemask(s.marked)
    return pack(arrays, header)


def pack(arrays: dict[str, NDArray[Any]], header: dict[str, Any]) -> bytes:
    """Return the file: its format, the digest of the rest, and the rest as a NumPy archive; each on a line."""
    file = io.BytesIO()
    members = {"header": np.frombuffer(json.dumps(header).encode(), np.uint8), **arrays}
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archived:
        for name, array in members.items():
            member = zipfile.ZipInfo(f"{name}.npy")  # with a fixed date: the same result gives the same bytes
            member.compress_type = zipfile.ZIP_DEFLATED
            with archived.open(member, "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, np.ascontiguousarray(array), allow_pickle=False)
    archive = file.getvalue()
    return b"\n".join((FORMAT, digest(archive), archive))


def statement(problem: Problem) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Return the arrays and the header that say which problem a certificate is about; see ``verify(about=...)``."""
    header: dict[str, Any] = {
        "problem": problem.name,
        "events": [{"name": e.name, "controllable": e.controllable} for e in problem.alphabet],
        "automata": [],
    }
    arrays: dict[str, NDArray[Any]] = {}
    for k, a in enumerate(problem.automata):
        kind = "plant" if k < len(problem.plants) else "spec"
        header["automata"].append({"name": a.name, "kind": kind, "initial": a.initial})
        events, targets = rows_in_order_of(problem.alphabet, a)
        own = own_mask(problem.alphabet, a)
        marked = bytemask(a.marked)
        for name, array in (
            ("offsets", a.offsets),
            ("events", events),
            ("targets", targets),
            ("own", own),
            ("marked", marked),
        ):
            arrays[f"{name}_{k}"] = array
    return arrays, header
