"""Mathematics on arrays, in numpy: polynomials, sums of exponentials, loops, zeros."""
