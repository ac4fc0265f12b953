"""The bytecode of the GPU executor: operations, and how code, data and records lie in buffers.

The encoder writes it, one fixed shader runs it; the shader gets these numbers as macros, so that
there is one table of them. All numbers of a grammar are f64 on both sides.

Code is words: four a instruction, `op | out << 8 | a << 16 | b << 24`, then
`c | d << 8 | n << 24`, then two immediate words. Registers are numbered 0 to 255: first the fields
of the state, then the parameters of the shape, then what the body computes. Data is f64: the
attributes, then constants and tables.

A record is a shape that waits: HEADER words (see `Header`), then the state and the parameters, two
words a number. A terminal is TERMINAL words, then its size and its state. Both lie column by
column: word w of row n is at w * capacity + n.
"""

from __future__ import annotations

from enum import IntEnum


class Op(IntEnum):
    """What an instruction does; names of fields are those of the words above."""

    END = 0
    LOAD = 1  # out = data[z]
    COPY = 2  # out = a
    CALL = 3  # out = function z of (a, b, c)
    PICK = 4  # out = one of the n registers listed at z, by the uniform a
    KEY = 5  # key = child of the shape's key at site z, or that key; n: it may be broken off here
    MIX = 6  # key = its child at the copy number in a
    UNIFORM = 7  # out = the draw of that key
    ROW = 8  # out = data[z + a], a at most w - 1
    MOVE = 9  # by (a, b, c) along the local axes
    TURN = 10  # by a degrees about axis z
    ORIENT = 11  # by the quaternion (a, b, c, d)
    SCALE = 12  # by a
    MIRROR = 13
    LEVEL = 14
    SIZE = 15  # the scope's extents become (a, b, c)
    SLAB = 16  # the part of the scope from a on, b long, along axis z; to w where there is none
    ZERO = 17  # to z where a is 0; NaN is trouble
    SHOW = 18  # nothing is made from here on where a is 0
    EMIT = 19  # draw asset z for symbol w; n: no size, (a, b, c), or the scope's
    CHILD = 20  # a shape of symbol z, its n arguments in the registers listed at w
    RANGE = 21  # a copies of block z, with the n registers listed at w
    COUNT = 22  # out = how many copies a limit of a makes
    LOOP = 23  # a += 1; back to z where a < b; n: it may not be broken off
    MEASURE = 24  # out = area (z 0), volume (1) or sides (2) of the scope's box
    EXTRUDE = 25  # a rectangle becomes a box a high, whose geometry is number data[z]
    FACE = 26  # the scope becomes that of the face with number a of those in table z
    CENTER = 27  # to the point of the box whose shares data has at z; n: back from there
    FLIP = 28  # the scope is mirrored within itself along axis z, if MIRROR comes next
    FETCH = 29  # out = what the channel of a context whose data code[z] leads to is at (a, b)
    CHECK = 30  # a must be finite where something is made; n: everywhere; 2: and not below 0
    FACES = 31  # out = how many faces of the scope's box the part with table z takes
    RULE = 32  # production z is applied from here on
    SHARE = 33  # alternative z is taken with a chance of a, unless one before it was
    TAKE = 34  # alternative z is taken, unless one before it was; to w
    CHOOSE = 35  # to the code of what was taken: the z-th list has code and production by turns
    JUMP = 36  # to z
    DIFFER = 37  # out = whether a and b are not the same number


class Trouble(IntEnum):
    """Bits of the error word: why a run on the GPU is given up and derived by numpy, which tells
    what is wrong and where.
    """

    NOT_FINITE = 1
    NO_PRODUCTION = 2
    SHARES = 4
    FACTOR = 8
    EXTENT = 16
    COUNT = 32
    GEOMETRY = 64
    STACK = 128
    LIMIT = 256


class Header(IntEnum):
    """The words of a record before its numbers. ENTRY: a symbol, a block (with BLOCK) or a place
    in the code to go on at (with RESUME). GENERATION: its own, or that of what a block makes. RULE:
    the production that made it, or the block's own. PARENT, COPY and SEQUENCE: the record that made
    it, in which copy, and as which of all it made: its place in the order of the derivation.
    COUNT: copies that a block stands for.
    """

    ENTRY = 0
    GENERATION = 1
    KEY0 = 2
    KEY1 = 3
    RULE = 4
    PARENT = 5
    COPY = 6
    SEQUENCE = 7
    COUNT = 8


class Terminal(IntEnum):
    """The words of a terminal before its numbers, which are its size and its state."""

    PARENT = 0
    COPY = 1
    SEQUENCE = 2
    SYMBOL = 3
    ASSET = 4
    RULE = 5
    KEY0 = 6
    KEY1 = 7


class Entry(IntEnum):
    """The words that say what becomes of a symbol: the code that chooses among its productions, and
    among its interpretations, the code of its meaning (NONE where there is none), flags, arity.
    """

    PRODUCTIONS = 0
    INTERPRETATIONS = 1
    MEANING = 2
    FLAGS = 3
    ARITY = 4


class Count(IntEnum):
    """The words that all threads share: how many records, terminals and returned shapes there are,
    how many copies the records stand for, trouble, threads that came to their end, shapes made,
    the deepest generation, and the first words of notes on what was left out.
    """

    RECORDS = 0
    TERMINALS = 1
    RETURNED = 2
    COPIES = 3
    TROUBLE = 4
    ENDED = 5
    SHAPES = 6
    GENERATION = 7
    STOPPED = 8  # the production or, beyond those and one more, the symbol that met trouble
    NOTES = 16


HEADER = len(Header)
TERMINAL = len(Terminal)
ENTRY = len(Entry)
WORDS = 4  # of an instruction
NONE = 0xFFFFFFFF
BLOCK = 0x40000000
RESUME = 0x80000000
HIDDEN = 0x20000000  # of a resumed entry: nothing is made
FINAL = 0x40000000  # the generation of what only its meaning is left of
ON_CPU = 1  # flags of an entry: the CPU derives it
LONG = 500  # instructions of a body that may have to be broken off
REGISTERS = 256


def macros() -> str:
    """All of these as lines of GLSL."""
    lines = [f"#define OP_{each.name} {each.value}u" for each in Op]
    lines += [f"#define TROUBLE_{each.name} {each.value}u" for each in Trouble]
    for table in (Header, Terminal, Entry, Count):
        lines += [f"#define {table.__name__.upper()}_{each.name} {each.value}u" for each in table]
    for name in ("HEADER", "TERMINAL", "ENTRY", "NONE", "BLOCK", "RESUME", "FINAL",
                 "HIDDEN", "ON_CPU"):  # fmt: skip
        lines.append(f"#define {name} {globals()[name]}u")
    return "\n".join(lines) + "\n"
