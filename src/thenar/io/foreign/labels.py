"""Names of the XML formats: what may be an event's, what may stand in an attribute, and names for what has none."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from xml.sax.saxutils import quoteattr

from thenar.errors import InputError
from thenar.model.automaton import Automaton
from thenar.model.extended import ExtendedAutomaton

__all__ = ["check_names", "quoted", "titles", "written_name"]

_NOT_IN_EVENTS = re.compile(r"[\s,]")


def written_name(label: str, taken: dict[str, str]) -> str:
    """Return the name of the event that a file calls ``label``: white space and commas are ``_``, names stay different.

    ``taken`` is the label of each name so far, and is added to.

    >>> taken = {}
    >>> written_name("move(1, 2)", taken), written_name("move(1__2)", taken), written_name("move(1, 2)", taken)
    ('move(1__2)', 'move(1__2)_', 'move(1__2)')
    """
    name = _NOT_IN_EVENTS.sub("_", label) or "_"
    if name == "ε":
        name = "ε_"
    while taken.setdefault(name, label) != label:
        name += "_"
    return name


_NOT_IN_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


def quoted(text: str) -> str:
    """Return ``text`` as the value of an attribute, in quotes; InputError for a character that XML has no way to write.

    >>> print(quoted('a "b" <c>'))
    'a "b" &lt;c&gt;'
    """
    if match := _NOT_IN_XML.search(text):
        raise InputError(f"the name {text!r} has a character {match[0]!r}, which XML cannot hold; give it another name")
    return quoteattr(text, {"\x85": "&#133;", "\u2028": "&#8232;"})


def check_names(names: Iterable[str]) -> None:
    r"""Raise InputError for the first name that has a character that XML has no way to write.

    >>> check_names(["a", "bell \x07"])
    Traceback (most recent call last):
    thenar.errors.InputError: the name 'bell \x07' has a character '\x07', which XML cannot hold; give it another name
    """
    listed = list(names)
    if _NOT_IN_XML.search("".join(listed)):
        for name in listed:
            quoted(name)


def titles(automata: Sequence[Automaton | ExtendedAutomaton]) -> list[str]:
    """Return the names of ``automata``, and names for those that have none.

    >>> from thenar.model.events import Alphabet
    >>> titles([Automaton.empty(Alphabet(["a"]), "A"), Automaton.empty(Alphabet(["a"]))])
    ['A', 'automaton_2']
    """
    taken = {a.name for a in automata}
    result = []
    for k, a in enumerate(automata, 1):
        title = a.name or f"automaton_{k}"
        while not a.name and title in taken:
            title += "_"
        taken.add(title)
        result.append(title)
    return result
