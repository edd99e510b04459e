"""Looking and playing: plots and pages."""
