"""The real TCT (pip ``pitct``) and libFAUDES (pip ``faudes``) read a file of ours and write it again.

Each answers for many files at once, in its own process: a call costs more than a file.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tests.oracles.worker import isolate


@isolate("pitct")
def tct_creates(automata: Sequence[tuple[int, list[tuple[int, int, int]], list[int]]]) -> list[bytes]:
    """Return the DES files that TCT makes of (number of states, transitions, marked states)."""
    return [_tct(lambda tct, a=a: tct.create("NEW", *a)) for a in automata]


@isolate("pitct")
def tct_rewrites(files: Sequence[bytes]) -> list[bytes]:
    """Return the DES files as TCT writes them again; its selfloop with no events changes nothing."""
    return [_tct(lambda tct: tct.selfloop("NEW", "OLD", []), data) for data in files]


@isolate("pitct")
def tct_syncs(pairs: Sequence[tuple[bytes, bytes]]) -> list[bytes]:
    """Return the DES files of TCT's sync of two DES files each."""
    return [_tct(lambda tct: tct.sync("NEW", "OLD", "OTHER"), a, b) for a, b in pairs]


@isolate("pitct")
def tct_condat(plant: bytes, supervisor: bytes) -> bytes:
    """Return the DAT file of TCT's condat."""
    return _tct(lambda tct: tct.condat("NEW", "OLD", "OTHER"), plant, supervisor, ending=".DAT")


def _tct(do: Any, *files: bytes, ending: str = ".DES") -> bytes:
    import pitct

    with TemporaryDirectory() as folder:
        pitct.init(folder, overwrite=True)
        for name, data in zip(("OLD", "OTHER"), files, strict=False):
            Path(folder, f"{name}.DES").write_bytes(data)
        do(pitct)
        return Path(folder, f"NEW{ending}").read_bytes()


@isolate("faudes")
def faudes_rewrites(files: Sequence[bytes], *, system: bool = True) -> list[tuple[bytes, bytes]]:
    """Return each file as libFAUDES writes it again, as text and as XML, as a System or as a plain Generator."""
    import faudes

    answers = []
    with TemporaryDirectory() as folder:
        for data in files:
            old, text, xml = (Path(folder, name) for name in ("old.gen", "new.gen", "new.xml"))
            old.write_bytes(data)
            generator = (faudes.System if system else faudes.Generator)(str(old))
            generator.Write(str(text))
            generator.XWrite(str(xml))
            answers.append((text.read_bytes(), xml.read_bytes()))
    return answers
