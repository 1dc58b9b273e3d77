"""The page: one self-contained HTML file that gives the whole answer.

The files inside: `verdict`, `sections`, `flight`, `control` and `basis` make blocks of findings,
`figures` draws, and `page` puts the blocks into the template. `blocks` defines the blocks: every
number keeps its full precision beside its text.

A further section is one more function from `Findings` to a `Section`, named in `page.SECTIONS`.
"""
