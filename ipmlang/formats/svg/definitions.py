"""The `<defs>` of a written SVG: paint servers and what group effects refer to, each once.

Takes paint servers, fragments and effects as self-contained XML; gives ids, references and XML
whose inner ids clash with nothing else in the file. Never looks at outlines.
"""

from __future__ import annotations

import re
from html import escape

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Effect, Fragment, PaintServer
from ipmlang.formats.numbers import decimal_text, joined, without_zero
from ipmlang.formats.svg.transforms import IDENTITY, Matrix

_SVG = "http://www.w3.org/2000/svg"
_XLINK = "http://www.w3.org/1999/xlink"
_TAG = re.compile(r"<([A-Za-z][\w.:-]*)")
_ATTRIBUTE = re.compile(r'\s([\w:-]+)="([^"]*)"')
_STOPS = re.compile(r'(stop-color=")#([0-9a-f])\2([0-9a-f])\3([0-9a-f])\4(?=")')
_REFERENCE = re.compile(r"url\(\s*(['\"]?)#([^)'\"]+)\1\s*\)")


class Definitions:
    """Collects the definitions of one file; the order of first use is the order of writing."""

    def __init__(self, short: bool = False) -> None:
        """short: definitions refer to earlier ones for what they have in common with them."""
        self.short = short
        self._bodies: dict[tuple[str, str], tuple[str, dict[str, str]]] = {}
        self._written: list[str] = []
        self._ids: set[str] = set()
        self._paints: dict[tuple[str, Matrix], str] = {}
        self._effects: dict[Effect, str] = {}
        self._names: dict[str, dict[str, str]] = {}

    def text(self) -> str:
        """The `<defs>` element, empty if nothing needs one."""
        return "<defs>\n" + "\n".join(self._written) + "\n</defs>\n" if self._written else ""

    def paint(self, server: PaintServer, matrix: Matrix) -> str:
        """The `url(#…)` of a gradient or pattern whose space `matrix` maps to the user's."""
        key = (server.xml, matrix)
        if key not in self._paints:
            name = self._new_id("p" if self.short else "paint")
            self._paints[key] = name
            if self.short:
                self._written.append(self._short_paint(name, server, matrix))
                return f"url(#{name})"
            attribute = "patternTransform" if server.kind == "pattern" else "gradientTransform"
            transform = "" if matrix == IDENTITY else f' {attribute}="{matrix_text(matrix)}"'
            xml = self.adopted(server.xml)
            self._written.append(_TAG.sub(rf'<\1 id="{name}"{transform}', xml, count=1))
        return f"url(#{self._paints[key]})"

    def _short_paint(self, name: str, server: PaintServer, matrix: Matrix) -> str:
        """A paint server that says only how it differs from an earlier one of the same content."""
        attribute = "patternTransform" if server.kind == "pattern" else "gradientTransform"
        opening, _, body = server.xml.partition(">")
        stated = dict(_ATTRIBUTE.findall(opening))
        moved = transform_text(matrix)
        if moved:
            stated[attribute] = moved
        earlier, known = self._bodies.setdefault((server.kind, body), (name, stated))
        # What stands in other quotes holds quotes, and is written as it is.
        if "'" in opening:
            whole = f'{opening} {attribute}="{moved or "scale(1)"}">{body}'
            return _TAG.sub(rf'<\1 id="{name}"', self.adopted(whole), count=1)
        if earlier != name and "overflow" not in stated:
            stated.setdefault(attribute, "scale(1)")
            if known.keys() <= stated.keys():
                own = {key: value for key, value in stated.items() if known.get(key) != value}
                if not moved and attribute not in known:
                    del own[attribute]
                said = "".join(f' {key}="{value}"' for key, value in own.items())
                return f'<{server.kind} id="{name}" href="#{earlier}"{said}/>'
            if not moved:
                del stated[attribute]
        said = "".join(f' {key}="{value}"' for key, value in stated.items())
        whole = f"<{server.kind}{said}>{_STOPS.sub(_short_stop, body)}"
        return _TAG.sub(rf'<\1 id="{name}"', self.adopted(whole), count=1)

    def group(self, effect: Effect) -> str:
        """The attributes of the group that makes an effect, its definitions taken in."""
        if effect not in self._effects:
            names = self._names.setdefault(effect.definitions, {})
            if effect.definitions.strip() and not names:
                self._written.append(self.adopted(effect.definitions, names))
            self._effects[effect] = "".join(
                f' {name}="{escape(_renamed(value, names))}"' for name, value in effect.attributes
            )
        return self._effects[effect]

    def fragment(self, fragment: Fragment) -> str:
        """A carried element in its place."""
        xml = self.adopted(fragment.xml)
        if fragment.matrix == IDENTITY:
            return xml
        return f'<g transform="{matrix_text(fragment.matrix)}">{xml}</g>'

    def _new_id(self, stem: str) -> str:
        number = len(self._ids) + 1
        while f"{stem}{number}" in self._ids:
            number += 1
        self._ids.add(f"{stem}{number}")
        return f"{stem}{number}"

    def adopted(self, xml: str, names: dict[str, str] | None = None) -> str:
        """The XML with its ids made unique in this file; `names` takes what was renamed."""
        if not re.search(r"\bid\s*=", xml):
            return without_namespace(xml)
        from lxml import etree

        parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
        wrapped = f'<svg xmlns="{_SVG}" xmlns:xlink="{_XLINK}">{xml}</svg>'
        try:
            root = etree.fromstring(wrapped.encode("utf-8"), parser)
        except etree.XMLSyntaxError as error:
            raise FormatError(f"a carried piece of XML is not well formed: {error}") from error
        names = {} if names is None else names
        for element in root.iter("*"):
            name = element.get("id")
            if name is not None:
                names[name] = name if name not in self._ids else self._new_id(f"{name}-")
                self._ids.add(names[name])
                element.set("id", names[name])
        for element in root.iter("*"):
            for attribute, value in element.items():
                if "#" in str(value):
                    element.set(attribute, _renamed(str(value), names))
        inner = (etree.tostring(child, encoding="unicode") for child in root)
        return "".join(without_namespace(text) for text in inner)


