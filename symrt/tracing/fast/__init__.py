"""Light at points, compiled (step 1): what `symrt.tracing` does in NumPy, to the same bits."""
