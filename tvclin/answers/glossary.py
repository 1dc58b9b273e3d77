"""What the symbols and the terms of a study mean, each in one line."""

SYMBOLS = {
    "beta": "1/beta is the time in which the vehicle falls over, eq (B4)",
    "B": "deflection that trims one degree of wind angle, eq (2)",
    "K": "dead band: trim up to K times the limit, then the whole limit; K = 1 needs no forecast",
    "y_BR": "boundary limit: the least limit that survives, over what trim takes",
    "K1": "what drift leaves of the wind, eq (15b); below 1, for the vehicle moves with the wind",
    "C1": "rate at which the flight path follows the attitude, eq (B7)",
    "C2": "what the weight adds to the poles with drift, eq (B7)",
    "b1, b2": "zeros of the attitude's answers to deflection and wind, with drift, eq (B7)",
}
"""The symbols that a study prints."""

TERMS = {
    "deflection": "angle of the engine from its nominal position",
    "limit": "the largest deflection of the engine, its stop",
    "wind angle": "angle of attack that the wind alone makes: its speed across the path over the"
    " speed of the vehicle",
    "trim": "the deflection that cancels the moment of the wind at every instant",
    "survive": "the deflection cancels what the wind puts into the growing motion; the attitude may"
    " still drift",
    "required": "the least limit that survives, the largest of all that the study knows",
    "boundary": "the least limit with which a control by dead band survives, condition (4b)",
    "minimum": "the least limit of any control that knows the whole wind beforehand, appendix C",
    "no forecast": "a lower bound of the limit for all laws that do not know when the wind stops",
    "drift": "the flight path turns with the side force, so the vehicle moves with the wind",
    "fixed-path": "model without drift: the flight path stays nominal",
    "drift-exact": "model with drift, eq (B7): one pole grows fast, a second one slowly",
    "drift-and-speed": "model with drift and with the change of speed",
    "pole": "a motion that goes as exp(pole t); it grows where the real part is positive",
    "frozen": "computed with the vehicle of one flight time, as if it stayed so while the wind"
    " blows",
    "varying": "computed with the vehicle as it changes while the wind blows",
    "stop": "the angle beyond which the nozzle cannot turn, in one plane or in both together",
    "gain may fall": "aero margin: how far before the aerodynamic moment wins",
    "gain may rise": "gain margin: how far before the loop becomes unstable",
    "phase": "as a margin: the lag that the loop bears where its gain is one",
    "delay": "as a margin: the delay that the loop bears beside its own",
    "disk": "as a margin: how far gain and phase may change together, the size of a disk",
    "peak of S": "largest factor by which the loop amplifies a disturbance",
    "peak of T": "largest factor from a command, or from sensor noise, to the output",
    "effectiveness": "moment that a degree of deflection makes, over its nominal value",
    "near rest": "motion so small that the nozzle does not meet its stop",
    "slosh": "motion of the liquid in a tank",
    "sounding": "wind over height that one balloon has measured",
    "systematic": "always of one sign: such parts of a total add",
    "random": "of either sign: such parts of a total add by the root of the sum of squares",
    "rank correlation": "from -1 to 1, how strongly the answer follows a parameter",
}
"""The terms of a study and its page."""
