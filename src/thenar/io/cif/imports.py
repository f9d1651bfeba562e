"""The files of a CIF model: one, and those that it imports."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lark import Token

from thenar.errors import InputError
from thenar.io.cif.scopes import Scope
from thenar.io.cif.syntax import fail, parse
from thenar.io.files import read_bytes
from thenar.io.parse import decode

__all__ = ["Files"]

MAX_FILES = 500  # of one model
MAX_NAME = 1_000  # characters of a path
MAX_CHAIN = 50  # imports of imports


class Files:
    """Reads the files of one model, each once; ``roots`` are their scopes, imported ones first."""

    def __init__(self, search: Path | None) -> None:
        self.search = None if search is None else search.resolve()
        self.members: dict[str, Any] = {}
        self.count = [0, 0]
        self.roots: list[Scope] = []
        self.seen: set[Path] = set()
        self.chain: list[Path] = []

    def read(self, text: str, where: str, file: Path | None) -> None:
        """Read ``text``, which stands in ``file``, and before it what it imports."""
        tree = parse(text, where)
        if file is not None:
            self.chain.append(file.resolve())
        root = Scope("", None, where, members=self.members, count=self.count)
        items: list[Any] = []
        statements: list[Any] = tree.children
        for item in statements:
            if str(item.data) == "imports":
                for token in item.children:
                    self._imported(token, where, file)
            elif str(item.data) == "namespace":
                root = self._namespace(root, item.children[0])
            else:
                items.append(item)
        if file is not None:
            self.chain.pop()
        root.fill(items)
        self.roots.append(root)

    def _imported(self, token: Token, where: str, file: Path | None) -> None:
        name = str(token)[1:-1]
        if file is None or self.search is None:
            fail(token, where, f"import {token}: there is no folder to look in; load the file, or say search=FOLDER")
        if "\\" in name or "\0" in name or not 0 < len(name) <= MAX_NAME:
            fail(token, where, f"import {token[:MAX_NAME]}: write a path, with /")
        target = (file.parent / name).resolve()
        if not target.is_relative_to(self.search):
            fail(
                token, where,
                f"import {token}: leaves the folder {str(self.search)!r}; if that is meant, "
                "thenar.io.cif.load(FILE, search=FOLDER) allows a larger one",
            )  # fmt: skip
        if target in self.chain:
            fail(token, where, f"import {token}: that file imports this one already; an import has no way back")
        if target in self.seen:
            return
        self.seen.add(target)
        if len(self.seen) > MAX_FILES or len(self.chain) > MAX_CHAIN:
            fail(token, where, f"import {token}: more than {MAX_FILES} files, or {MAX_CHAIN} that import one another")
        source = str(file.parent / name)
        try:
            text = decode(read_bytes(source), source)
        except InputError as error:
            fail(token, where, f"import {token}: {error}")
        self.read(text, source, file.parent / name)

    def _namespace(self, root: Scope, token: Token) -> Scope:
        """Return the scope of the groups that a namespace names, made if they are not there."""
        here = root
        for part in str(token).replace("$", "").split("."):
            known = here.members.get(part)
            if known is not None and not (isinstance(known, Scope) and known.kind == "group"):
                fail(token, root.source, f"namespace {str(token)!r}: {part!r} is no group")
            name = here.absolute(part)
            inner = Scope(name, here, root.source, depth=here.depth + 1, count=self.count)
            if isinstance(known, Scope):
                inner.members = known.members
            else:
                here.members[part] = inner
            here = inner
        return here
