"""The numbers of a campaign: counts, errors, latencies, speed."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from thenar.hand.campaign.row import Row

__all__ = ["QUANTITIES", "summary"]

QUANTITIES = ("mu", "weight_n", "stiffness_n_per_m")


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """Return what ``rows`` say together.

    ``errors`` has for each quantity, and for the paper's formula of it (``mu_paper``), over the ``n`` episodes with
    an estimate: ``rms``, ``mean`` (the bias) and ``max`` of the relative error's absolute value; for the first
    also ``within_2u``, the share of estimates whose truth lies within two of their own uncertainties.

    >>> summary([])["episodes"], summary([])["errors"]["mu"]["rms"]
    (0, None)
    """
    wall_s, sim_s = sum(r.wall_s for r in rows), sum(r.sim_s for r in rows)
    return {
        "episodes": len(rows),
        "physical_success": sum(r.physical_success for r in rows),
        "discrete_success": sum(r.discrete_success for r in rows),
        "outcomes": dict(sorted(Counter(r.outcome for r in rows).items())),
        "dropped": sum(r.dropped for r in rows),
        "disagreements": [r.seed for r in rows if r.disagrees],
        "failures": [_failure(r) for r in rows if not (r.physical_success and r.discrete_success)],
        "accepted_by_plant": sum(r.accepted_by_plant for r in rows),
        "accepted_by_supervisor": sum(r.accepted_by_supervisor for r in rows),
        "log_differences": sum(r.differences for r in rows),
        "executed_while_disabled": sum(r.executed_while_disabled for r in rows),
        "violations": sum(len(json.loads(r.violations)) for r in rows),
        "errors": {name: found for quantity in QUANTITIES for name, found in _errors(rows, quantity)},
        "latency_ms": _latencies(rows),
        "max_slip_before_detection_mm": max((r.slip_before_detection_mm for r in rows), default=None),
        "max_lift_error_mm": max((abs(r.lift_error_mm) for r in rows if r.lift_error_mm is not None), default=None),
        "max_replace_error_mm": max((r.replace_error_mm for r in rows), default=None),
        "sim_s": sim_s,
        "wall_s": wall_s,
        "real_time_factor": sim_s / wall_s if wall_s else None,
    }


def _failure(row: Row) -> dict[str, Any]:
    return {
        "seed": row.seed,
        "outcome": row.outcome,
        "message": row.message,
        "physically": physically(row),
        "discrete_success": row.discrete_success,
        "physical_success": row.physical_success,
    }


def physically(row: Row) -> str:
    """Return how the episode went physically, in words."""
    wrong = [] if row.lifted else ["not lifted to Z" if row.lift_error_mm is None else "lifted off by more than 1 mm"]
    wrong += [] if row.replaced else [f"not replaced: {row.replace_error_mm:.1f} mm off, tilted or not on the table"]
    wrong += ["dropped"] if row.dropped else []
    return ", ".join(wrong) or "success"


def _errors(rows: Iterable[Row], quantity: str) -> list[tuple[str, dict[str, float | None]]]:
    rows = list(rows)
    found, paper = (
        [e for r in rows if (e := getattr(r, f"{quantity}{kind}_error")) is not None] for kind in ("", "_paper")
    )
    covered = [
        abs(value - getattr(r, f"{quantity}_truth")) <= 2 * u
        for r in rows
        if (value := getattr(r, quantity)) is not None and (u := getattr(r, f"{quantity}_uncertainty")) is not None
    ]
    share = sum(covered) / len(covered) if covered else None
    return [(quantity, {**_spread(found), "within_2u": share}), (f"{quantity}_paper", _spread(paper))]


def _spread(errors: Sequence[float]) -> dict[str, float | None]:
    n = len(errors)
    if not n:
        return {"n": 0, "rms": None, "mean": None, "max": None}
    rms = math.sqrt(math.fsum(e * e for e in errors) / n)
    return {"n": n, "rms": rms, "mean": math.fsum(errors) / n, "max": max(map(abs, errors))}


def _latencies(rows: Iterable[Row]) -> dict[str, dict[str, float]]:
    delays: dict[str, list[float]] = {}
    for row in rows:
        for event, found in row.latencies_ms.items():
            delays.setdefault(event, []).extend(found)
    return {e: {"n": len(d), "mean": math.fsum(d) / len(d), "max": max(d)} for e, d in sorted(delays.items())}
