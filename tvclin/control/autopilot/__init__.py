"""The autopilot: attitude and rate feedback, with actuator and delay, around one plant.

The files inside: `actuator` holds what lies between a command and the deflection, `wiring` writes
down the loop that `diagram` shows, `systems` gives it to python-control, `feedback` is the
autopilot itself, `doubts` warns of what is hardly ever meant, `answer` and `wind_gain` say what a
wind does, `gains` and `optimal` find gains, `rules` calls them by name and `schedule` holds them
over the flight.
"""
