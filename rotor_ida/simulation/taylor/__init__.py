"""Taylor series: the third method, and what needs the motion as a polynomial."""
