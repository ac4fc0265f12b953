"""Which elements a viewer would draw: `switch` and the conditional attributes.

The reader's language is English; extensions are unknown, features are taken as there.
"""

from __future__ import annotations

from ipmlang.formats.svg.xml import Node

_LANGUAGE = "en"
CONDITIONS = ("systemLanguage", "requiredExtensions", "requiredFeatures")


def holds(node: Node) -> bool:
    """Whether the element's conditional attributes are all true."""
    languages = node.attributes.get("systemLanguage")
    if languages is not None and not any(map(_is_ours, languages.split(","))):
        return False
    extensions = node.attributes.get("requiredExtensions")
    if extensions is not None and extensions.strip():
        return False
    features = node.attributes.get("requiredFeatures")
    return features is None or bool(features.strip())


def _is_ours(language: str) -> bool:
    return language.strip().lower().partition("-")[0] == _LANGUAGE


def chosen(node: Node) -> list[Node]:
    """The child of a `switch` that is drawn: the first whose conditions hold, if there is one."""
    return next(([child] for child in node.children if child.name and holds(child)), [])
