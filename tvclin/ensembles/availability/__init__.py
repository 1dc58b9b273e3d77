"""Launch availability: the fraction of days, by an archive of winds, with a sufficient limit."""
