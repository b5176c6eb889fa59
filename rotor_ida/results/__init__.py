"""What is kept on disk: archives of results, and studies that survive interruptions."""
