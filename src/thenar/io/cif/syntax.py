"""The text of a CIF file: its syntax tree, and the place and the words for what cannot be read."""

from __future__ import annotations

import re
from functools import cache
from importlib.resources import files
from typing import NoReturn, TypeAlias

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedEOF, UnexpectedInput, UnexpectedToken

from thenar.errors import Mistake, ModelError

__all__ = ["Node", "children", "fail", "parse", "place", "unsupported", "words"]

Node: TypeAlias = Tree[Token] | Token
"""A piece of the text: a token, or a construct with what it is made of."""

_UNSUPPORTED = {
    "cont": "continuous variable",
    "der": "derivative",
    "time": "the time that has passed",
    "urgent": "urgent location",
    "now": "urgent edge",
    "func": "function",
    "sample": "stochastic value",
    "dist": "distribution",
    "real": "real number",
    "string": "text",
    "list": "list",
    "set": "set",
    "dict": "dictionary",
    "tuple": "tuple",
    "self": "reference to the automaton itself",
    "tau": "internal event",
}
_CHANNEL = "channel"  # what is called so has no word of its own in CIF
_READ = "thenar reads events, bounded variables, automata and invariants; see docs/cif.md"
MAX_TEXT = 5_000_000  # characters; ten seconds or so
_SHOWN = 40  # characters of the text that a message repeats
_WORDS = {  # tokens as a reader knows them
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a text",
    "REAL": "a real number",
    "KIND": "'plant', 'requirement' or 'supervisor'",
    "CONTROLLABILITY": "'controllable' or 'uncontrollable'",
    "SEMICOLON": "';'",
    "COLON": "':'",
    "COMMA": "','",
    "LPAR": "'('",
    "RPAR": "')'",
    "RBRACE": "'}'",
    "RSQB": "']'",
    "EQUAL": "'='",
    "__ANON_0": "'..'",
    "__ANON_1": "':='",
}
_AFTER_EXPRESSION = {"OPERATOR", "SIGN", "AND", "OR", "DIV", "MOD", "IN"}


def parse(text: str, source: str) -> Tree[Token]:
    """Return the syntax tree of ``text``; ``source`` is what messages call it.

    Raises ModelError with the line and the column of what cannot be read.

    >>> parse("plant p: location; end", "p.cif").children[0].data
    'automaton'
    >>> parse("plant p:\\n  cont t; location; end", "p.cif")
    Traceback (most recent call last):
    thenar.errors.ModelError: p.cif:2:3: CIF construct 'cont' (continuous variable) is not supported; ...
    """
    if len(text) > MAX_TEXT:
        raise ModelError(
            [Mistake(source, f"more than {MAX_TEXT:,} characters; no CIF model that is written needs them")]
        )
    try:
        return _parser().parse(text)
    except UnexpectedInput as error:
        raise ModelError([_mistake(error, text, source)]) from None


@cache
def _parser() -> Lark:
    grammar = files(__package__).joinpath("grammar.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", lexer="basic", propagate_positions=True)


def _mistake(error: UnexpectedInput, text: str, source: str) -> Mistake:
    if isinstance(error, UnexpectedEOF) or (isinstance(error, UnexpectedToken) and error.token.type == "$END"):
        line = text.count("\n") + 1
        return Mistake(f"{source}:{line}", f"the text ends too early; {_expectation(error)}")
    at = error.pos_in_stream or 0
    where = f"{source}:{error.line}:{error.column}"
    statement = max(text.rfind(";", 0, at), text.rfind(":\n", 0, at), text.rfind("}", 0, at), 0)
    for before in re.finditer(r"[A-Za-z_]\w*", _without_comments(text[statement:at])):
        if before[0] in _UNSUPPORTED and before[0] != "string":
            return Mistake(_where(text, statement + before.start(), source), unsupported(before[0]))
    if text.startswith("/*", at):
        return Mistake(where, "this comment has no end")
    if isinstance(error, UnexpectedCharacters):
        what = "this text has no end in its line" if text[at] == '"' else f"CIF does not use the character {text[at]!r}"
        return Mistake(where, what)
    word = str(getattr(error, "token", ""))[:_SHOWN]
    if word in _UNSUPPORTED or word in ("?", "!", "~"):
        return Mistake(where, unsupported(word if word in _UNSUPPORTED else _CHANNEL))
    return Mistake(where, f"{word!r} cannot stand here; {_expectation(error)}")


def _without_comments(text: str) -> str:
    """Blank out what is no code, keeping every position."""
    return re.sub(r"//[^\n]*|/\*.*?\*/|\"[^\"\n]*\"", lambda found: " " * len(found[0]), text, flags=re.DOTALL)


def _where(text: str, position: int, source: str) -> str:
    return f"{source}:{text.count(chr(10), 0, position) + 1}:{position - text.rfind(chr(10), 0, position)}"


def _expectation(error: UnexpectedInput) -> str:
    expected = set(getattr(error, "accepts", None) or ())
    if "$END" in expected:
        return "a declaration, an automaton or a group should"
    if {"ALPHABET", "LOCATION"} <= expected:
        return "a declaration or a location should"
    if {"NUMBER", "NAME", "LPAR"} <= expected:
        return "an expression should"
    if expected >= _AFTER_EXPRESSION:
        expected = (expected - _AFTER_EXPRESSION - {"EQUAL"}) | {"an operator"}
    known = sorted(_WORDS.get(e, f"'{e.lower()}'" if e.isupper() else e) for e in expected)
    return f"{' or '.join(known)} should" if len(known) <= 2 else f"one of {', '.join(known)} should"


def unsupported(word: str) -> str:
    """Return the sentence that says that the construct called ``word`` is not read."""
    meaning = "event with a sender and a receiver" if word == _CHANNEL else _UNSUPPORTED[word]
    return f"CIF construct {word!r} ({meaning}) is not supported; {_READ}"


def words() -> frozenset[str]:
    """Return the words of CIF that stand for what is not read."""
    return frozenset(_UNSUPPORTED)


def place(node: Node | None, source: str) -> str:
    """Return ``file:line:column`` of ``node``."""
    if isinstance(node, Token):
        return f"{source}:{node.line}:{node.column}"
    if node is None or node.meta.empty:
        return source
    return f"{source}:{node.meta.line}:{node.meta.column}"


def fail(node: Node | None, source: str, what: str) -> NoReturn:
    """Raise ModelError: ``node`` is wrong, and ``what`` says how."""
    raise ModelError([Mistake(place(node, source), what)])


def children(tree: Tree[Token], data: str) -> list[Tree[Token]]:
    """Return the constructs called ``data`` directly in ``tree``."""
    return [c for c in tree.children if isinstance(c, Tree) and c.data == data]
