"""IDES ``.xmd``: XML, one finite-state automaton a file, of IDES 2.0 (``<automaton>``), 2.1 and 3 (``<model>``).

* A state has a ``<name>`` and the properties ``<initial/>`` and ``<marked/>``, an event ``<controllable/>`` and
  ``<observable/>``; a property that is left out does not hold.
* The automaton is called after the file, as in IDES, where the attribute ``id`` of the model plays no part.
* White space and commas in names of events become ``_``.  States of one name are told apart by their ``id``, as in
  ``idle (3)``; a state without a name is called by its ``id``.
* The annotation of a model is its meaning; all other ``<meta>`` sections (layout) are skipped.
* Refused: transitions without an event (IDES calls them ε-transitions), and what is no automaton: workspaces (.xws),
  event sets, template designs.

Source: "IDES 2.1 File Format", and the reader of IDES 3, https://github.com/krudie/IDES.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NoReturn
from xml.sax.saxutils import escape, quoteattr

from thenar.io.foreign.apart import BLOCK, Parts, apart, beside, said
from thenar.io.foreign.assemble import assembled
from thenar.io.foreign.words import Mistakes, alphabet, event_name
from thenar.io.foreign.written import Written
from thenar.io.foreign.xml import Element, fail, parse
from thenar.model.automaton import Automaton
from thenar.model.events import Event
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps", "loads"]

_OTHERS = {
    "workspace": "a workspace, a list of model files; read the .xmd files that it names",
    "SupEventSet": "a set of events; an automaton is a model of type FSA",
    "TemplateDesign": "a design with templates; let IDES make its modules and channels and read their .xmd files",
}
_LAYOUT = re.compile(rb"<meta\b(?![^<>]*\"annotation\")")


def loads(data: bytes, source: str) -> Automaton | ExtendedAutomaton:
    """Return the automaton in ``data``; ``source`` is what messages call the file, and the automaton its stem.

    O(length of the file).  Raises ModelError with all mistakes, their lines and columns.

    >>> loads(b'''<model version="2.1" type="FSA" id="1"><data>
    ...   <state id="1"><properties><initial/><marked/></properties><name>idle</name></state>
    ...   <event id="1"><properties><observable/></properties><name>break down</name></event>
    ...   <transition id="1" source="1" target="1" event="1"/></data></model>''', "M.xmd").alphabet
    Alphabet(break_down!)
    >>> loads(b'<workspace version="3"/>', "M.xws")
    Traceback (most recent call last):
    thenar.errors.ModelError: M.xws:1:1: this is a workspace, a list of model files; read the .xmd files that it names
    """
    root = parse(_without_layout(data), source)
    if root.tag == "automaton":  # IDES 2.0
        body, meaning = root, ""
    else:
        if root.tag != "model" or root.get("type") != "FSA":
            _refuse(root)
        if root.get("version").partition(".")[0] not in ("2", "3"):
            fail(root, f"this is version {root.get('version')!r}; versions 2 and 3 are read")
        sections = list(root.all("data"))
        if len(sections) != 1:
            fail(sections[1] if sections else root, f"a model has one <data>, not {len(sections)}")
        body = sections[0]
        meaning = " ".join(meta.text for meta in root.all("meta") if meta.attributes.get("tag") == "annotation")
    return _automaton(body, source, meaning)


def _without_layout(data: bytes) -> bytes:
    """Return ``data`` with line ends only in ``<meta>`` sections other than annotations; they need not be XML."""
    pieces, done = [], 0
    start = max(data.find(b"</data>"), 0)
    while opening := _LAYOUT.search(data, start):
        end = data.find(b"</meta>", opening.start())
        if end < 0:
            break
        start = end + len(b"</meta>")
        pieces += [data[done : opening.start()], b"\n" * data.count(b"\n", opening.start(), start)]
        done = start
    return b"".join([*pieces, data[done:]])


def _refuse(root: Element) -> NoReturn:
    kind = root.attributes.get("type", "") if root.tag == "model" else root.tag
    fail(root, f"this is {_OTHERS.get(kind) or f'{kind!r}, and no IDES model of type FSA'}")


def _automaton(body: Element, source: str, meaning: str) -> Automaton | ExtendedAutomaton:
    """Return the automaton whose states, events and transitions stand in ``body``."""
    mistakes = Mistakes(source)
    states = _by_id(body, "state", mistakes)
    events = _by_id(body, "event", mistakes)
    for child in body.children:
        if child.tag not in ("state", "event", "transition"):
            mistakes.add(_place(child), f"unknown element <{child.tag}>; here stand <state>, <event>, <transition>")
    held = [_properties(q, ("initial", "marked"), mistakes) for q in states.values()]
    flags = [_properties(e, ("controllable", "observable"), mistakes) for e in events.values()]
    sigma = alphabet(
        [event_name(_name(e)) for e in events.values()],
        ["controllable" in flag for flag in flags],
        ["observable" in flag for flag in flags],
        lambda k: _place(list(events.values())[k]),
        mistakes,
    )
    number = {"state": {key: k for k, key in enumerate(states)}, "event": {key: k for k, key in enumerate(events)}}
    columns: tuple[list[int], ...] = ([], [], [])
    kinds = (("source", "state"), ("event", "event"), ("target", "state"))
    for transition in body.all("transition"):
        for (attribute, kind), column in zip(kinds, columns, strict=True):
            key = transition.attributes.get(attribute, "")
            k = number[kind].get(key)
            if k is not None:
                column.append(k)
            elif key:
                mistakes.unknown(_place(transition), f"{kind} with id", key, number[kind])
            elif kind == "event":
                mistakes.add(_place(transition), "a transition without an event (ε); automata here have none")
            else:
                mistakes.add(_place(transition), f"the transition has no {attribute}")
    mistakes.check()
    return assembled(
        Path(source).stem,
        sigma,
        _state_names(states),
        [k for k, flag in enumerate(held) if "initial" in flag],
        ["marked" in flag for flag in held],
        *columns,
        meaning=meaning,
        where=source,
    )


def _by_id(body: Element, kind: str, mistakes: Mistakes) -> dict[str, Element]:
    """Return the elements of this kind by their ids."""
    found: dict[str, Element] = {}
    for element in body.all(kind):
        key = element.get("id")
        if key in found:
            mistakes.add(_place(element), f"two {kind}s have the id {key!r}")
        found[key] = element
    return found


def _properties(element: Element, known: Sequence[str], mistakes: Mistakes) -> set[str]:
    held = {p.tag: p for properties in element.all("properties") for p in properties.children}
    for tag, p in held.items():
        if tag not in known:
            mistakes.add(_place(p), f"unknown property <{tag}/> of a {element.tag}; known are {' and '.join(known)}")
    return set(held)


def _name(element: Element) -> str:
    name = element.first("name")
    return name.text if name else ""


def _state_names(states: dict[str, Element]) -> list[str]:
    """Return the names of the states, each different."""
    names = {key: _name(element) or key for key, element in states.items()}
    often = {name for name, times in Counter(names.values()).items() if times > 1}
    return [f"{name} ({key})" if name in often else name for key, name in names.items()]


def _place(element: Element) -> str:
    return f"{element.line}:{element.column}"


def dumps(automaton: Automaton | ExtendedAutomaton) -> Written:
    """Return ``automaton`` as a model of IDES 2.1, which IDES 3 reads and writes, without layout.

    Said is everything but the automaton's name, which is that of the file, and forcible events, meanings of events, and
    names that XML cannot say; these are kept in :attr:`Written.names`.

    Raises InputError for guards and updates.

    >>> lamp = Automaton.from_transitions(["off -on-> lit"], initial="off", marked=["off"], name="LAMP")
    >>> text = "".join(dumps(lamp).chunks)
    >>> print("\\n".join(text.splitlines()[:3]))
    <?xml version="1.0" encoding="UTF-8"?>
    <model version="2.1" type="FSA" id="LAMP">
    <data>
    >>> loads(text.encode(), "LAMP.xmd").states
    Listed(names=('off', 'lit'))
    """
    parts = apart(automaton, ".xmd")
    states = said(parts.states, _sayable, "s")
    events = said(parts.alphabet.names, _sayable, "e")
    read = [Event(f, e.controllable, e.observable) for f, e in zip(events, parts.alphabet, strict=True)]
    unsaid = parts.meaning != "" and not _sayable(parts.meaning)
    return Written(_text(parts, states, read), beside(parts, read, states, unsaid=unsaid))


def _sayable(name: str) -> bool:
    return name.isprintable() and name.strip() == name != ""


def _text(parts: Parts, states: Sequence[str], events: Sequence[Event]) -> Iterator[str]:
    """Yield the elements of the file, some hundred at a time."""
    title = quoteattr(parts.name if parts.name.isprintable() else "", {"'": "&apos;"})
    yield f'<?xml version="1.0" encoding="UTF-8"?>\n<model version="2.1" type="FSA" id={title}>\n<data>\n'
    first = set(parts.initial)
    for start in range(0, len(states), BLOCK):
        marked = parts.marked[start : start + BLOCK].tolist()
        yield "".join(
            _element("state", k, name, ("initial",) * (k in first) + ("marked",) * m)
            for k, (name, m) in enumerate(zip(states[start : start + BLOCK], marked, strict=True), start)
        )
    yield "".join(
        _element("event", k, e.name, ("controllable",) * e.controllable + ("observable",) * e.observable)
        for k, e in enumerate(events)
    )
    for start in range(0, len(parts.sources), BLOCK):
        columns = (c[start : start + BLOCK].tolist() for c in (parts.sources, parts.targets, parts.events))
        yield "".join(
            f'\t<transition id="{k}" source="{s}" target="{t}" event="{e}">\n\t</transition>\n'
            for k, (s, t, e) in enumerate(zip(*columns, strict=True), start)
        )
    yield "</data>\n"
    if _sayable(parts.meaning):
        yield f'<meta tag="annotation" version="3">{escape(parts.meaning)}</meta>\n'
    yield "</model>\n"


def _element(tag: str, k: int, name: str, properties: Sequence[str]) -> str:
    """Return a state or an event as IDES writes it."""
    inner = "".join(f"\t\t\t<{p} />\n" for p in properties)
    inner = f"\t\t<properties>\n{inner}\t\t</properties>\n" if inner else "\t\t<properties/>\n"
    return f'\t<{tag} id="{k}">\n{inner}\t\t<name>{escape(name)}</name>\n\t</{tag}>\n'
