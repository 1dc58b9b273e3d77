"""The page: one self-contained HTML file that gives the whole answer.

The files inside: `findings` computes everything that a plan asks for, `questions` answers each
question of it with yes or no; `verdict`, `sections`, `flight`, `control` and `basis` make blocks of
them, `figures` draws, and `page` puts the blocks into the template. `blocks` says what a block is:
every number keeps its full precision beside its text.

A further section is one more function from `Findings` to a `Section`, named in `page.SECTIONS`.
"""
