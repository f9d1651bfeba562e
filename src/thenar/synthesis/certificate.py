"""Writing certificates: the evidence of a synthesis as a file that an independent checker can follow."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from thenar.errors import InputError
from thenar.explicit.exploration import ticker
from thenar.explicit.reach import distance_to_marked
from thenar.explicit.rows import bytemask, own_mask, rows_in_order_of
from thenar.model.problem import Problem
from thenar.synthesis.api import SynthesisResult
from thenar.synthesis.proof.container import FORMAT, digest

if TYPE_CHECKING:
    from thenar._native.kernel import Set
    from thenar.model.extended import ExtendedProblem
    from thenar.symbolic.synthesis import SymbolicSupervisor

__all__ = ["certificate", "pack", "shared_nodes", "statement"]

REASONS = {"illegal": 1, "blocking": 3}  # numbered as those of states that are listed


def certificate(result: SynthesisResult) -> bytes:
    """Return the certificate of ``result``: the bytes of a file that ``thenar verify`` checks.

    It holds the problem and the evidence.  Of the explicit engine that is every explored state with the reason and rank
    of its removal, for each survivor the length of a shortest way to a marked state, and the supervisor: O(states x
    components) memory.  Of the symbolic engine it is the supervisor's states and each round of removals, as decision
    diagrams: O(nodes x values).  See :mod:`thenar.synthesis.verify`.

    Raises InputError if an automaton of the problem is empty: then nothing was explored; and for a problem with
    variables or conditions that the symbolic engine solved.

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> certificate(synthesize(small_factory())).split(b"\\n")[0]
    b'thenar certificate 1'
    """
    evidence, extract = result.evidence, result.extract
    if result.symbolic is not None:
        if not isinstance(result.problem, Problem):
            raise InputError(
                "a problem with variables or conditions is certified by listing its states: "
                "synthesize(problem, 'explicit')"
            )
        return _of_sets(result.problem, result.symbolic)
    if evidence is None or extract is None:
        raise InputError("nothing to certify: an automaton of the problem has no states")
    problem, native = result.plain, evidence.native
    arrays, header = statement(problem)
    widest = max(a.n_states for a in problem.automata)
    arrays["coords"] = evidence.layout.unpack(native.keys(np.arange(native.n_states)), np.min_scalar_type(widest))
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


def _of_sets(problem: Problem, supervisor: SymbolicSupervisor) -> bytes:
    """Return the certificate of a supervisor that is a set of states."""
    arrays, header = statement(problem)
    header["evidence"] = "diagrams"
    sets = [supervisor.controlled, *(s for r in supervisor.removals for s in (r.seeds, r.states))]
    parts, order = supervisor.encoding.parts, supervisor.encoding.order
    arrays["order"] = order
    sizes = [parts[k].size for k in reversed(order.tolist())]
    arrays["node_levels"], arrays["node_children"], arrays["roots"] = shared_nodes(sets, sizes)
    arrays["reasons"] = np.array([REASONS[r.reason] for r in supervisor.removals], np.uint8)
    return pack(arrays, header)


def shared_nodes(sets: Sequence[Set], sizes: Sequence[int]) -> tuple[NDArray[np.uint32], ...]:
    """Return the nodes of ``sets``, which have ``sizes[k - 1]`` values at level k, each node once.

    * the level of each node, children before parents; the number of the first is 2, for 0 is nothing, 1 everything
    * their children, one node's after the other's
    * the node that each set is
    """
    number: dict[tuple[int, tuple[int, ...]], int] = {}
    roots = []
    for one in sets:
        levels, flat = (array.tolist() for array in one.dump())
        here, at = [0, 1], 0
        for level in levels:
            node = level, tuple(here[child] for child in flat[at : at + sizes[level - 1]])
            at += sizes[level - 1]
            here.append(number.setdefault(node, len(number) + 2))
        roots.append(here[-1] if levels else int(one.is_everything))
    children = [child for _, kids in number for child in kids]
    return tuple(np.array(numbers, np.uint32) for numbers in ([level for level, _ in number], children, roots))


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


def statement(problem: Problem | ExtendedProblem) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Return the arrays and the header that say which problem a certificate is about; see ``verify(about=...)``.

    An extended problem is stated as it is certified: as the plain one of its states, which are listed for that.
    """
    if not isinstance(problem, Problem):
        from thenar.explicit.flatten import flatten

        problem = flatten(problem, ticker(None, None)).problem
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
