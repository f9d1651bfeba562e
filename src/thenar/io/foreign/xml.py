"""XML, read into elements that know their place in the file; no entities, no document types, nothing fetched."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from typing import TYPE_CHECKING, NoReturn
from xml.sax import SAXParseException
from xml.sax.handler import ContentHandler

from defusedxml.common import DefusedXmlException
from defusedxml.expatreader import DefusedExpatParser

from thenar.errors import Mistake, ModelError, did_you_mean

if TYPE_CHECKING:
    from xml.sax.xmlreader import AttributesImpl, Locator

__all__ = ["Element", "fail", "parse"]

MAX_DEPTH = 500  # elements within elements


@dataclass(slots=True)
class Element:
    """An XML element: its tag and attributes (namespace prefixes left away), what stands in it, and where it does."""

    tag: str
    attributes: Mapping[str, str]
    line: int
    column: int
    source: str
    children: list[Element] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The text directly in the element, without white space around it."""
        return "".join(self.texts).strip()

    @property
    def where(self) -> str:
        """The place, as messages print it."""
        return f"{self.source}:{self.line}:{self.column}"

    def all(self, *tags: str) -> Iterator[Element]:
        """Yield the children with one of ``tags``."""
        return (child for child in self.children if child.tag in tags)

    def first(self, tag: str) -> Element | None:
        """Return the first child called ``tag``, or None."""
        return next(self.all(tag), None)

    def get(self, attribute: str) -> str:
        """Return the value of ``attribute``; ModelError with the place if it is not given."""
        value = self.attributes.get(attribute)
        if value is None:
            near = did_you_mean(attribute, self.attributes)
            fail(self, f"<{self.tag}> has no attribute {attribute!r}{near}")
        return value


def fail(element: Element, what: str) -> NoReturn:
    """Raise ModelError: ``what`` is wrong where ``element`` stands."""
    raise ModelError([Mistake(element.where, what)])


def parse(data: bytes, source: str) -> Element:
    """Return the root of the XML document ``data``; ``source`` is what messages call it.

    Raises ModelError with line and column for what is no XML, for a document type with entities, and for elements
    nested deeper than :data:`MAX_DEPTH`.

    >>> root = parse(b'<model version="2.1"><id>G</id></model>', "g.xmd")
    >>> root.tag, root.get("version"), root.children[0].text
    ('model', '2.1', 'G')
    >>> parse(b"<model>", "g.xmd")
    Traceback (most recent call last):
    thenar.errors.ModelError: g.xmd:1:8: no element found
    """
    reader = _Reader(source)
    # a document type may be named, as libFAUDES does, and is not fetched: external entities are off by default
    parser = DefusedExpatParser(forbid_dtd=False, forbid_entities=True, forbid_external=False)
    parser.setContentHandler(reader)
    try:
        parser.parse(BytesIO(data))
    except SAXParseException as error:
        line, column = error.getLineNumber() or 1, (error.getColumnNumber() or 0) + 1
        raise ModelError([Mistake(f"{source}:{line}:{column}", str(error.getMessage()))]) from None
    except DefusedXmlException as error:
        what = f"declares an entity ({type(error).__name__}); write the text itself"
        raise ModelError([Mistake(f"{source}:{reader.line}:{reader.column}", what)]) from None
    except (LookupError, UnicodeError, ValueError) as error:  # an encoding that Python does not have, or cannot decode
        raise ModelError([Mistake(source, f"cannot be decoded: {error}; save it as UTF-8")]) from None
    assert reader.root is not None
    return reader.root


class _Reader(ContentHandler):
    """Builds the elements."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.source = source
        self.root: Element | None = None
        self.open: list[Element] = []
        self.place: Locator | None = None

    @property
    def line(self) -> int:
        return (self.place and self.place.getLineNumber()) or 1

    @property
    def column(self) -> int:
        return ((self.place and self.place.getColumnNumber()) or 0) + 1

    def setDocumentLocator(self, locator: Locator) -> None:  # noqa: N802, the interface's name
        """Remember who knows the place."""
        self.place = locator

    def startElement(self, name: str, attrs: AttributesImpl) -> None:  # noqa: N802
        """Open an element."""
        given = {key.rpartition(":")[2]: value for key, value in attrs.items()}
        element = Element(name.rpartition(":")[2], given, self.line, self.column, self.source)
        if len(self.open) >= MAX_DEPTH:
            fail(element, f"more than {MAX_DEPTH} elements within one another")
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def endElement(self, name: str) -> None:  # noqa: N802
        """Close it."""
        self.open.pop()

    def characters(self, content: str) -> None:
        """Keep the text."""
        self.open[-1].texts.append(content)
