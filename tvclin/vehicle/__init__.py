"""A vehicle, its files, and the coefficients of its motion."""
