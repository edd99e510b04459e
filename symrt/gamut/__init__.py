"""Step 4: a device's spectral basis and gamut."""
