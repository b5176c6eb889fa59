"""Reports on close clearances: the response to unbalance against them, and what a touch does."""
