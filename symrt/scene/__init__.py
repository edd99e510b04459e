"""What is there: cameras, lights, materials and shapes, numbers and names only (step 1)."""
