"""A notebook with a panel in which vehicle, wind, nozzle, law and autopilot are moved by hand.

The files inside: `choices` (the case that the controls specify, their ranges, and its study file),
`answer` (numbers and verdict for the choices, in steps), `picture` (drawn once, then only its
lines), `panel` (the widgets) and `lab` (the notebook and JupyterLab, which runs it; in
`labextensions` is its part in the page).
"""
