"""Step 2: collapse the tree of rays into a linear system."""
