"""How a hand is built, as far as its servo and its skills must know."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["PLANAR", "Geometry"]


@dataclass(frozen=True, slots=True)
class Geometry:
    """Where the fingers of a hand rest and how far they go; lengths in metres.

    ``home`` is the closing coordinate and the height of a finger at rest, ``gap`` what an approach leaves between a
    pad and the expected face, ``travel`` how far a guarded move goes before it gives up: nothing is there.
    ``linked``: both fingers hang on one slide, so that a height reference of one is the other's too.

    >>> PLANAR.linked, PLANAR.home
    (False, (-0.075, 0.06))
    """

    home: tuple[float, float]
    gap: float
    travel: float
    linked: bool = False


PLANAR = Geometry(home=(-0.075, 0.06), gap=0.030, travel=0.06)
