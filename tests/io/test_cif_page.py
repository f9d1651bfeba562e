"""The page about CIF models tells the truth."""

from __future__ import annotations

import re
from pathlib import Path

from thenar.io import cif
from thenar.io.cif import automata, build, expressions, scopes, syntax, terms
from thenar.model.variables import MAX_VALUES

PAGE = (Path(__file__).parents[2] / "docs" / "cif.md").read_text()


def test_the_model_on_the_page_loads(tmp_path: Path) -> None:
    (text,) = re.findall(r"```cif\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "names.cif").write_text("")
    (tmp_path / "model.cif").write_text(text)
    problem = cif.load(tmp_path / "model.cif")
    assert [a.name for a in problem.plants] == ["m1", "m2", "rush.input"]
    assert [str(c) for c in problem.spec_conditions][:2] == [
        "not (m1.Busy and m2.Busy)",
        "m1.start needs m2.made > 0 or rush",
    ]


def test_the_limits_on_the_page_are_those_of_the_reader() -> None:
    limits = (
        *(MAX_VALUES, build.MAX_VALUES, build.MAX_INPUT, automata.MAX_EDGES),
        *(syntax.MAX_TEXT, scopes.MAX_COMPONENTS, terms.MAX_SIZE),
    )
    assert [limit for limit in limits if f"{limit:,}" not in PAGE] == []


def test_the_functions_on_the_page_are_those_that_are_read() -> None:
    assert [name for name in expressions.FUNCTIONS if f"`{name}`" not in PAGE] == []
