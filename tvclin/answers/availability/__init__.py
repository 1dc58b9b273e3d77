"""On how many days a deflection limit is enough: the winds of an archive, judged one by one.

The files inside: `sounding_winds` is the wind of each sounding over even steps of a flight, and
where nobody measured it; `plane_march` what all of them require in one plane, from trim and demand
or by flights; `growth` what a wind may add until launch; `judge` puts these together; `confidence`
counts, with an interval; `record` is the answer; `availability` computes it, and `request` is that
of a study file.
"""
