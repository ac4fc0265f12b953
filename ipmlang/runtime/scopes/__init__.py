"""Scopes and their geometry while a derivation runs: boxes as columns, a pool for everything else.

`scoping` is what bodies call; `shaping` and `pieces` are the operations by name; `ground` is what a
derivation starts on. Nothing here knows rules.
"""
