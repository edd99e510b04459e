"""Step 3: spectra by name, products of spectra, and images."""
