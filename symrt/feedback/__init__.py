"""Step 5: what the gamut says about the parameters."""
