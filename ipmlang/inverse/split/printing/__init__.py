"""Schemes as grammars: items of rules, tables of copies, names, and counts lifted to attributes.

A scheme goes in, syntax trees come out.
"""
