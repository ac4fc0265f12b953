"""Edits that keep the structure of a building: its parts are stretched, copied, joined and re-used.

In go drafts of split grammars, out come drafts; what touched still touches, or the edit is refused.
After Demir, Aliaga and Benes, "Proceduralization for Editing 3D Architectural Models" (2016),
section 4.
"""
