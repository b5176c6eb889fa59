"""The equations: the contact law, the model, and how both become machine code."""
