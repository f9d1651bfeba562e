"""What a notebook shows for a model: a picture while it is small, tables and components when it is large."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import singledispatch
from html import escape

from thenar.model.automaton import Automaton
from thenar.model.names import Composed
from thenar.model.problem import Problem
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Check, Trace
from thenar.render.layout import layered
from thenar.render.measure import printable
from thenar.render.scene import LIMIT, scene
from thenar.render.svg import AMBER, GREEN, RED, draw
from thenar.render.text import arrows, event_names, state_rows
from thenar.synthesis.api import SynthesisResult
from thenar.synthesis.explain import Explanation

__all__ = ["html"]

TABLE_ROWS = 12  # states of a large automaton that are listed
PICTURES = 12  # components of a problem that are drawn
EVENTS = 100  # of a witness that are shown

_ASIDE = 'style="opacity:0.7;font-size:90%"'


@singledispatch
def html(obj: object, *, highlight: Iterable[int] = (), path: Trace | str | None = None) -> str:
    """Return HTML that shows ``obj`` in a page: no script, nothing to load, every name escaped.

    An automaton or supervisor of up to 30 states is drawn with ``highlight`` (its current states) and
    ``path`` lit; a larger one is shown as the beginning of its table, and a product also by the states that
    its components are in when it is in the first highlighted, or the initial, state.  The automata of a
    problem are drawn side by side; ``highlight`` then holds the current state of each, in order.  A check is
    shown with its witness.  Anything else is shown by its repr; other floors may ``html.register`` more.

    >>> html(Check("nonblocking", True))
    '<div class="thenar"><b style="color:#23863b">✓</b> nonblocking</div>'
    >>> html({"<b>"})
    '<div class="thenar"><pre>{&#x27;&lt;b&gt;&#x27;}</pre></div>'
    """
    return _page(f"<pre>{_text(repr(obj))}</pre>")


@html.register
def _(obj: Automaton, *, highlight: Iterable[int] = (), path: Trace | str | None = None) -> str:
    lit = tuple(highlight)
    if obj.n_states <= LIMIT:
        return _page(_title(repr(obj)), _picture(obj, lit, path))
    rows = state_rows(obj, TABLE_ROWS, lambda q: ("●" if obj.marked[q] else "", arrows(obj, q, "→")))
    listed = _table(("", "state", "marked", "transitions"), rows, obj.n_states)
    return _page(_title(repr(obj)), _components(obj, lit), listed)


@html.register
def _(obj: Supervisor, *, highlight: Iterable[int] = (), path: Trace | str | None = None) -> str:
    lit = tuple(highlight)
    if obj.n_states <= LIMIT:
        return _page(_title(repr(obj)), _picture(obj, lit, path))

    def patterns(q: int) -> tuple[str, str]:
        pattern = obj.pattern(q)
        return event_names(pattern.enabled), event_names(pattern.disabled)

    rows = state_rows(obj.automaton, TABLE_ROWS, patterns)
    listed = _table(("", "state", "enabled", "disabled"), rows, obj.n_states)
    return _page(_title(repr(obj)), _components(obj.automaton, lit), listed)


@html.register
def _(obj: Problem, *, highlight: Iterable[int] = (), path: Trace | str | None = None) -> str:
    current = list(highlight)
    figures = []
    for k, a in enumerate(obj.automata):
        role = "plant" if k < len(obj.plants) else "specification"
        drawn = a.n_states <= LIMIT and k < PICTURES
        shown = _picture(a, current[k : k + 1], None) if drawn else f"<p>{_text(repr(a))}</p>"
        caption = f"<figcaption>{_text(a.name)} <span {_ASIDE}>{role}</span></figcaption>"
        figures.append(f'<figure style="margin:0;max-width:100%">{caption}{shown}</figure>')
    about = f"<p {_ASIDE}>{_text(obj.description)}</p>" if obj.description else ""
    return _page(_title(repr(obj)), about, _side_by_side(figures))


@html.register
def _(obj: Check, *, highlight: Iterable[int] = (), path: Trace | str | None = None) -> str:
    mark, colour = ("✓", GREEN) if obj.holds else ("✗", RED)
    verdict = f'<b style="color:{colour}">{mark}</b> {"" if obj.holds else "not "}{_text(obj.property)}'
    if obj.witness is not None:
        events = [f"<code>{_text(e)}</code>" for e in obj.witness[:EVENTS]] or ["<code>ε</code>"]
        if len(obj.witness) > EVENTS:
            events.append(f"… {len(obj.witness) - EVENTS:,} more")
        verdict += f" after {' → '.join(events)}"
    if obj.reason:
        verdict += f": {_text(obj.reason)}"
    return _page(verdict)


@html.register
def _(obj: SynthesisResult, *, highlight: Iterable[int] = (), path: Trace | str | None = None) -> str:
    if obj.reason is not None:
        return html(obj.reason)
    return html(obj.supervisor, highlight=highlight, path=path)


@html.register
def _(obj: Explanation, *, highlight: Iterable[int] = (), path: Trace | str | None = None) -> str:
    return _page(f"<p>{_text(str(obj))}</p>")


def _picture(obj: Automaton | Supervisor, lit: Sequence[int], path: Trace | str | None) -> str:
    shown = scene(obj, highlight=lit, path=path)
    return f'<div style="overflow-x:auto">{draw(shown, layered(shown), paper=False)}</div>'


def _components(G: Automaton, lit: Sequence[int]) -> str:
    """Show which state each component of a product is in; nothing if ``G`` is none."""
    if not isinstance(G.states, Composed):
        return ""
    q = lit[0] if lit else G.initial
    chips = [
        f'<span style="border:1px solid;border-radius:1em;padding:0.1em 0.7em">{_text(label)}: '
        f'<span style="background:{AMBER}59">{_text(part[local])}</span></span>'
        for label, part, local in zip(G.states.labels, G.states.parts, G.states.coordinates(q), strict=True)
    ]
    return f"<p {_ASIDE}>state {q:,} of the product</p>{_side_by_side(chips)}"


def _side_by_side(parts: Sequence[str]) -> str:
    style = "display:flex;flex-wrap:wrap;gap:0.5em 2em;align-items:flex-start;margin-bottom:0.5em"
    return f'<div style="{style}">{"".join(parts)}</div>'


def _table(header: Sequence[str], rows: Sequence[Sequence[str]], total: int) -> str:
    lines = ["<tr>" + "".join(f"<th>{_text(cell)}</th>" for cell in header) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{_text(cell)}</td>" for cell in row) + "</tr>" for row in rows]
    more = f"<p {_ASIDE}>… {total - len(rows):,} more</p>" if total > len(rows) else ""
    return (
        f'<table style="text-align:left;border-collapse:separate;border-spacing:1em 0">{"".join(lines)}</table>{more}'
    )


def _title(text: str) -> str:
    return f"<p><b>{_text(text)}</b></p>"


def _page(*parts: str) -> str:
    return f'<div class="thenar">{"".join(parts)}</div>'


def _text(text: str) -> str:
    return escape(printable(text))
