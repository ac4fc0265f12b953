"""Split grammars inferred from buildings (Demir and Aliaga 2016), and what real models need beyond.

Parts come in, a scheme comes out: symbols that place symbols, shortest description first; then
syntax. `scheme` says what a scheme is.
"""
