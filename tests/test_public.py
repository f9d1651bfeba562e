"""The front of the house: public names, the README's example, the documentation's pictures, the imports."""

import doctest
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import thenar

ROOT = Path(__file__).parent.parent


def test_public_names_are_sorted_exist_and_are_documented() -> None:
    assert thenar.__all__ == sorted(thenar.__all__)
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    documented = set(re.findall(r"`(\w+)`", page))
    for name in thenar.__all__:
        assert name == "library" or ">>>" in (getattr(thenar, name).__doc__ or ""), f"{name} has no example"
        assert name in documented, f"{name} is missing in docs/api.md"


def test_names_of_the_documentation_are_public() -> None:
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    methods = {"from_transitions", "from_arrays"}
    assert set(re.findall(r"`(\w+)`", page)) - methods == set(thenar.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'thenar' has no attribute 'synthesise'"):
        thenar.synthesise  # noqa: B018


def test_the_readmes_example_prints_what_the_readme_says(capsys: pytest.CaptureFixture[str]) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    example = re.search(r"```python\n(.*?)```", readme, re.DOTALL)
    output = re.search(r"```text\n(.*?)```", readme, re.DOTALL)
    assert example is not None
    assert output is not None
    exec(example[1], {})
    assert capsys.readouterr().out == output[1]


def test_the_pictures_are_what_the_library_draws() -> None:
    module = runpy.run_path(str(ROOT / "docs" / "pictures.py"))
    for name, text in module["pictures"]():
        there = (ROOT / "docs" / "pictures" / name).read_text(encoding="utf-8")
        assert there == text, f"docs/pictures/{name} is out of date: make docs"


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("*.md")), ids=lambda p: p.name)
def test_the_examples_of_the_documentation_run(page: Path) -> None:
    found = doctest.testfile(str(page), module_relative=False, encoding="utf-8", optionflags=doctest.ELLIPSIS)
    assert found.failed == 0


@pytest.mark.parametrize("page", [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))], ids=lambda p: p.name)
def test_links_of_the_documentation_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_importing_thenar_pulls_numpy_and_the_kernel_only() -> None:
    heavy = ("click", "rich", "pydantic", "tree_sitter", "matplotlib", "hypothesis", "thenar.render", "thenar.io")
    code = f"import sys, thenar; print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_help_pulls_neither_pydantic_nor_matplotlib() -> None:
    code = (
        "import sys; sys.argv = ['thenar', '--help']\n"
        "from thenar.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print([m for m in ('pydantic', 'matplotlib', 'tree_sitter', 'rich') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().endswith("[]")
