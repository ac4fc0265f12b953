"""What a rule for stretches of rows, and the calls of it, take at least: most of what is tried is
known to be too long from the places of its rows alone.

Takes rows as they stand; gives a bound that holds for every frame that the stretches could have and
whatever becomes a parameter. Nothing here fits numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

from ipmlang.inverse.folding.fits import HEAD, READ, Rounding
from ipmlang.inverse.folding.rows import Row

PLACE = 7  # `[at(x, y) … ]`
INSIDE = (
    4  # of those where a bracket of rows stands, which may share its brackets with what is in it
)
APART = 16.0  # times the error of a number that two places are apart which no fit makes one
TURNED = 1e-6  # degrees or ratio that no two equal turns or sizes are apart
MOST = 16  # rows of which each two are compared


def least_tokens(stretches: Sequence[Sequence[Row]], given: Rounding) -> int:
    """Tokens of a rule for some stretches and of its calls, at least: each row is said once, all
    but one of those that stand apart with their places, and each call with its name and place and
    with what must be a parameter.
    """
    first, calls = stretches[0], len(stretches)
    own = HEAD + calls + sum(row.least for row in first)
    symbols = any(
        each.names != row.names for rows in stretches for each, row in zip(rows, first, strict=True)
    )
    several = symbols + _numbers_vary(stretches, given)
    if several:
        own += 2 * (calls + 1) + several * (calls + 1 + READ)
    if not all(row.placed for row in first):
        return own
    placed = [sum(map(_place, column)) for column in zip(*stretches, strict=True)]
    if len(first) > MOST:
        return own + min(placed)
    return own + min(
        call + _others(first, row, given) for call, row in zip(placed, first, strict=True)
    )


def _numbers_vary(stretches: Sequence[Sequence[Row]], given: Rounding) -> bool:
    """Whether some number must be a parameter, in whatever frame the stretches stand."""
    first, room = stretches[0], APART * given.error
    largest = max(1.0, *(row.frame[3] for row in first))
    known = [_beside(first[0], row) for row in first]
    for rows in stretches[1:]:
        if any(_inside_varies(each, row, room) for each, row in zip(rows, first, strict=True)):
            return True
        beside = [_beside(rows[0], each) for each in rows]
        pairs = list(zip(beside, known, strict=True))
        if any(abs((one[1] - other[1] + 180.0) % 360.0 - 180.0) > TURNED for one, other in pairs):
            return True
        # What is larger in all may be the same in a larger frame.
        sized = any(one[2] != other[2] for one, other in pairs)
        if not sized and any(abs(one[0] - other[0]) > room * largest for one, other in pairs):
            return True
    return False


def _inside_varies(row: Row, other: Row, room: float) -> bool:
    """Whether numbers differ that are the same in every frame."""
    if row is other or len(row.numbers) == len(row.frame):
        return False
    own = zip(row.numbers[4:], other.numbers[4:], strict=True)
    return any(abs(one - value) > room for one, value in own)


def _beside(lead: Row, row: Row) -> tuple[float, float, float]:
    """How far a row is from another one, how it is turned beside that, degrees, and its size."""
    (x, y, angle, _), (at_x, at_y, turn, size) = lead.frame, row.frame
    return hypot(at_x - x, at_y - y), turn - angle, size


def _place(row: Row) -> int:
    """Tokens of the place of a call that stands where a row does."""
    x, y, _, _ = row.frame
    return PLACE + (x < 0) + (y < 0) if x or y else 0


def _others(rows: Sequence[Row], lead: Row, given: Rounding) -> int:
    """Tokens of the places of rows beside one of them, signs apart."""
    x, y, _, scale = lead.frame
    room = APART * given.error * max(1.0, scale)
    total = 0
    for row in rows:
        if abs(row.frame[0] - x) > room or abs(row.frame[1] - y) > room:
            total += INSIDE if row.inner else PLACE
    return total
