"""Edits that keep a grammar a grammar: parameters set, randomised and made equal, symbols replaced.

A draft is read, each edit takes one and gives the next, `save` checks the last and writes it. What
an edit does not speak of, comments included, stays as it was. Nothing here infers or prints.

>>> from ipmlang import edit
>>> row = edit.read_text('''
... ipm 1
... attr n : int = 4 in 1..99
... Row --> repeat(i < n) { [F(3)] f(13) }  // one behind the other
... start Row
... ''')
>>> row = edit.set_values(row, {"n": 6})
>>> row = edit.randomise(row, edit.Selection("Row", "f"), edit.amount("1"))
>>> print(row.text, end="")
ipm 1
attr n : int = 6 in 1..99
Row --> repeat(i < n) { [F(3)] f(13 + rand(-1, 1)) }  // one behind the other
start Row
"""

from __future__ import annotations

from ipmlang.edit.draft import Change, Draft, read, read_text
from ipmlang.edit.flattening import flatten, symbol
from ipmlang.edit.parameters import change, set_values
from ipmlang.edit.randomise import Amount, amount, randomise, randomise_values
from ipmlang.edit.replacing import Symbol, replace_rule, replace_terminal
from ipmlang.edit.saving import Finished, finish, save
from ipmlang.edit.selection import Selection
from ipmlang.edit.symmetrise import Tolerances, symmetrise

__all__ = [
    "Amount",
    "Change",
    "Draft",
    "Finished",
    "Selection",
    "Symbol",
    "Tolerances",
    "amount",
    "change",
    "finish",
    "flatten",
    "randomise",
    "randomise_values",
    "read",
    "read_text",
    "replace_rule",
    "replace_terminal",
    "save",
    "set_values",
    "symbol",
    "symmetrise",
]
