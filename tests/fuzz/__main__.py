"""Fuzz the readers, one after the other: ``python -m tests.fuzz [--seconds 30] [FORMAT ...]``, or ``make fuzz``."""

from __future__ import annotations

import argparse
import shlex
import subprocess
import sys
from hashlib import sha1
from pathlib import Path

from tests.fuzz.harness import check
from tests.fuzz.seeds import dictionary, seeds

from thenar.io.formats import FORMATS, format_named

WORK = Path("out", "fuzz")  # the corpus and what was found, kept from run to run; git ignores it
LONGEST = 65_536  # bytes of an input
INPUT_SECONDS = 20  # that one input may take, on a busy machine
MEMORY = 2_048  # MiB that the process may take, some 200 of them its own


def fuzz(name: str, seconds: int) -> list[Path]:
    """Fuzz the reader of the format called ``name`` for ``seconds``; return the inputs that it should not fail on."""
    corpus, found = WORK / name / "corpus", WORK / name / "found"
    for folder in (corpus, found):
        folder.mkdir(parents=True, exist_ok=True)
    for seed in seeds(format_named(name)):
        (corpus / sha1(seed).hexdigest()).write_bytes(seed)
    words = WORK / name / "words"
    words.write_text(dictionary(name), encoding="utf-8")
    before = set(found.iterdir())
    options = {
        "dict": words,
        "artifact_prefix": f"{found}/",
        "max_total_time": seconds,
        "timeout": INPUT_SECONDS,
        "report_slow_units": INPUT_SECONDS,  # else what takes half as long is kept too
        "rss_limit_mb": MEMORY,
        "max_len": LONGEST,
        "print_final_stats": 1,
    }
    command = [
        sys.executable,
        "-m",
        "tests.fuzz.harness",
        name,
        *(f"-{k}={v}" for k, v in options.items()),
        str(corpus),
    ]
    with (WORK / name / "log").open("wb") as log:
        failed = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, check=False).returncode
    new = sorted(set(found.iterdir()) - before)
    if failed and not new:
        sys.exit(f"{name}: the fuzzer itself failed; see {log.name}")
    return new


def _executed(name: str) -> str:
    """Return how many inputs were tried, as libFuzzer counts them."""
    lines = (WORK / name / "log").read_text(encoding="utf-8", errors="replace").splitlines()
    counts = [line.rpartition(" ")[2] for line in lines if line.startswith("stat::number_of_executed_units")]
    return f"{int(counts[-1]):,} inputs" if counts else "stopped"


def main() -> None:
    """Fuzz, or try again what was found."""
    names = [format.name for format in FORMATS if format.reads]
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description="Fuzz the readers of model files.")
    parser.add_argument("formats", nargs="*", metavar="FORMAT", help=f"{', '.join(names)}; all by default")
    parser.add_argument("--seconds", type=int, default=30, help="for each format (default: 30)")
    parser.add_argument("--again", type=Path, metavar="FILE", help="read this input once, as the one FORMAT")
    given = parser.parse_args()
    if strange := [name for name in given.formats if name not in names]:
        parser.error(f"no readable format {strange[0]!r}; there are {', '.join(names)}")
    if given.again is not None:
        if len(given.formats) != 1:
            parser.error("--again needs the one format to read the input as")
        check(given.again.read_bytes(), given.formats[0])
        return
    bad = 0
    for name in given.formats or names:
        new = fuzz(name, given.seconds)
        print(f"{name}: {_executed(name)}, {len(new)} that should not fail", flush=True)
        for path in new:
            bad += 1
            print(f"  {shlex.join([sys.executable, '-m', 'tests.fuzz', name, '--again', str(path)])}", flush=True)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
