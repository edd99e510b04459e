"""Paths and entries, compiled (step 2): what `symrt.linear` does in NumPy, to the same bits."""
