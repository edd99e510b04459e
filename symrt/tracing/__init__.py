"""Step 1: trace a scene once and record the tree of rays."""
