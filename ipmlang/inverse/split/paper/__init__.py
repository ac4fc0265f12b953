"""The split tree of the 2016 paper: octants, labels of equal subtrees, subdivisions, raw form."""
