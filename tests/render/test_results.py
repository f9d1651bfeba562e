"""What a notebook shows at the end of a cell."""

import thenar
from thenar.model.problem import Problem


def test_a_result_is_shown_as_its_supervisor_and_a_failure_as_its_reason() -> None:
    result = thenar.synthesize(thenar.library.model("small_factory"))
    assert result._repr_html_() == result.supervisor._repr_html_()
    assert "<svg" in (result._repr_html_() or "")
    stuck = thenar.Automaton.from_transitions(["0 -x-> 1"], initial="0", marked=[], name="STUCK")
    shown = thenar.synthesize(Problem(stuck))._repr_html_()
    assert shown is not None
    assert "No supervisor exists: even without any specification." in shown


def test_an_explanation_is_shown_as_its_words() -> None:
    why = thenar.explain_disabled(thenar.synthesize(thenar.library.glr.problem()), "approach_2")
    assert "the event approach_2 is disabled: SPEC1" in (why._repr_html_() or "")
