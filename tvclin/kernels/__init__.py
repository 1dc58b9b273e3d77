"""Loops over numbers in arrays, run as plain Python or as machine code of the same."""
