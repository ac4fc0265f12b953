"""The search for the shortest scheme of a model: motifs, then patterns of them, until nothing pays.

Parts come in, the shortest scheme found comes out, exact to the error asked for and never longer
than placing every part by itself. Greedy in rounds, in a fixed order and under a bound of work
counted in lookups, so that the same parts give the same scheme everywhere. Nothing is printed here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import islice

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.split.cost import HEAD, scheme_tokens
from ipmlang.inverse.split.scheme import Scheme
from ipmlang.inverse.split.search.assembly import assembled, errors, flat
from ipmlang.inverse.split.search.completing import completed
from ipmlang.inverse.split.search.drafts import (
    Draft,
    Limits,
    Motif,
    first_draft,
    motif_box,
    with_motif,
)
from ipmlang.inverse.split.search.fields import Field, field_of
from ipmlang.inverse.split.search.figures import Figure, figure
from ipmlang.inverse.split.search.growth import Grown, grow
from ipmlang.inverse.split.search.laying import laid, symmetry_of
from ipmlang.inverse.split.search.orbits import coherent
from ipmlang.inverse.split.search.patterns import Memory
from ipmlang.inverse.split.search.pricing import Priced, gain_of, priced
from ipmlang.inverse.split.search.pruning import pruned, with_whole_patterns
from ipmlang.inverse.split.search.seeds import Edges, Seed, edges_of, labels_by_promise, seeds
from ipmlang.inverse.split.search.wholes import wholes
from ipmlang.inverse.split.snapping import Flags

PROVEN = 1e-6  # share of the diagonal that anything may be off
SHARES = (0.8, 0.5, 0.2, 0.05)  # of that, what a placement may be off, in turn
HOPE = 1.3  # times the bound that a scheme seems off, which a proof may still find to be within
NOTHING = 0.1  # of that, what is printed as nothing
LEAST = 2.0  # tokens that a rule has to save
TRIED = 10  # candidates of a round that are priced exactly
VARIANTS = 4  # of motifs that share rows, among very many rows: a round finds several motifs there
CROWD = 1000  # rows that are very many
ROUNDS = 60
TOGETHER, TOGETHER_WAYS = 24, 6_000  # kinds of pairs, and motions, that are looked at at a time
SEEDS = 100  # kinds of pairs that are grown before what grew is priced
BATCHES = 3  # how often in a round, where nothing pays
WORK, EACH = 250_000, 120  # lookups, and more of them for each part


def shortest(parts: Parts, error: float | None = None, work: int | None = None) -> Scheme:
    """The shortest scheme found for parts.

    error: units that a part may be off, None for what counts as exact; work: lookups after which
    the best so far is given, None for some of them and more for each part.
    """
    bound = PROVEN * parts.diagonal if error is None else error
    return next(each for each in schemes(parts, error, work) if _off(parts, each) <= bound)


def schemes(
    parts: Parts,
    error: float | None = None,
    work: int | None = None,
    memories: dict[float, Memory] | None = None,
) -> Iterator[Scheme]:
    """Schemes that should do, the ones that take more liberties first; the last has no rules.
    memories: what searches of like parts have arranged, by the errors allowed.

    How far parts are from their shapes counts too, but only a proof knows in which direction.
    """
    bound = PROVEN * parts.diagonal if error is None else error
    plain = flat(parts)
    known = {} if memories is None else memories
    for share in SHARES:
        limits = Limits(share * bound, NOTHING * bound)
        memory = known.setdefault(limits.error, Memory())
        lookups = WORK + EACH * len(parts.shape) if work is None else work
        found = _searched(parts, limits, lookups, memory)
        if scheme_tokens(found, limits.small) >= scheme_tokens(plain, limits.small):
            break  # where less may be off there is less to find
        if _off(parts, found) <= HOPE * bound:
            yield found
    yield plain


def _off(parts: Parts, scheme: Scheme) -> float:
    """Units that a vertex may well be off."""
    return float(np.hypot(errors(parts, scheme), parts.misfit).max(initial=0.0))


def _searched(parts: Parts, limits: Limits, work: int, memory: Memory) -> Scheme:
    origin = parts.low.min(axis=0) if len(parts.low) else np.zeros(3)
    draft = first_draft(parts, origin, limits)
    spent = 0
    for _ in range(ROUNDS):
        better, used = _improved(draft, limits, memory, work - spent)
        spent += used
        if better is None:
            break
        draft = better
    draft = with_whole_patterns(pruned(draft, limits, memory), limits, memory)
    return assembled(parts, draft, origin, limits, memory)


@dataclass(frozen=True, slots=True, eq=False)
class Offer:
    """A motif that may pay, and the figure of its rule when it is asked for; gain: the tokens it
    may save.
    """

    gain: float
    motif: Motif
    shape: Callable[[], Figure]


def _improved(draft: Draft, limits: Limits, memory: Memory, work: int) -> tuple[Draft | None, int]:
    """The draft with the motifs of one round, None where nothing pays; and the work it took."""
    if work <= 0 or len(draft) < 4:
        return None, 0
    field = field_of(draft)
    base = priced(draft, limits, memory)
    used = len(draft)
    for grown, took in islice(_grown(field, limits), BATCHES):
        used += took
        better = _taken(base, _offers(field, grown, base, limits), limits, memory)
        if better is not None or used > work:
            return better, used
    grown = [each for each in wholes(field, limits.error) if len(each.rows)]
    return _taken(base, _offers(field, grown, base, limits), limits, memory), used


def _grown(field: Field, limits: Limits) -> Iterator[tuple[list[Grown], int]]:
    """Motifs from the seeds of this field, some at a time, and the work they took; those that
    others contain just as often are left out.
    """
    edges = edges_of(field, limits.error)
    covered = np.zeros(len(edges.pairs), np.bool_)
    found: list[Grown] = []
    used = 0
    for tried, alike in enumerate(_seeded(field, edges, covered, limits.error), 1):
        for seed in alike:
            chain, took = grow(field, seed, limits.error)
            used += took + len(seed.of)
            found += chain
            for each in chain[:1] + chain[-1:]:
                _cover(edges, each, covered)
        if tried % SEEDS == 0:
            yield found, used
            found, used = [], 0
    yield found, used


def _seeded(field: Field, edges: Edges, covered: Flags, error: float) -> Iterator[list[Seed]]:
    """The seeds of each label of which some edges are not covered when its turn comes; looked for
    in some labels at a time.
    """
    waiting = labels_by_promise(edges)
    at = 0
    while at < len(waiting):
        some: list[Integers] = []
        ways = 0
        while at < len(waiting) and len(some) < TOGETHER and ways < TOGETHER_WAYS:
            chosen = waiting[at]
            at += 1
            if not covered[chosen].all():
                some.append(chosen)
                symbols = field.draft.symbol[edges.pairs[chosen[0]]]
                ways += len(chosen) * int(field.round[symbols].max())
        for chosen, found in zip(some, seeds(field, edges, some, error), strict=True):
            if not covered[chosen].all():
                yield found


def _cover(edges: Edges, grown: Grown, covered: Flags) -> None:
    """Mark the edges inside a motif whose kinds occur no more often than it does."""
    top = int(edges.pairs.max()) + 1
    home = np.full(top, -1, np.int64)
    rows = grown.rows[(grown.rows < top).all(axis=1)]
    for index, own in enumerate(rows):
        home[own] = index
    inside = home[edges.pairs]
    covered |= (inside[:, 0] >= 0) & (inside[:, 0] == inside[:, 1])


def _offers(field: Field, grown: list[Grown], base: Priced, limits: Limits) -> list[Offer]:
    """The motifs that promise most, placed exactly."""
    promising: dict[bytes, tuple[float, Grown]] = {}
    share, loose = base.share, base.loose
    for each in grown:
        if len(np.unique(each.rows)) < each.rows.size:
            continue  # two occurrences would have to share
        gain = _promise(share[each.rows]) + float(loose[each.rows].sum())
        if gain > 0:
            promising.setdefault(np.sort(each.rows.ravel()).tobytes(), (gain, each))
    ranked = sorted(promising.values(), key=lambda pair: (-pair[0], -pair[1].rows.size))
    found: list[Offer] = []
    for gain, each in islice(_various(field, ranked), 2 * TRIED):
        whole = coherent(field, completed(field, each, limits.error))
        motif = laid(field, whole, limits)
        if motif is not None:
            found.append(Offer(gain, motif, _later(field.draft, motif, limits)))
        if len(found) == TRIED:
            break
    return found


def _various(field: Field, ranked: list[tuple[float, Grown]]) -> Iterator[tuple[float, Grown]]:
    """The motifs in order; among very many rows without those that several before them are like."""
    variants = np.zeros(len(field.draft), np.int64)
    for gain, each in ranked:
        if len(field.draft) < CROWD or variants[each.rows[0]].max() < VARIANTS:
            variants[each.rows.ravel()] += 1
            yield gain, each


def _promise(share: Floats) -> float:
    """Tokens that a motif saves if its uses stand as regularly as what it is made of."""
    return float(share.sum() - share.sum(axis=1).min() - share.sum(axis=0).min()) - HEAD


def _taken(base: Priced, offers: list[Offer], limits: Limits, memory: Memory) -> Draft | None:
    """The draft with the best of the offers, and all others that still pay then."""
    good = []
    for offer in offers:
        gain = gain_of(base, offer.motif, offer.shape, limits, memory, LEAST)
        if gain >= LEAST:
            good.append(replace(offer, gain=gain))
    good.sort(key=lambda offer: -offer.gain)
    where = np.arange(len(base.draft))
    result: Draft | None = None
    for offer in good:
        rows = where[offer.motif.rows]
        if (rows < 0).any():
            continue
        motif = Motif(rows, offer.motif.places, offer.motif.inside)
        if result is not None:
            base = priced(result, limits, memory)
            least = max(LEAST, 0.5 * offer.gain)
            if gain_of(base, motif, offer.shape, limits, memory, least) < least:
                continue
        result = with_motif(base.draft, motif, offer.shape())
        kept = np.ones(len(base.draft), np.bool_)
        kept[rows.ravel()] = False
        number = np.where(kept, np.cumsum(kept) - 1, -1)
        where = np.where(where >= 0, number[where], -1)
    return result


def _later(draft: Draft, motif: Motif, limits: Limits) -> Callable[[], Figure]:
    """The figure of the rule that a motif would be, made when it is first asked for."""

    @cache
    def shape() -> Figure:
        low, high = motif_box(draft, motif)
        return figure(low, high, symmetry_of(draft, motif, limits))

    return shape
