"""Lattices: rows, rings, spirals and grids among placements in any paint order, with noise and
holes.

`find` looks for them, `choice` takes those that pay, `formula` says one with numbers that a person
would write, `printing` makes syntax of it. Nothing here searches for motifs or pairs.
"""
