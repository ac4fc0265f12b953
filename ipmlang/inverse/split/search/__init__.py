"""The search for the shortest scheme: motifs, patterns of them, and what a draft takes.

Parts come in, a scheme comes out. Nothing here prints or knows of splits.
"""
