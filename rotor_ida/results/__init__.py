"""Results on disk: archives, and studies that survive interruptions."""
