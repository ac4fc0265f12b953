"""Which shapes are worth drawing as one: scaled copies, in rows that grow and in scaled groups, and
what stands in other materials where all else is the same.

Takes parts; tells where a search may find more than without that. A look at pairs
of neighbours and at rows, much quicker than a search. Nothing is decided for good here.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import Integers
from ipmlang.inverse.parts.forms import recolored
from ipmlang.inverse.parts.observation import Likeness, Parts
from ipmlang.inverse.parts.scaling import as_one
from ipmlang.inverse.split.scheme import Ring
from ipmlang.inverse.split.search.drafts import Draft, Limits, first_draft
from ipmlang.inverse.split.search.fields import field_of
from ipmlang.inverse.split.search.patterns import Memory, arranged
from ipmlang.inverse.split.search.seeds import edges_of
from ipmlang.inverse.split.search.shortest import NOTHING, SHARES
from ipmlang.inverse.split.search.swelling import FEWEST
from ipmlang.inverse.split.snapping import members

KINDS = 2  # kinds of pairs that have to occur in several sizes: one alone happens by chance
VARIED = 0.1  # of the pairs that stand more than once, by those that differ in material
SIZED = 1e-3  # by which sizes differ
NONE = np.zeros(0, np.int64)


def promising(parts: Parts, error: float) -> tuple[Likeness, ...]:
    """The likenesses of classes that stand in growing rows, or in pairs that are there in several
    sizes; error: units that a part may be off.
    """
    if not parts.likenesses:
        return ()
    limits = Limits(SHARES[0] * error, NOTHING * error)
    joined = as_one(parts, parts.likenesses)
    draft = first_draft(joined, joined.low.min(axis=0), limits)
    wanted = set(parts.shape[_in_scaled_pairs(draft, limits)].tolist())
    heads = {each.of for each in parts.likenesses}
    wanted |= set(parts.shape[_in_growing_rows(draft, heads, limits)].tolist())
    return tuple(each for each in parts.likenesses if each.shape in wanted)


def _in_scaled_pairs(draft: Draft, limits: Limits) -> Integers:
    """Rows that stand to a neighbour as larger or smaller ones do elsewhere."""
    edges = edges_of(field_of(draft), limits.error)
    scale = draft.frames.scale[edges.pairs[:, 0]]
    groups = members(edges.label, int(edges.label.max(initial=-1)) + 1)
    scaled = [rows for rows in groups if len(rows) > 1 and np.ptp(scale[rows]) > SIZED]
    rows = np.concatenate(scaled if len(scaled) >= KINDS else [NONE])
    return np.asarray(edges.pairs[rows].ravel())


def _in_growing_rows(draft: Draft, symbols: set[int], limits: Limits) -> Integers:
    """Rows of these symbols that stand in rows that grow."""
    found = [NONE]
    for symbol in sorted(symbols):
        rows = np.flatnonzero(draft.symbol == symbol)
        if len(np.unique(np.round(draft.frames.scale[rows], 4))) >= FEWEST:
            own = arranged(draft.figures[symbol], draft.frames[rows], symbol, limits, Memory())
            for number, item in enumerate(own.items):
                if isinstance(item, Ring) and item.grows:
                    found.append(rows[own.patterns == number])
    return np.concatenate(found)


def in_other_materials(parts: Parts, error: float) -> tuple[Likeness, ...]:
    """The likenesses of classes of one form but other materials, if many of them stand to a
    neighbour, which is the same everywhere, as others do elsewhere; error: units that a part may
    be off.
    """
    found = recolored(parts, error)
    if not found:
        return ()
    forms = as_one(parts, found)
    limits = Limits(SHARES[0] * error, NOTHING * error)
    draft = first_draft(forms, forms.low.min(axis=0), limits)
    edges = edges_of(field_of(draft), limits.error)
    kinds = often = every = 0
    for rows in members(edges.label, int(edges.label.max(initial=-1)) + 1):
        pair = parts.shape[edges.pairs[rows]]
        varied = (pair != pair[0]).any(axis=0)
        every += len(rows) if len(rows) > 1 else 0
        if varied.any() and not varied.all():
            kinds, often = kinds + 1, often + len(rows)
    return found if kinds >= KINDS and often >= VARIED * every else ()
