"""On how many days a deflection limit is enough: the winds of an archive, judged one by one.

The files inside: `tables` integrates what does not depend on the wind, once for a flight; `needs`
is what many winds ask for, by these; `met` is the wind that a flight meets in each sounding, and in
what of it nobody measured; `growth` is what a wind may add until launch; `judge` puts these
together; `confidence` counts, with an interval; `record` is the answer; `availability` asks for it,
and `asked` is what a study file does.
"""
