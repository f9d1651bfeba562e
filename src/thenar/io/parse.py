"""The text of a model file, and where in it a mistake stands."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from thenar.errors import InputError, Mistake, ModelError
from thenar.model.build import Complaint, KeyPath, place_in_words

__all__ = ["Document", "Format", "decode", "sniff"]

Format = Literal["toml", "json"]

_LEVELS = 6  # file, automata, one automaton, its transitions, one of them, its triple or updates

# The beginning of a parser's message, and what to do about it.
_TOML_ADVICE = (
    ("Expected '=' after a key", "expected '=' after the key; a name with other characters than letters, digits, "
     "'-' and '_' stands in double quotes"),
    ("Invalid value", "expected a value; text stands in double quotes, and every list ends with ']'"),
    ("Invalid statement", "expected 'key = value' or a [table]; a name with other characters than letters, digits, "
     "'-' and '_' stands in double quotes"),
    ("Invalid initial character for a key part", "expected a key; a table in braces stays on one line, "
     "without a comma at its end"),
    ("Illegal character", "a line break or control character inside a text; close its quotes on the same line, "
     'or put """ around several lines'),
    ("Unterminated string", "a text is not closed; add the quotes at its end"),
    ("Unescaped '\\' in a string", "unknown escape in a text; write '\\\\' for a backslash"),
    ("Unclosed array", "expected ',' or ']' in a list"),
    ("Unclosed inline table", "expected ',' or '}' in a table in braces"),
    ("Cannot mutate immutable namespace", "a table in braces is complete; write the key inside the braces"),
    ("Expected newline or end of document", "expected the end of the line after the value; one 'key = value' a line"),
)  # fmt: skip
_JSON_ADVICE = (
    ("Expecting property name", "expected a key in double quotes; JSON has no comments and no comma before '}'"),
    ("Illegal trailing comma", "a comma before the closing bracket; JSON has none there"),
    ("Expecting value", "expected a value; text stands in double quotes, and JSON has no comments and no comma "
     "before ']'"),
    ("Expecting ',' delimiter", "expected ',' or a closing bracket"),
    ("Expecting ':' delimiter", "expected ':' after the key"),
    ("Extra data", "expected the end of the file; everything stands in one pair of braces"),
    ("Unterminated string", "a text is not closed; add the quotes at its end"),
    ("Invalid control character", "a line break or control character inside a text; write '\\n' for a line break"),
    ("Invalid \\", "unknown escape in a text; write '\\\\' for a backslash"),
)  # fmt: skip
# What stands for more than it says: tomllib's time and memory grow with the square of the parts of a key.
_PARTS = 16
_DOTS = re.compile(rf"(?:\.[^.\n]*+){{{_PARTS}}}")  # quickly: is there anything to look at?
_OPAQUE = re.compile(
    r'''"""(?:[^"\\]|\\.|"(?!""))*+(?:""")?|"(?:[^"\\\n]|\\.)*+"?|'''
    r"""'''(?:[^']|'(?!''))*+(?:''')?|'[^'\n]*+'?|\#[^\n]*+""",
    re.DOTALL,
)
_LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{_PARTS}}}")
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")
_TOML_TWICE = ("Cannot overwrite", "Cannot declare", "Cannot mutate", "Duplicate inline table key")


