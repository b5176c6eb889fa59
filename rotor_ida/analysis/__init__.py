"""What the response curve cannot show: axes, sections, spectra, forces, exponents, extrema."""
