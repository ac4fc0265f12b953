"""Style sheets in, the declarations that match each node out; `style` attributes are read too.

Media: what is for `all` or `screen` counts, `print` and the rest do not. Nothing is ever imported
or fetched. Matching runs once per node under a budget, so that no selector can take for ever.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, SupportsIndex, TypeAlias

from ipmlang.formats import FormatError
from ipmlang.formats.svg.limits import Limits, Notes
from ipmlang.formats.svg.properties import STYLED
from ipmlang.formats.svg.xml import Document, Node

if TYPE_CHECKING:
    from cssselect2.compiler import CompiledSelector
    from tinycss2.ast import Node as Token

Declaration: TypeAlias = tuple[str, str, bool]
"""Property, value, whether it is !important."""

_PLAIN = re.compile(r"[\w\s:;.,#%+-]*+", re.ASCII)
_TRUE_FEATURES = frozenset({"prefers-color-scheme:light", "prefers-reduced-motion:no-preference"})
_MAX_NESTING = 16
_TOO_DEEP = (RecursionError, SyntaxError, MemoryError)
"""What nesting does to parsers that recurse, and to Python's own where selectors become code."""


@lru_cache(maxsize=8192)
def parse_declarations(text: str) -> tuple[Declaration, ...]:
    """The declarations of a `style` attribute, in order, unknown ones left out."""
    if _PLAIN.fullmatch(text):
        return tuple(_plain_declarations(text))
    import tinycss2

    try:
        return tuple(_declarations(tinycss2.parse_declaration_list(text, True, True)))
    except _TOO_DEEP:
        return ()


def _plain_declarations(text: str) -> Iterator[Declaration]:
    for part in text.split(";"):
        name, colon, value = part.partition(":")
        name = name.strip().lower()
        if colon and value.strip() and (name in STYLED or name.startswith("--")):
            yield name, value.strip(), False


def _declarations(tokens: Iterable[Token]) -> Iterator[Declaration]:
    import tinycss2

    for token in tokens:
        if token.type != "declaration":
            continue
        name = token.name if token.name.startswith("--") else token.lower_name
        if name in STYLED or name.startswith("--"):
            yield name, tinycss2.serialize(token.value).strip(), bool(token.important)


def match_sheets(
    document: Document, limits: Limits, notes: Notes
) -> Mapping[Node, tuple[Declaration, ...]]:
    """What style sheets declare for each node, weakest first (by specificity, then order)."""
    sheets = [
        node
        for node in document.nodes
        if node.name == "style"
        and (node.get("type") or "text/css").strip().lower() == "text/css"
        and _media_applies(node.get("media") or "")
    ]
    if not sheets:
        return {}
    rules: list[tuple[CompiledSelector, tuple[Declaration, ...]]] = []
    for sheet in sheets:
        text = sheet.text + "".join(child.tail for child in sheet.children)
        try:
            rules.extend(_sheet_rules(text, notes, sheet.line))
        except _TOO_DEEP:
            notes.add(
                "style-sheet", "a style sheet is nested too deep and was left out", sheet.line
            )
    return _match(document, rules, limits) if rules else {}


def _sheet_rules(
    text: str, notes: Notes, line: int | None
) -> Iterator[tuple[CompiledSelector, tuple[Declaration, ...]]]:
    """Compiled selectors with their declarations, blocks of matching media opened up."""
    import cssselect2
    import tinycss2

    namespaces: dict[str | None, str] = {}
    pending: list[tuple[Token, int]] = [
        (rule, 0) for rule in reversed(tinycss2.parse_stylesheet(text, True, True))
    ]
    while pending:
        rule, nesting = pending.pop()
        if rule.type == "at-rule":
            inner = _opened(rule, namespaces, notes, line) if nesting < _MAX_NESTING else ()
            pending.extend((token, nesting + 1) for token in reversed(inner))
            continue
        if rule.type != "qualified-rule":
            notes.add("style-sheet", "a part of a style sheet cannot be read", line)
            continue
        try:
            selectors = cssselect2.compile_selector_list(rule.prelude, namespaces)
        except (cssselect2.SelectorError, *_TOO_DEEP):
            notes.add("selector", "a selector is not understood", line)
            continue
        tokens = tinycss2.parse_declaration_list(rule.content, True, True)
        declarations = tuple(_declarations(tokens))
        yield from ((one, declarations) for one in selectors if one.pseudo_element is None)