@dataclass(frozen=True, slots=True)
class Document:
    """A model file's text; ``source`` is what messages call it."""

    source: str
    format: Format
    text: str

    def data(self) -> Any:
        """Return the tables and lists that the text describes.

        Raises ModelError with file, line and column for a syntax error, with the lines for a key given twice,
        and InputError for an empty text and one that nests too deeply to be read.

        >>> Document("lamp.json", "json", '{"name": lamp}').data()
        Traceback (most recent call last):
        thenar.errors.ModelError: lamp.json:1:10: expected a value; text stands in double quotes, ...
        """
        if not self.text.strip():
            raise InputError(f"{self.source}: the file is empty; a model file gives events and automata")
        try:
            self.text.encode()
            if self.format == "toml":
                self._check_keys()
                return tomllib.loads(self.text)
            data = self._json()
            if "\\u" in self.text and _SURROGATE.search(self.text):  # two make a character, and one alone makes no text
                json.dumps(data, ensure_ascii=False).encode()
            return data
        except json.JSONDecodeError as error:
            raise self._syntax(error.lineno, error.colno, error.msg, _JSON_ADVICE) from None
        except tomllib.TOMLDecodeError as error:
            if str(error).startswith(_TOML_TWICE) and (twice := self._given_twice()):
                raise ModelError(twice) from None
            raise self._toml_syntax(str(error)) from None
        except RecursionError:
            message = f"nested too deeply; a model file has {_LEVELS} levels at most"
            raise InputError(f"{self.source}: {message}") from None
        except UnicodeEncodeError as error:
            half = error.object[error.start]
            raise InputError(f"{self.source}: {half!r} is half a character; write the character itself") from None
        except ValueError:  # the one that the parsers let through
            raise InputError(f"{self.source}: a number of thousands of digits; a model file needs no such") from None

    def mistakes(self, complaints: Sequence[Complaint], written: Mapping[KeyPath, str | int]) -> list[Mistake]:
        """Say of each complaint where in the text its culprit stands, in the order of the text.

        ``written`` holds how a key is written in the text where that differs from how complaints call it.
        """
        if not complaints:
            return []
        from thenar.io.locate import Places

        places = Places(self.text, self.format)
        located = set()
        for path, what in complaints:
            in_text = [written.get(path[: k + 1], step) for k, step in enumerate(path)]
            located.add((places.line(in_text), path, what))
        return [Mistake(f"{self.source}:{line}", f"{_words(path)}{what}") for line, path, what in sorted(located)]

    def _json(self) -> Any:
        """Return what JSON's parser finds; ModelError for keys given twice, once all else is right."""
        twice = False

        def table(pairs: list[tuple[str, object]]) -> dict[str, object]:
            nonlocal twice
            made = dict(pairs)
            twice |= len(made) < len(pairs)
            return made

        data = json.loads(self.text, object_pairs_hook=table)
        if twice:
            raise ModelError(self._given_twice() or [Mistake(self.source, "a key is given twice; keep one of them")])
        return data

    def _check_keys(self) -> None:
        """Raise ModelError for a key of very many parts."""
        if self.text.count(".") < _PARTS or not _DOTS.search(self.text):
            return
        bare = _OPAQUE.sub(lambda found: "s" + "\n" * found[0].count("\n"), self.text)
        if long := _LONG_KEY.search(bare):
            line = bare.count("\n", 0, long.start()) + 1
            what = f"a key of more than {_PARTS} parts; a model file has {_LEVELS} levels at most"
            raise ModelError([Mistake(f"{self.source}:{line}", what)])

    def _given_twice(self) -> list[Mistake]:
        from thenar.io.locate import Places

        repeated = Places(self.text, self.format).repeated()
        again = sorted((line, path, lines[0]) for path, lines in repeated for line in lines[1:])
        return [
            Mistake(f"{self.source}:{line}", f"{_words(path)}given twice, first in line {first}; keep one of them")
            for line, path, first in again
        ]

    def _toml_syntax(self, message: str) -> ModelError:
        place = re.search(r" \(at line (\d+), column (\d+)\)$", message)
        if place:
            return self._syntax(int(place[1]), int(place[2]), message[: place.start()], _TOML_ADVICE)
        lines = self.text.rstrip().split("\n")  # at the end of the document, in words
        return self._syntax(len(lines), len(lines[-1]) + 1, message.partition(" (at end")[0], _TOML_ADVICE)

    def _syntax(self, line: int, column: int, message: str, advice: Sequence[tuple[str, str]]) -> ModelError:
        way_out = next((words for start, words in advice if message.startswith(start)), message)
        return ModelError([Mistake(f"{self.source}:{line}:{column}", way_out)])


def sniff(text: str) -> Format:
    """Tell the format of ``text``: JSON begins with a brace, TOML cannot."""
    return "json" if text.lstrip().startswith("{") else "toml"


def decode(raw: bytes, source: str) -> str:
    """Return ``raw`` as text; raise InputError naming ``source`` for bytes that are not UTF-8."""
    try:
        return raw.decode().removeprefix("\ufeff")  # some editors put a byte order mark before UTF-8
    except UnicodeDecodeError as error:
        byte = f"byte 0x{raw[error.start]:02x} at offset {error.start:,}"
        raise InputError(f"{source}: not UTF-8 text: {byte}; save it as UTF-8") from None


def _words(path: Sequence[str | int]) -> str:
    """Say where ``path`` leads, as the beginning of a sentence."""
    match path:
        case []:
            return ""
        case ["events", name, *inner]:
            words = f"event {name!r}"
        case ["automata", name, *inner]:
            words = f"automaton {name!r}"
        case ["variables", name, *inner]:
            words = f"variable {name!r}"
        case ["conditions", int(k), *inner]:
            words = f"condition {k + 1}"
        case ["computed" | "published" as key, name, *inner]:
            words = f"{key} size {name!r}"
        case [name, *inner]:
            words = str(name)
    return ", ".join([words, *_inside(inner, path[0] == "variables")]) + ": "


def _inside(path: Sequence[str | int], of_variable: bool) -> list[str]:
    match path:
        case []:
            return []
        case ["transitions", int(k), "do", variable]:
            return [f"transition {k + 1}", f"do {variable!r}"]
        case ["transitions", int(k), key]:
            return [f"transition {k + 1}", str(key)]
        case ["initial", int(k)]:
            return [f"initial {'value' if of_variable else 'state'} {k + 1}"]
        case ["values" | "marked" as key, int(k)] if of_variable:
            return [f"{'marked ' * (key == 'marked')}value {k + 1}"]
    return [place_in_words(path)]
