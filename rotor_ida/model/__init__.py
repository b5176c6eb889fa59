"""The equations: the contact law, the model, and what derives the core's C from them."""
