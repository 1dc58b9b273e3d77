"""Many dispersed cases: drawn by their own index, computed together, judged with confidence.

The files inside: `draws` gives each case its random numbers, `dispersions` makes vehicles and
winds of them, `statistics` says what a sample proves, and `quick` answers for one study.

For many cases: `file` reads a `plan`; `cases` makes vehicles of random numbers and `outputs` (with
`flights`) the answers; `manifest` seals the plan, `chunks` are its files, `engine` runs them on
`executors`, `results` reads them, `summary` says what they find, and `replay` shows one case.
"""
