"""The formats that are read and written: what they are called, how their files end, and which module knows them."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from thenar.errors import InputError, UnknownName

__all__ = ["FORMATS", "Format", "format_named", "format_of"]


@dataclass(frozen=True, slots=True)
class Format:
    """A format of model files.

    * ``name``: what ``--from``, ``--to`` and ``format=`` call it;  ``title``: what people do
    * ``endings``: how its files end, in capitals or not; written files as here: PiTCT asks for ``.DES``
    * ``module``: has ``loads`` and ``dumps``; none for our own two, which several files make one model of
    * ``one``: a file holds one automaton, and says nothing of whether it is a plant or a specification
    * ``named``: a file says what its automaton is called
    * ``texts``: a file says what its automaton means
    * ``numbers``: its events are numbers, so the files of one problem have to agree on them
    * ``root``: for several formats of one ending, what tells this one
    """

    name: str
    title: str
    endings: tuple[str, ...]
    module: str = ""
    one: bool = False
    named: bool = True
    texts: bool = False
    numbers: bool = False
    reads: bool = True
    writes: bool = True
    root: bytes = b""

    def code(self) -> Any:
        """Return the module, imported when it is first needed."""
        return import_module(self.module)


_FOREIGN = "thenar.io.foreign"
FORMATS = (
    Format("toml", "thenar TOML", (".toml",)),
    Format("json", "thenar JSON", (".json",)),
    Format("cif", "CIF 3 (Eclipse ESCET)", (".cif",), "thenar.io.cif"),
    Format("tct", "TCT DES", (".DES",), f"{_FOREIGN}.tct", one=True, named=False, numbers=True),
    Format("ads", "TCT ADS", (".ADS",), f"{_FOREIGN}.ads", one=True, numbers=True),
    Format("wmod", "Waters module (Supremica)", (".wmod",), f"{_FOREIGN}.waters"),
    Format("supremica", "Supremica project", (".xml",), f"{_FOREIGN}.supremica", root=rb"SupremicaProject|Automata"),
    Format("faudes", "libFAUDES generator", (".gen",), f"{_FOREIGN}.faudes", one=True),
    Format("faudes-xml", "libFAUDES in XML", (".xml",), f"{_FOREIGN}.faudes_xml", one=True, root=rb"Generator"),
    Format("ides", "IDES model", (".xmd", ".xws"), f"{_FOREIGN}.ides", one=True, named=False, texts=True),
    Format("desuma", "DESUMA and UMDES", (".fsm",), f"{_FOREIGN}.desuma", one=True, named=False),
    Format("dot", "Graphviz DOT", (".dot", ".gv"), f"{_FOREIGN}.dot", one=True, texts=True),
    Format("mermaid", "Mermaid state diagram", (".mmd", ".mermaid"), f"{_FOREIGN}.mermaid", one=True, texts=True),
    Format("hoa", "Hanoi omega-automata", (".hoa",), f"{_FOREIGN}.hoa", one=True, texts=True, reads=False),
)  # fmt: skip
_HEAD = 4_096  # bytes in which the root of an XML file stands
_ROOT = re.compile(rb"<(?![?!])\s*([^>]*>?)")


def format_named(name: str) -> Format:
    """Return the format called ``name``; raise UnknownName if there is none.

    >>> format_named("tct").endings
    ('.DES',)
    """
    for format in FORMATS:
        if format.name == name:
            return format
    raise UnknownName("format", name, [format.name for format in FORMATS])


def format_of(path: str | os.PathLike[str], data: bytes = b"") -> Format:
    """Return the format that the ending of ``path`` tells, and the beginning of ``data`` where several share it.

    Raises InputError for an ending that no format has.

    >>> format_of("MACH1.DES").name, format_of("plant.xml", b"<Automata name='A'>").name
    ('tct', 'supremica')
    """
    ending = Path(path).suffix.lower()
    found = [format for format in FORMATS if ending in map(str.lower, format.endings)]
    if not found:
        what = f"unknown ending {ending!r}" if ending else "no ending"
        known = {ending for format in FORMATS if format.module and format.reads for ending in format.endings}
        others = ", ".join(sorted(known, key=str.lower))
        raise InputError(f"{path}: {what}; a model file ends with .toml or .json, another tool's with {others}")
    root = _ROOT.search(data[:_HEAD])
    told = [format for format in found if format.root and root and re.match(format.root, root[1])]
    return (told or found)[0]
