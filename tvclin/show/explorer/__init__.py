"""One notebook in which vehicle, wind, limit, law and gains are moved by hand.

The files inside: `choices` (what is asked), `parts` (numbers, each kept by what it depends on),
`answer` (all numbers for the choices, and the verdict), `picture` (drawn once, then only its
lines), `study` (the choices as a file), `panel` (the widgets), `notebook` (the file that Jupyter
opens) and `lab` (JupyterLab, which runs it; in `labextensions` is its part in the page).
"""
