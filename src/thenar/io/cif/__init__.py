"""CIF 3 models (Eclipse ESCET): :func:`load` a file, or :func:`loads` its text.

What is read, how it is mapped and what is refused: docs/cif.md.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from thenar.io.files import read_bytes
from thenar.io.parse import decode

if TYPE_CHECKING:
    from thenar.io.foreign.written import Written
    from thenar.model.extended import ExtendedProblem
    from thenar.model.problem import Problem

__all__ = ["dumps", "load", "loads"]


def dumps(problem: Problem | ExtendedProblem) -> Written:
    """Return ``problem`` as a CIF model; see :func:`thenar.io.cif.write.dumps`."""
    from thenar.io.cif.write import dumps as written

    return written(problem)


def load(path: str | os.PathLike[str], search: str | os.PathLike[str] | None = None) -> ExtendedProblem:
    """Read the CIF model in the file at ``path`` and in those that it imports.

    An import is relative to the file that asks for it, and stays in the folder ``search``: without it,
    the folder of ``path``.  Raises as :func:`loads` does, and InputError for a file that cannot be read.

    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> _ = (folder / "events.cif").write_text("controllable on, off;")
    >>> _ = (folder / "lamp.cif").write_text('''
    ... import "events.cif";
    ... plant lamp:
    ...   location dark: initial; marked; edge on goto lit;
    ...   location lit: edge off goto dark;
    ... end''')
    >>> load(folder / "lamp.cif")
    ExtendedProblem 'lamp': 1 plant, 0 specs, 0 variables, 0 conditions, 2 events (0 uncontrollable)
    """
    file = Path(path)
    text = decode(read_bytes(file), str(path))
    return _model(text, str(path), file, Path(search) if search is not None else file.parent, file.stem)


def loads(
    text: str, where: str = "<string>", search: str | os.PathLike[str] | None = None, name: str = ""
) -> ExtendedProblem:
    """Read the text of a CIF model; ``where`` is what messages call it, ``search`` the folder of its imports.

    Raises ModelError with every mistake in it, each with its file, line and column: what is no CIF, what
    cannot be meant, and what CIF has and thenar does not read.

    >>> loads("controllable c; plant p: disc int[0..3] n; location: initial; marked; edge c do n := n + 1; end")
    ExtendedProblem: 1 plant, 0 specs, 1 variable, 0 conditions, 1 event (0 uncontrollable)
    >>> loads("plant p:\\n  location: initial; edge go;\\nend", "p.cif")
    Traceback (most recent call last):
    thenar.errors.ModelError: p.cif:2:27: unknown name 'go'
    """
    folder = None if search is None else Path(search)
    return _model(text.removeprefix("\ufeff"), where, None if folder is None else folder / "-", folder, name)


def _model(text: str, where: str, file: Path | None, search: Path | None, name: str) -> ExtendedProblem:
    from thenar.io.cif.build import build  # these bring lark: needed to read a file, not to import thenar
    from thenar.io.cif.imports import Files

    files = Files(search)
    files.read(text, where, file)
    return build(files.roots, name)
