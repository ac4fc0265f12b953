"""The checker's subjects, one file each; `compiler/check.py` puts them together."""
