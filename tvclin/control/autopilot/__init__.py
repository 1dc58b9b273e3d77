"""The autopilot: attitude and rate feedback, with actuator and delay, around one plant.

The files inside: `actuator` holds what lies between a command and the deflection, `actuated` puts
a plant behind it, `feedback` the numbers of an autopilot, `wiring` writes down the loop that
`diagram` shows, `systems` gives it to python-control, `warnings` tells what is legal and hardly
ever meant, `autopilot` is the autopilot itself; `answer` and `wind_gain` say what a wind does,
`gains` and `optimal` find gains, `rules` calls them by name and `schedule` holds them over the
flight.
"""
