"""Gains for the least nozzle: the minimum deflection of all gains with the specified margins.

The files inside: `question` is the specification, with its refusals, and the margins that a row of
gains lacks; `race` finds by flights the limits that rows of gains require; `least` is the public
function; `record` the answer; `front` its curve over the disk margin, `schedule` the gains over a
flight, `asked` the gains from options and files. The search itself is in `answers.search`.
"""
