"""The equations: the contact law, the model, and the derivation of the core's C from them."""
