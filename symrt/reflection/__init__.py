"""What surfaces do: a model of reflection is its formulas (step 1)."""
