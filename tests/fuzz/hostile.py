"""Files that want to take all memory, all time, or another file; each format's are read in a process of its own.

``python -m tests.fuzz.hostile FORMAT`` reads those of one format, with little memory, and prints what became of each.
"""

from __future__ import annotations

import resource
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from random import Random
from time import perf_counter
from traceback import extract_tb

from tests.fuzz import hostile_automata, hostile_models, hostile_xml
from tests.fuzz.harness import check, read
from tests.fuzz.hostile_models import DEEP
from tests.fuzz.seeds import small_seeds

from thenar.io.formats import Format, format_named

__all__ = ["MEMORY", "SECONDS", "cases", "main"]

MEMORY = 1_500 * 2**20  # bytes of address space, some 500 MiB of which are the interpreter's and NumPy's
SECONDS = 20.0  # for one file, on a busy machine
Cases = Iterator[tuple[str, bytes]]


def cases(format: Format) -> Cases:
    """Yield the names of hostile files of ``format``, and the files."""
    yield from _encodings(format)
    yield from _long(format)
    yield from _deep(format)
    if format.name in hostile_xml.OWN:
        yield from hostile_xml.entities(format.name)
    for name, text in _OWN[format.name]():
        yield name, text.encode() if isinstance(text, str) else text


# -- what every format may meet ----------------------------------------------------------------------------------


def _encodings(format: Format) -> Cases:
    seed = next(iter(small_seeds(format)))
    yield "nothing", b""
    yield "white space", b" \n\t\r\n" * 1_000
    yield "NUL bytes", b"\0" * 100_000
    yield "NUL bytes behind", seed + b"\0" * 100
    yield "NUL bytes within", seed[: len(seed) // 2] + b"\0\0" + seed[len(seed) // 2 :]
    yield "a byte order mark alone", b"\xef\xbb\xbf"
    yield "a byte order mark", b"\xef\xbb\xbf" + seed
    yield "two byte order marks", b"\xef\xbb\xbf\xef\xbb\xbf" + seed
    yield "half a character", seed + "ä".encode()[:1]
    yield "half a UTF-16 surrogate", seed.replace(b"LAMP", b"\xed\xa0\x80")
    text = seed.decode("latin-1").replace("LAMP", "LÄMP")
    for encoding in ("latin-1", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-7", "cp037"):
        yield encoding, text.encode(encoding)
    yield "every byte", bytes(range(256)) * 100


def _long(format: Format) -> Cases:
    seed = next(iter(small_seeds(format)))
    yield "10 MB of a letter", b"a" * 10_000_000
    yield "10 MB of a digit", b"1" * 10_000_000
    yield "10 MB of spaces and a letter", b" " * 10_000_000 + b"a"
    for name in (b"LAMP", b"dark", b"on", b"lit"):
        if name in seed:
            yield f"a name of 500 kB for {name.decode()}", seed.replace(name, b"y" * 500_000)
            yield f"{name.decode()} with a name of 500 kB behind it", seed.replace(name, name + b" " + b"z" * 500_000)
            yield f"{name.decode()} once with a name of 200 kB", seed.replace(name, _WORDS, 1)
            yield f"{name.decode()} twice with a name of 200 kB", seed.replace(name, _WORDS).replace(_WORDS, _OTHER, 1)
    line = max(seed.splitlines(), key=len)
    for sign in b"<>[]{}()\"'#/%&;:,=!-+*\\.|~@\t":
        yield f"a line and 300 kB of {chr(sign)}", seed.replace(line, line + bytes([sign]) * 300_000)
        yield f"a line and 100 kB of {chr(sign)}a", seed.replace(line, line + (bytes([sign]) + b"a") * 50_000)


# of 211 letters, none of them rare or frequent: to find similar names among these takes very long
_WORDS = "".join(chr(0x4E00 + k * k % 211) for k in range(70_000)).encode()
_OTHER = "".join(Random(5).sample(_WORDS.decode(), 70_000)).encode()  # the same letters


def _deep(format: Format) -> Cases:
    seed = next(iter(small_seeds(format)))
    half = len(seed) // 2
    for opening, closing in ("()", "[]", "{}", "<>"):
        nested = (opening * DEEP + closing * DEEP).encode()
        yield f"nothing but {opening}{closing}, deep", nested
        yield f"{opening} without an end", opening.encode() * DEEP
        yield f"{opening}{closing} within", seed[:half] + nested + seed[half:]
    yield "elements in one another", b"<a>" * DEEP + b"</a>" * DEEP
    for tag in _NESTED.get(format.name, ()):
        opening, closing = f"<{tag}>", f"</{tag.split()[0]}>"
        at = seed.rfind(b"</")
        nested = (opening * DEEP + closing * DEEP).encode()
        yield f"{opening} in one another, in the last", seed[:at] + nested + seed[at:]
        shallow = (opening * 400 + closing * 400).encode()
        yield f"400 of {opening} in one another", seed[:at] + shallow + seed[at:]


_NESTED = {
    "wmod": ("ComponentList", "EventAliasList", 'ForeachComponent Name="i"', "ConditionalComponent"),
    "supremica": ("Automaton", "States", "Layout"),
    "ides": ("state", "meta", "data"),
    "faudes": ("Generator", "Alphabet", "x"),
    "faudes-xml": ("Generator", "State", "x"),
}


_OWN: Mapping[str, Callable[[], Iterator[tuple[str, str | bytes]]]] = {
    **hostile_models.OWN,
    **hostile_automata.OWN,
    **hostile_xml.OWN,
}


# -- the process ---------------------------------------------------------------------------------------------------


def main(name: str) -> None:
    """Read the hostile files of the format called ``name``; print each one's name, its seconds, and what went wrong."""
    format = format_named(name)
    for seed in small_seeds(format):  # imports what is imported when it is needed
        check(seed, name)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGALRM, _too_long)
    for case, data in cases(format):
        print(case, end="\t", flush=True)
        begin = perf_counter()
        signal.setitimer(signal.ITIMER_REAL, SECONDS)
        try:
            read(data, name)
            wrong = ""
        except Exception as error:  # whatever it is, it is what this process is here to tell
            where = [f"{frame.filename}:{frame.lineno}" for frame in extract_tb(error.__traceback__)[-3:]]
            wrong = f"{type(error).__name__}: {str(error)[:200]!r} at {' < '.join(reversed(where))}"
        signal.setitimer(signal.ITIMER_REAL, 0)
        print(f"{perf_counter() - begin:.2f}\t{wrong}", flush=True)


def _too_long(signal_number: int, frame: object) -> None:
    raise TimeoutError(f"more than {SECONDS} seconds")


if __name__ == "__main__":
    main(sys.argv[1])
