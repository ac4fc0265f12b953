"""Groups along an axis as cells that fill a length: where each begins, and what gives way.

In go runs of groups, out come cells without gaps between them: runs as elastic cells again and
again, empty rests that share what is left over. Engines that derive these at the length given here
find every cell where it was (conformance: the arithmetic of sizes). What is in a cell is not known.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ipmlang.inverse.split.facades.guillotine import Groups, Run

MISSING = 0.25  # of its length that the last cell may reach beyond its contents


@dataclass(frozen=True, slots=True)
class Span:
    """`count` cells of `length` that begin at `low`, the first with the groups from `first` to
    `last` (not included) in it; these equal: nothing is in it. kind: the same for equal contents.
    """

    low: float
    length: float
    count: int
    first: int = 0
    last: int = 0
    elastic: bool = False
    kind: int = -1

    @property
    def high(self) -> float:
        """Where the last cell ends."""
        return self.low + self.count * self.length

    @property
    def empty(self) -> bool:
        """Whether nothing is in it."""
        return self.first == self.last


def spans(groups: Groups, found: Sequence[Run], length: float, small: float) -> list[Span] | None:
    """Cells from 0 to `length`; None where there is no room for them in their order."""
    laid = _widened(list(_laid(groups, found, length, small)), length)
    filled: list[Span] = []
    at = 0.0
    for span in laid:
        if span.low > at + small:
            filled.append(Span(at, span.low - at, 1, elastic=True))
        elif span.low < at - small:
            return None
        if span.length <= small or span.high > length + small:
            return None
        filled.append(span)
        at = span.high
    if at < length - small:
        filled.append(Span(at, length - at, 1, elastic=True))
    return _with_elastic(filled)


def _widened(laid: list[Span], length: float) -> list[Span]:
    """Single cells reach to the next one, all of a kind as far as the one with least room; the
    last reaches to the end where little is missing.
    """
    ends = [span.low for span in laid[1:]] + [length]
    room = [end - span.low for span, end in zip(laid, ends, strict=True)]
    if room[-1] > (1 + MISSING) * laid[-1].length:
        room[-1] = laid[-1].length
    least: dict[int, float] = {}
    for span, own in zip(laid, room, strict=True):
        least[span.kind] = min(least.get(span.kind, own), own)
    return [
        span if span.count > 1 else replace(span, length=own if span.kind < 0 else least[span.kind])
        for span, own in zip(laid, room, strict=True)
    ]


def _with_elastic(laid: list[Span]) -> list[Span]:
    """Something has to give way: where nothing is empty or repeats, the longest does."""
    if not any(span.elastic for span in laid):
        longest = max(range(len(laid)), key=lambda place: laid[place].length)
        laid[longest] = replace(laid[longest], elastic=True)
    return laid


def _laid(groups: Groups, found: Sequence[Run], length: float, small: float) -> Iterator[Span]:
    """Where each run and each single group begins. What is between them is not theirs yet."""
    before = 0.0
    for place, run in enumerate(found):
        stop, count = run.first + run.period, run.count
        low, high = float(groups.low[run.first]), float(groups.high[run.first : stop].max())
        if count == 1:
            begin = max(low, before) if low > before - small else low
            yield Span(begin, high - begin, 1, run.first, stop, kind=run.kind)
            before = high
            continue
        content = high - low
        last = low + (count - 1) * run.step
        after = found[place + 1].first if place + 1 < len(found) else None
        beyond = (length if after is None else float(groups.low[after])) - last - content
        margin = _margin(run.step - content, max(low - before, 0.0), beyond, small)
        if margin is None:
            margin, count = 0.0, count - 1
        yield Span(low - margin, run.step, count, run.first, stop, elastic=count > 1)
        before = low - margin + count * run.step
        if count < run.count:
            first = run.first + run.period * count
            yield Span(before, content, 1, first, first + run.period)
            before = last + content


def _margin(slack: float, room: float, beyond: float, small: float) -> float | None:
    """How far before its contents the first cell of a run begins; None: nowhere, as what is empty
    in the last cell does not fit behind it.

    slack: what is empty in a cell; room, beyond: what is empty before and behind the run. Best is
    the middle where both sides are alike, else to begin where what is before ends, or to end where
    what is behind begins.
    """
    if slack - room > beyond + small:
        return None
    if slack <= 0:
        return 0.0
    if abs(room - beyond) > small:
        if room <= slack:
            return room
        if beyond <= slack:
            return slack - beyond
    return min(slack / 2, room)
