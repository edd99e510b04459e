"""Several parameters at once: fits, safe boxes, joint regions and the adaptive loop of step 5."""
