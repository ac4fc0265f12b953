"""Group effects: opacity, clips, masks, filters and blending, as wraps around runs of elements.

`Effects.wrap` makes the wrap of one element or group. `settle` runs when everything is placed: it
drops viewport clips that cut nothing, turns the opacity of a lone element into its own, and names
each wrap by its content, so that equal effects have equal names and still do not run together.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from ipmlang.formats.drawing import Effect, Outline, Style
from ipmlang.formats.svg.carry import Carrier
from ipmlang.formats.svg.cascade import Computed
from ipmlang.formats.svg.clipping import needless_clips
from ipmlang.formats.svg.context import Placed, Source, Wrap
from ipmlang.formats.svg.properties import INITIAL
from ipmlang.formats.svg.style import opacity
from ipmlang.formats.svg.transforms import IDENTITY, Box, Matrix
from ipmlang.formats.svg.units import number, shown

_REFERRING = ("clip-path", "mask", "filter")
_SPACELESS = frozenset({"opacity", "style"})
_COMMUTING = frozenset({"opacity", "clip-path", "mask"})


class Effects:
    """Makes the wraps of one source."""

    def __init__(self, source: Source, carrier: Carrier) -> None:
        self._source = source
        self._carrier = carrier
        self._blends = source.blends

    def wrap(self, style: Computed, matrix: Matrix, alone: bool) -> Wrap | None:
        """The wrap that an element's own properties ask for; None if they ask for none.

        `alone`: a single shape, whose opacity and blending stay its own unless it is clipped,
        masked or filtered as well.
        """
        own = style.own
        if not own:
            return None
        attributes: list[tuple[str, str]] = []
        definitions: dict[str, str] = {}
        for name in _REFERRING:
            value = own.get(name, "none")
            carried = self._carrier.value(value) if value != "none" else None
            if carried is not None:
                attributes.append((name, carried.xml))
                definitions.update(carried.definitions)
                self._source.notes.add(name, f"{name} is carried through as it is")
        if alone and not attributes:
            return None
        share = opacity(own.get("opacity", "1"))
        if share < 1.0:
            attributes.append(("opacity", shown(share)))
        css = [
            f"{name}:{own[name]}"
            for name in ("isolation", "mix-blend-mode")
            if self._blends and own.get(name, INITIAL[name]) != INITIAL[name]
        ]
        if css:
            attributes.append(("style", ";".join(css)))
        if not attributes:
            return None
        # The same clip twice in a row is one clip, unless it is fitted to the box of what it clips.
        fitted = any("objectBoundingBox" in each for each in definitions.values())
        mergeable = not fitted and all(name == "clip-path" for name, _ in attributes)
        if _SPACELESS.issuperset(name for name, _ in attributes):
            matrix = IDENTITY  # So that equal effects in different places have one name.
        text = "".join(definitions.values())
        return Wrap(Effect(tuple(attributes), text, matrix), mergeable)


def viewport_wrap(box: Box, matrix: Matrix) -> Wrap:
    """The clip of a viewport that hides what sticks out; `settle` drops it where nothing does."""
    x, y, width, height = map(shown, box)
    body = f'<rect x="{x}" y="{y}" width="{width}" height="{height}"/>'
    name = "clip-" + hashlib.sha256(body.encode()).hexdigest()[:10]
    xml = f'<clipPath id="{name}">{body}</clipPath>'
    return Wrap(Effect((("clip-path", f"url(#{name})"),), xml, matrix), True, box)


def settle(
    placed: Sequence[Placed], outlines: Sequence[Outline | None]
) -> tuple[list[Style], dict[str, Effect]]:
    """The style of each element with its effects named, and the effects by name."""
    if not any(one.wraps for one in placed):
        return [one.style for one in placed], {}
    idle = needless_clips(placed, outlines)
    uses = Counter(wrap for one in placed for wrap in one.wraps)
    effects: dict[str, Effect] = {}
    stems: dict[Wrap, str] = {}
    chains: list[list[Wrap]] = []
    styles: list[Style] = []
    for index, one in enumerate(placed):
        chain = [wrap for wrap in one.wraps if (wrap, index) not in idle]
        style = one.style
        if one.outline is not None:
            chain, style = _fold_opacity(chain, style, uses)
        chains.append(chain)
        styles.append(style)
    names = _named(chains, stems)
    known: dict[tuple[Style, tuple[str, ...]], Style] = {}
    for index, (chain, style) in enumerate(zip(chains, styles, strict=True)):
        keys = tuple(names[wrap] for wrap in chain)
        if not keys:
            continue
        for key, wrap in zip(keys, chain, strict=True):
            effects.setdefault(key, wrap.effect)
        if (style, keys) not in known:
            known[style, keys] = replace(style, effects=keys)
        styles[index] = known[style, keys]
    return styles, effects


def _fold_opacity(
    chain: list[Wrap], style: Style, uses: Mapping[Wrap, int]
) -> tuple[list[Wrap], Style]:
    """Opacity of groups that hold this element alone, made the element's own."""
    kept: list[Wrap] = []
    share = 1.0
    free = not any(name == "mix-blend-mode" for name, _ in style.more)
    for wrap in reversed(chain):
        names = [name for name, _ in wrap.effect.attributes]
        if free and names == ["opacity"] and uses[wrap] == 1:
            share *= number(wrap.effect.attributes[0][1]) or 0.0
            continue
        free = free and _COMMUTING.issuperset(names)
        kept.append(wrap)
    if share == 1.0:
        return chain, style
    more = dict(style.more)
    more["opacity"] = shown(share * opacity(more.get("opacity", "1")))
    return kept[::-1], replace(style, more=tuple(sorted(more.items())))


def _named(chains: Iterable[list[Wrap]], stems: dict[Wrap, str]) -> dict[Wrap, str]:
    """A name for each wrap: from its content, and another one where its neighbour has that name
    and the two may not become one group.
    """
    names: dict[Wrap, str] = {}
    before: list[Wrap] = []
    for chain in chains:
        for depth, wrap in enumerate(chain):
            if wrap in names:
                continue
            stem = stems.setdefault(wrap, _stem(wrap.effect))
            names[wrap] = stem
            neighbour = before[depth] if depth < len(before) else None
            if not wrap.mergeable and neighbour is not None and names[neighbour] == stem:
                names[wrap] = stem + "-b"
        before = chain
    return names


def _stem(effect: Effect) -> str:
    text = repr((effect.attributes, effect.definitions, effect.matrix))
    return "effect-" + hashlib.sha256(text.encode()).hexdigest()[:10]
