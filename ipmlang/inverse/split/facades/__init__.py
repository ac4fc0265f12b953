"""Schemes as splits: floors, bays and façades, and what follows or is anchored in its scope.

A scheme goes in, one with splits comes out where that is shorter.
"""
