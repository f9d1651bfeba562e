"""Models as pictures, tables and pages: model -> Scene -> svg | text | mermaid | notebook."""

from thenar.render.mermaid import mermaid
from thenar.render.notebook import html
from thenar.render.scene import scene
from thenar.render.svg import svg
from thenar.render.text import table

__all__ = ["html", "mermaid", "scene", "svg", "table"]
