"""Array kernels: plain arithmetic on arrays, with no objects and no units above them."""
