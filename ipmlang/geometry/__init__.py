"""Polygons and solids: pure functions from geometry to geometry, free of derivation and of files.

`solid` is the one type; every other file takes solids and numbers and gives solids. What cannot be
done raises `GeometryError`; whoever called adds the rule and the way there.
"""
