"""Gains for the least nozzle: of all that have the margins asked for, those that need least.

The files inside: `question` is what is asked, with its refusals, and what a row of gains lacks of
the margins; `race` the flights that find what a row of gains needs with a stop; `least` the door;
`record` the answer; `front` its curve over the disk margin, `schedule` the same over a flight,
`asked` the same from options and files. The search itself is in `answers.search`.
"""
