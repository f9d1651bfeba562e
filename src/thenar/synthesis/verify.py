"""The certificate checker: a short, independent proof check.

It shares no code with the kernel, nor with the rest of thenar but for the exception it raises.  A certificate of
the explicit engine lists states, and is checked in NumPy: :mod:`thenar.synthesis.proof.listed`.  One of the symbolic
engine holds sets of states as decision diagrams, and is checked in plain Python, on diagrams of the checker's own:
:mod:`thenar.synthesis.proof.diagrams`.  Either way every state is covered; nothing is sampled.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from thenar.synthesis.proof.container import Arrays, Statement, Wrong, read
from thenar.synthesis.proof.diagrams import SetsOfStates
from thenar.synthesis.proof.listed import ListedStates

__all__ = ["Verdict", "verify"]

PROVED = "controllable, nonblocking, within the specifications and largest"


@dataclass(frozen=True, slots=True)
class Verdict:
    """True if the certificate proves what it claims; otherwise ``reason`` names the first thing that is wrong.

    * ``states``, ``transitions``: of the supervisor, exactly
    * ``checked``: states of the product that the proof covers, those of the supervisor and the removed ones
    * ``nodes``: 0 if they were gone through one by one; otherwise they were gone through all at once, as sets,
      and this is how many nodes the diagrams of the certificate have

    >>> bool(Verdict(False, "not largest: ..."))
    False
    """

    holds: bool
    reason: str
    problem: str = ""
    states: int = 0
    transitions: int = 0
    checked: int = 0
    nodes: int = 0

    def __bool__(self) -> bool:
        return self.holds


def verify(path: str | Path, about: tuple[Arrays, dict[str, Any]] | None = None) -> Verdict:
    """Check the certificate in the file ``path``; with ``about``, also that it is about that problem.

    ``about`` is what :func:`thenar.synthesis.certificate.statement` says of a problem.  Time and memory
    O(states x events) in NumPy where states are listed; in plain Python, and of the order of a hundred times the
    synthesis, for diagrams.  Raises CertificateError for a file that is no certificate, or a damaged one; a
    whole certificate that proves nothing gives a false Verdict.

    >>> import tempfile, thenar
    >>> path = Path(tempfile.mkdtemp(), "factory.cert")
    >>> _ = path.write_bytes(thenar.certificate(thenar.synthesize(thenar.library.model("small_factory"))))
    >>> verify(path).reason
    'controllable, nonblocking, within the specifications and largest'
    >>> _ = path.write_bytes(thenar.certificate(thenar.synthesize(thenar.library.model("transfer_line(20)"))))
    >>> verify(path).states == 28 ** 20
    True
    """
    arrays, header = read(path)
    proof: ListedStates | SetsOfStates
    try:
        problem = Statement(arrays, header)
        proof = (SetsOfStates if header.get("evidence") == "diagrams" else ListedStates)(problem, arrays)
        if about is not None and not problem.is_that_of(*about):
            raise Wrong("the certificate is about another problem")
        proof.check()
    except Wrong as wrong:
        return Verdict(False, str(wrong), header["problem"])
    states, transitions, checked = proof.sizes
    exists = PROVED if states else "no supervisor exists"
    return Verdict(True, exists, header["problem"], states, transitions, checked, proof.n_nodes)
