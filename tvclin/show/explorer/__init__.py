"""One notebook in which vehicle, wind, nozzle, law and autopilot are moved by hand.

The files inside: `choices` (what is asked), `controls` (where each begins, and the case that they
ask for), `parts` (numbers, each kept by what it depends on), `answer` (all numbers for the choices,
in steps, and the verdict), `picture` (drawn once, then only its lines), `study` (the choices as a
file), `panel` (the widgets) and `lab` (the notebook and JupyterLab, which runs it; in
`labextensions` is its part in the page).
"""
