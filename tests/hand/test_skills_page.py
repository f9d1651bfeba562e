"""The documentation's table of skills is the code's."""

from __future__ import annotations

import re
from pathlib import Path

from thenar.hand.detectors import DETECTORS
from thenar.hand.skills import SKILLS
from thenar.library import glr

PAGE = (Path(__file__).parents[2] / "docs" / "hand.md").read_text(encoding="utf-8")


def test_every_skill_is_documented_with_its_commit_point_and_limit() -> None:
    rows = re.findall(r"^\| (`.*?`) \| (command|achievement) \|.*?\| (\d+ s|–) \|", PAGE, re.MULTILINE)
    told = {e: (commit, limit) for events, commit, limit in rows for e in re.findall(r"`(.*?)`", events)}
    plans = [skill.plan for skill in SKILLS.values()]
    assert told == {p.event: (p.commit, f"{p.limit_s:g} s" if p.commit == "achievement" else "–") for p in plans}


def test_every_detector_is_documented_with_its_debounce_and_what_arms_it() -> None:
    rows = dict(re.findall(r"^\| `(.*?)` \| .* for (\d+) ms \|$", PAGE, re.MULTILINE))
    for event, detector in DETECTORS.items():
        general = re.sub(r"_[12](?=_|$)", "_i", event)
        assert int(rows[general]) == detector.hold_ms, event


def test_skills_and_detectors_cover_both_variants() -> None:
    for variant in ("paper", "extended"):
        for event in glr.problem(variant).alphabet:
            assert event.name in (SKILLS if event.controllable else DETECTORS) or event.name.startswith("timeout_")
    assert {e.name for e in glr.problem("extended").alphabet} >= {*SKILLS, *DETECTORS}
