"""A scene as a Mermaid state diagram: text that many wikis and code hosts draw."""

from __future__ import annotations

from collections.abc import Iterable

from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Trace
from thenar.render.measure import printable
from thenar.render.scene import LIMIT, Label, Scene, scene

__all__ = ["mermaid"]

# what a Mermaid text may hold as it is; anything else is written as a character code
_PLAIN = frozenset("_-+*().,'/| ")


def mermaid(
    obj: Automaton | Supervisor | Scene,
    *,
    highlight: Iterable[int] = (),
    path: Trace | str | None = None,
    centre: int | None = None,
    limit: int = LIMIT,
) -> str:
    """Return a ``stateDiagram-v2``; the options choose what is shown, see :func:`scene`.

    A marked state has a thick border, an uncontrollable event a ``!``; what a supervisor disables is a note.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
    >>> print(mermaid(lamp))
    stateDiagram-v2
        state "off" as s0
        state "lit" as s1
        [*] --> s0
        s0 --> s1: on
        s1 --> s0: off
        classDef marked stroke-width:4px
        class s0 marked
    """
    picture = obj if isinstance(obj, Scene) else scene(obj, highlight=highlight, path=path, centre=centre, limit=limit)
    nodes = picture.nodes
    lines = ["stateDiagram-v2"]
    lines += [f'state "{_escaped(n.label)}" as s{k}' for k, n in enumerate(nodes) if n.kind != "disabled"]
    lines += [f"[*] --> s{k}" for k, n in enumerate(nodes) if n.initial]
    for edge in picture.edges:
        words = ", ".join(map(_event, edge.labels))
        if nodes[edge.target].kind == "disabled":
            lines.append(f"note right of s{edge.source}: disabled#58; {words}")
        else:
            lines.append(f"s{edge.source} --> s{edge.target}" + (f": {words}" if words else ""))
    for name, style, members in (
        ("marked", "stroke-width:4px", [k for k, n in enumerate(nodes) if n.marked]),
        ("highlighted", "fill:#f2a71b,color:#000", [k for k, n in enumerate(nodes) if n.highlighted or n.passed]),
    ):
        if members:
            lines += [f"classDef {name} {style}", f"class {','.join(f's{k}' for k in members)} {name}"]
    if picture.caption:
        lines.append(f"%% {picture.caption}")
    return "\n    ".join(lines)


def _event(label: Label) -> str:
    return _escaped(label.event.name) + "!" * (not label.event.controllable)


def _escaped(text: str) -> str:
    r"""Return ``text`` such that Mermaid shows it and reads nothing into it.

    >>> _escaped('"a" --> <b>; %%')
    '#34;a#34; --#62; #60;b#62;#59; #37;#37;'
    """
    return "".join(c if c.isalnum() or c in _PLAIN else f"#{ord(c)};" for c in printable(text))