def transform_text(matrix: Matrix) -> str:
    """A map as the shortest transform, empty for none.

    >>> transform_text((0.5, 0, 0, 0.5, 0, 0)), transform_text((1, 0, 0, 1, 3, -0.25))
    ('scale(.5)', 'translate(3-.25)')
    """
    a, b, c, d, e, f = (without_zero(decimal_text(value)) for value in matrix)
    if matrix == IDENTITY:
        return ""
    if (b, c, e, f) == ("0", "0", "0", "0"):
        return f"scale({a})" if a == d else f"scale({_joined(a, d)})"
    if (a, b, c, d) == ("1", "0", "0", "1"):
        return f"translate({e})" if f == "0" else f"translate({_joined(e, f)})"
    return f"matrix({_joined(a, b, c, d, e, f)})"


def _joined(*words: str) -> str:
    """Numbers with a blank between them where the sign does not part them."""
    return "".join(words[:1]) + "".join(w if w[0] == "-" else " " + w for w in words[1:])


def matrix_text(matrix: Matrix) -> str:
    """`matrix(a b c d e f)` with 15 significant digits."""
    return f"matrix({joined(matrix)})"


def _renamed(value: str, names: dict[str, str]) -> str:
    if value.startswith("#"):
        return "#" + names.get(value[1:], value[1:])
    return _REFERENCE.sub(lambda match: f"url(#{names.get(match[2], match[2])})", value)


def without_namespace(xml: str) -> str:
    """Drop what the root declares anyway, but only from the first tag: within foreign content the
    same declaration means something else.
    """
    end = xml.find(">") + 1
    head = xml[:end].replace(f' xmlns="{_SVG}"', "").replace(f' xmlns:xlink="{_XLINK}"', "")
    return head + xml[end:]


def _short_stop(match: re.Match[str]) -> str:
    return f"{match[1]}#{match[2]}{match[3]}{match[4]}"
