"""The hook through which the render floor shows models in a notebook; the model floor draws nothing."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Displayable", "set_html_formatter"]

_format: Callable[[object], str] | None = None


def set_html_formatter(formatter: Callable[[object], str]) -> None:
    """Let ``formatter`` turn every Displayable into HTML."""
    global _format  # noqa: PLW0603  one formatter a process, set once on import
    _format = formatter


class Displayable:
    """Something that a notebook shows as a picture."""

    __slots__ = ()

    def _repr_html_(self) -> str | None:
        return None if _format is None else _format(self)