def _opened(
    rule: Token, namespaces: dict[str | None, str], notes: Notes, line: int | None
) -> Sequence[Token]:
    """The rules inside an at-rule that applies; declared namespaces are remembered."""
    import tinycss2

    keyword = rule.lower_at_keyword
    if keyword == "media" and rule.content is not None:
        if _media_applies(tinycss2.serialize(rule.prelude)):
            inner: Sequence[Token] = tinycss2.parse_rule_list(rule.content, True, True)
            return inner
    elif keyword == "namespace":
        words = [token for token in rule.prelude if token.type != "whitespace"]
        if words and words[-1].type in ("string", "url"):
            prefix = words[0].value if len(words) == 2 else None
            namespaces[prefix] = words[-1].value
    elif keyword != "charset":
        notes.add("at-rule", f"@{keyword} in a style sheet is left out", line)
    return ()


def _media_applies(text: str) -> bool:
    """Whether a list of media queries is true for a light colour screen of unknown size.

    >>> [_media_applies(text) for text in ("", "print", "screen, print", "not print")]
    [True, False, True, True]
    """
    return not text.strip() or any(_query_applies(query) for query in text.lower().split(","))


def _query_applies(query: str) -> bool:
    words = [word.strip() for word in re.split(r"\band\b", query)]
    first = words[0].split()
    negated = bool(first) and first[0] == "not"
    if first and first[0] in ("not", "only"):
        words[0] = " ".join(first[1:])
    return negated != all(_medium_applies(word) for word in words)


def _medium_applies(word: str) -> bool:
    if word.startswith("("):
        return "".join(word.strip("()").split()) in _TRUE_FEATURES
    return word in ("all", "screen")


def _match(
    document: Document,
    rules: Sequence[tuple[CompiledSelector, tuple[Declaration, ...]]],
    limits: Limits,
) -> Mapping[Node, tuple[Declaration, ...]]:
    import cssselect2

    matcher = cssselect2.Matcher()
    for selector, declarations in rules:
        matcher.add_selector(selector, declarations)
    budget = _Budget(limits.selector_steps)
    found: dict[Node, tuple[Declaration, ...]] = {}
    for element in _wrapped(document.root, budget.spend):
        budget.spend(1 + len(matcher.other_selectors) + _bucket(matcher, element))
        matches = matcher.match(element)
        if matches:
            node: Node = element.etree_element
            found[node] = tuple(one for match in matches for one in match[3])
    return found


def _bucket(matcher: Matcher, element: ElementWrapper) -> int:
    """How many selectors will be tried because of the element's name and classes."""
    tried = len(matcher.lower_local_name_selectors.get(element.local_name.lower(), ()))
    return tried + sum(len(matcher.class_selectors.get(name, ())) for name in element.classes)


class _Budget:
    """Work left for matching; running out is an error of the file."""

    def __init__(self, steps: int) -> None:
        self.steps = steps

    def spend(self, steps: int) -> None:
        self.steps -= steps
        if self.steps < 0:
            raise FormatError(
                "matching the style sheets takes too much work",
                hint="use fewer or simpler selectors, above all fewer `~` and ` ` between parts",
            )


class _Paid(list[Node]):
    """Siblings: looking through them is charged, knowing how many there are is free."""

    def __init__(self, nodes: Iterable[Node], spend: Callable[[int], None]) -> None:
        super().__init__(nodes)
        self._spend = spend

    def __iter__(self) -> Iterator[Node]:
        self._spend(len(self) // 8)
        return super().__iter__()

    def __getitem__(  # type: ignore[override]
        self, index: SupportsIndex | slice
    ) -> Node | list[Node]:
        self._spend(len(self) // 8)
        return super().__getitem__(index)


def _wrapped(root: Node, spend: Callable[[int], None]) -> Iterator[ElementWrapper]:
    """The nodes wrapped for matching, in document order; looking around is charged."""
    from cssselect2 import ElementWrapper

    class Charged(ElementWrapper):  # type: ignore[misc]
        """A node for matching that pays for every list of relatives it is asked for."""

        _ancestors: tuple[ElementWrapper, ...] | None

        @property
        def ancestors(self) -> tuple[ElementWrapper, ...]:
            if self._ancestors is None:
                above = self.parent
                self._ancestors = () if above is None else (*above.ancestors, above)
            spend(len(self._ancestors))
            return self._ancestors

        @property
        def previous_siblings(self) -> tuple[ElementWrapper, ...]:
            before = []
            element = self.previous
            while element is not None:
                before.append(element)
                element = element.previous
            spend(len(before))
            return tuple(reversed(before))

        @cached_property
        def etree_children(self) -> list[Node]:
            return _Paid(self.etree_element.children, spend)

    yield from Charged.from_xml_root(root).iter_subtree()


if TYPE_CHECKING:
    from cssselect2 import ElementWrapper, Matcher
