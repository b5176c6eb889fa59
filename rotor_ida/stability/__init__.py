"""How small differences from a motion grow or die away."""
