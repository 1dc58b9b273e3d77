"""Launch availability: the fraction of days, by an archive of winds, with a sufficient limit.

The files inside: `sounding_winds` is the wind of each sounding over even steps of a flight, and
where it was not measured; `plane_march` the requirements of all winds in a plane, from trim and
demand or by flights; `growth` the increase of a wind until launch; `judge` puts these together;
`confidence` counts, with an interval; `record` is the answer; `availability` computes it, and
`request` is its specification in a study file.
"""
