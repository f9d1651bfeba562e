"""The words of libFAUDES's text files: strings, numbers, options and the begins and ends of sections."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NoReturn

from thenar.errors import Mistake, ModelError

__all__ = ["NotPlainError", "Token", "Tokens", "decoded", "is_index", "unescaped", "unquoted"]

_TOKEN = re.compile(
    r"""
      (?P<space> (?: [\x00-\x20\x7f]+ | %[^\r\n]* | <!--.*?--> | <\?.*?\?> | <![Dd][^>]*> )+ )
    | "(?P<quoted> [^"<>]* )"
    | '(?P<single> [^'<>]* )'
    | \+(?P<option> [^+<>]* )\+
    | =(?P<binary> [^=<>]* )=+
    | <!\[CDATA\[(?P<data> .*? )\]\]>
    | </(?P<end> [^\x00-\x20/<>]++ )[^<>]*+>
    | <(?P<begin> [A-Za-z_:][^\x00-\x20/<>]*+ )(?P<attributes> [^<>]*? )(?P<empty> /? )>
    | (?P<word> [^\x00-\x20\x7f<>"'+=%] [^\x00-\x20\x7f<>]* )
    """,
    re.VERBOSE | re.DOTALL,
)
_ATTRIBUTE = re.compile(  # a name begins where the one before ends: else long words take the square of their length
    r"""(?<![^\x00-\x20=/"'])([^\x00-\x20=/"']++)[\x00-\x20]*+=[\x00-\x20]*+"""
    r"""(?:"([^"]*+)"|'([^']*+)'|([^\x00-\x20/]++))"""
)
_CONTROLS = re.compile(r"[\x00-\x1f\x7f]+")
_ENTITY = re.compile(r"&(amp|quot|apos|lt|gt);")
_ENTITIES = {"amp": "&", "quot": '"', "apos": "'", "lt": "<", "gt": ">"}
_WIDER_SPACE = re.compile("[\\x1c-\\x1f\\x85\\xa0\\u1680\\u2000-\\u200a\\u2028\\u2029\\u202f\\u205f\\u3000]")
_INDEX = re.compile(r"[0-9]{1,18}")
_NUMBER = re.compile(r"0x[0-9A-Fa-f]+|-?[0-9]+|-?[0-9]*\.[0-9]*|[+-]?inf|[Tt]rue|[Ff]alse")
MAX_DEPTH = 500  # sections within sections


class NotPlainError(Exception):
    """A section is not of plain words only, or something is wrong with it: it is to be read token by token."""


@dataclass(frozen=True, slots=True)
class Token:
    """A word of a file, of its text or its XML.

    ``kind`` is "string", "index" (a number that is not negative), "number" (any other, or a truth), "option",
    "binary", "begin", "end" or "nothing"; ``text`` is what it says, ``raw`` as written.
    """

    kind: str
    text: str
    position: int
    attributes: Mapping[str, str]
    raw: str = ""

    @property
    def is_element(self) -> bool:
        """Whether it is an element of a list; what else follows an element says something about it."""
        return self.kind in ("string", "index")


class Tokens:
    """Reads the tokens of a text one after the other, and can look one ahead.

    >>> tokens = Tokens('<Alphabet> "a" +C+ b </Alphabet>', "g.gen")
    >>> [(token.kind, token.text) for token in iter(tokens.next, None) if token.kind != "nothing"][:4]
    Traceback (most recent call last):
    thenar.errors.ModelError: g.gen:1:33: the file ends within a section
    """

    def __init__(self, text: str, source: str) -> None:
        self.text = text
        self.source = source
        self.position = 0
        self.pending: Token | None = None
        self.counted, self.line, self.line_start = 0, 1, 0

    def peek(self) -> Token:
        """Return the next token without taking it; of the kind "nothing" at the end."""
        if self.pending is None:
            self.pending = self._read()
        return self.pending

    def next(self) -> Token:
        """Take the next token; ModelError at the end of the file."""
        token = self.peek()
        if token.kind == "nothing":
            self.fail(token.position, "the file ends within a section")
        self.pending = _end_of(token) if token.kind == "begin" and token.raw == "/" else None
        return token

    def take(self, wanted: Callable[[Token], bool], what: str) -> Token:
        """Take the next token, which has to be ``wanted``, ``what`` in words."""
        token = self.next()
        if not wanted(token):
            shown = token.text if len(token.text) <= 40 else token.text[:40] + "..."
            self.fail(token.position, f"{what} is expected here, not the {token.kind} {shown!r}")
        return token

    def ends(self, section: str) -> bool:
        """Return whether ``section`` ends here, and take its end; ModelError if another one ends."""
        token = self.peek()
        if token.kind == "end" and token.text != section:
            self.fail(token.position, f"</{token.text}> does not end <{section}>")
        if token.kind == "end":
            self.next()
        return token.kind == "end"

    def skip_section(self) -> list[Token]:
        """Take a section, to its end, and return the tokens in it."""
        sections = [self.next().text]
        within = []
        while sections:
            token = self.next()
            if token.kind == "begin":
                sections.append(token.text)
                if len(sections) > MAX_DEPTH:
                    self.fail(token.position, f"more than {MAX_DEPTH} sections within one another")
            elif token.kind == "end" and sections.pop() != token.text:
                self.fail(token.position, f"</{token.text}> ends another section than the one that is open")
            within.append(token)
        return within[:-1]

    def plain(self) -> str | None:
        """Return the text up to the end of the section, and go there; None if there is other markup before.

        Its words, as ``split`` gives them, are those of libFAUDES unless one is refused by :func:`unquoted`.
        """
        stop = self.text.find("<", self.position)
        if self.pending is not None or stop < 0 or not self.text.startswith("</", stop):
            return None
        text = self.text[self.position : stop]
        if not text.isascii() and _WIDER_SPACE.search(text):
            return None
        self.position = stop
        return text

    def where(self, position: int) -> str:
        """Return the place, as messages call it; lines are counted on from the last place that was asked for."""
        if position < self.counted:
            self.counted, self.line, self.line_start = 0, 1, 0
        self.line += self.text.count("\n", self.counted, position)
        self.line_start = self.text.rfind("\n", self.counted, position) + 1 or self.line_start
        self.counted = position
        return f"{self.source}:{self.line}:{position - self.line_start + 1}"

    def fail(self, position: int, what: str) -> NoReturn:
        """Raise ModelError: ``what`` is wrong at ``position``."""
        raise ModelError([Mistake(self.where(position), what)])

    def _read(self) -> Token:
        while True:
            start = self.position
            if start == len(self.text):
                return Token("nothing", "", start, {})
            match = _TOKEN.match(self.text, start)
            if match is None:
                self.fail(start, f"no word of libFAUDES begins with {self.text[start]!r} here, or it does not end")
            self.position = match.end()
            if match.lastgroup != "space":
                return self._token(match)

    def _token(self, match: re.Match[str]) -> Token:
        start = match.start()
        if match["begin"] is not None:
            found = _ATTRIBUTE.findall(match["attributes"])
            attributes = {name: unescaped(a or b or c) for name, a, b, c in found}
            return Token("begin", match["begin"], start, attributes, match["empty"])
        for kind in ("end", "option", "binary"):
            if match[kind] is not None:
                return Token(kind, match[kind], start, {})
        for group in ("quoted", "single", "data"):
            if match[group] is not None:
                return Token("string", unescaped(match[group]), start, {})
        word = match["word"]
        kind = "index" if is_index(word) else "number" if _NUMBER.fullmatch(word) else "string"
        return Token(kind, unescaped(word), start, {}, word)


def _end_of(begin: Token) -> Token:
    return Token("end", begin.text, begin.position, {})


def decoded(data: bytes) -> str:
    """Return ``data`` as text: UTF-8, or Latin-1 if it is not that; what XML declares is not looked at.

    libFAUDES copies bytes, and declares Latin-1 whatever they are.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def unquoted(word: str) -> str:
    """Return what a plain word says; raise NotPlainError for one that has to be read as a token.

    >>> unquoted('"a"'), unquoted("a")
    ('a', 'a')
    """
    if word[0] == word[-1] == '"' and word.count('"') == 2 and "&" not in word and len(word) > 2:
        return word[1:-1]
    if word[0] in "\"'+=%" or "&" in word or not word.isprintable():
        raise NotPlainError
    if _NUMBER.fullmatch(word) and not is_index(word):
        raise NotPlainError
    return word


def is_index(word: str) -> bool:
    """Return whether a plain word is an index.

    >>> is_index("12"), is_index("-1"), is_index("¹")
    (True, False, False)
    """
    return _INDEX.fullmatch(word) is not None


def unescaped(text: str) -> str:
    """Return what a string of libFAUDES says: control characters are blanks, ``&lt;`` and its like characters.

    >>> unescaped("a&lt;b&amp;c")
    'a<b&c'
    """
    if not text.isprintable():
        text = _CONTROLS.sub(" ", text)
    return _ENTITY.sub(lambda match: _ENTITIES[match[1]], text) if "&" in text else text
