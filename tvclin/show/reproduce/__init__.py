"""The report again: its figures, sketches and numbers, each with one call."""
