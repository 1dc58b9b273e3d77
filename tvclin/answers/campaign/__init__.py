"""Campaigns: many dispersed cases, drawn by their index, computed together, with confidence.

The files inside: `draws` gives each case its random numbers, `dispersions` makes dispersed values
of them, `statistics` bounds quantiles and probabilities, and `quick` disperses a study.

For many cases: `file` reads a `plan`; `cases` makes vehicles of random numbers and `outputs` (with
`flights`) the answers; `manifest` holds the plan and its hash, `chunks` are its files, `engine`
runs them on `executors`, `results` reads them, `summary` tabulates them, `replay` repeats a case.
"""
