"""A tropism and limits that attributes decide: the same as if their numbers had been written."""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.verify import verify
from tests.engine.grammars import compiled

TREE = """A(n) : n > 0 --> F [+(25) A(n - 1)] A(n - 1)
A(n) : else --> F
start A(4)
"""
HEAD = 'ipm 1\nattr pull = 0.2\nattr most : int = 500 "how many"\n'


def test_a_tropism_of_an_attribute_bends_like_a_written_one() -> None:
    late = ipmlang.parse(HEAD + "tropism (0, -1, 0) pull\n" + TREE)
    assert verify(late.program) == []
    assert late.program.flat
    for pull in (0.2, 0.5):
        written = ipmlang.parse(f"ipm 1\ntropism (0, -1, 0) {pull}\n{TREE}").run().instances
        found = late.run(attrs={"pull": pull}).instances
        assert found.position.tolist() == written.position.tolist()
    straight = late.run(attrs={"pull": 0.0}).instances
    assert np.abs(straight.position - found.position).max() > 0.1


def test_a_tropism_whose_height_is_not_known_is_one_in_space() -> None:
    assert not compiled(HEAD + "tropism (0, 0, pull) 0.2\nstart F\n").flat
    assert not compiled(HEAD + "tropism (0, 0, -1) pull\nstart F\n").flat


def test_a_limit_of_an_attribute_stops() -> None:
    grammar = ipmlang.parse(HEAD + "limit shapes (most * 2) steps 50\n" + TREE)
    assert len(grammar.run().instances) == 31
    with pytest.raises(ipmlang.IpmError, match="its limit of 20 shapes"):
        grammar.run(attrs={"most": 10})
    with pytest.raises(ipmlang.IpmError, match="`limit shapes` is 0, but must be 1 or more"):
        grammar.run(attrs={"most": 0})


def test_limits_given_for_a_run_win_over_attributes() -> None:
    grammar = ipmlang.parse(HEAD + "limit shapes most\n" + TREE)
    plain = grammar.program.limits
    with pytest.raises(ipmlang.IpmError, match="its limit of 7 shapes"):
        grammar.run(attrs={"most": 10}, limits=type(plain)(shapes=7))
    with pytest.raises(ipmlang.IpmError, match="its limit of 10 shapes"):
        grammar.run(attrs={"most": 10}, limits=plain)
