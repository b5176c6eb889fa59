"""From measured signals to the parameters of a machine."""
