"""Where rays go: shapes, textures and the rays that meet them (step 1)."""
