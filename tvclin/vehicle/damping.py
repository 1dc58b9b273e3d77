"""Damping of the attitude rate M_q [N m s/rad], from aerodynamic coefficients and from the jet.

    aerodynamic:  M_q = -C_mq q S L^2/(f V),    f = 2 where C_mq is per q L/(2V), 1 where per q L/V
    of the jet:   M_q = m' l_e^2 + I'

C_mq is negative where it damps; the coefficient of the rate of the angle of attack (C_m alpha-dot)
may be added to it. m' is the mass flow, l_e the arm from the centre of gravity aft to the nozzle's
exit, and I' the rate of the moment of inertia, negative while propellant leaves: it takes its own
angular momentum along.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.errors import InputError, finite, nonnegative, one_of, plain, positive, together
from tvclin.base.tables import FileTable

RATES = {"qL/2V": 2.0, "qL/V": 1.0}
"""Reference rates of a damping coefficient, and f: of aircraft and DATCOM, of missiles."""

QUANTITIES = {
    "pitch_damping": "damping moment",
    "pitch_damping_coefficient": "damping coefficient",
    "reference_length": "length",
    "jet_mass_flow": "mass flow",
    "inertia_rate": "inertia rate",
    "exit_arm": "length",
}
"""Kinds of quantity of keys of vehicle files, by name; a coefficient is per q L/V."""


def aerodynamic_damping(
    coefficient: ArrayLike,
    per: str,
    *,
    dynamic_pressure: ArrayLike,
    reference_area: ArrayLike,
    reference_length: ArrayLike,
    velocity: ArrayLike,
) -> Any:
    """Return the aerodynamic damping M_q [N m s/rad], for the `pitch_damping` of `Vehicle`.

    Parameters
    ----------
    coefficient : array_like
        C_mq, zero or negative, about the centre of gravity.
    per : {"qL/2V", "qL/V"}
        Reference rate, q being the attitude rate [rad/s]: tables of aircraft and DATCOM have the
        first, those of missiles mostly the second. They differ by a factor of two.
    dynamic_pressure : array_like
        Dynamic pressure [Pa], positive.
    reference_area, reference_length : array_like
        S [m^2] and L [m] of the coefficient, positive.
    velocity : array_like
        Speed relative to the air [m/s], positive.

    Returns
    -------
    float or ndarray
        M_q [N m s/rad]; the arguments broadcast.

    Raises
    ------
    InputError
        For a positive coefficient (negative damping), another rate, and numbers out of range.

    Examples
    --------
    >>> import tvclin as tv
    >>> air = {"dynamic_pressure": 4e4, "reference_area": 0.02, "velocity": 250.0}
    >>> tv.vehicle.aerodynamic_damping(-50.0, "qL/V", reference_length=0.16, **air)
    4.096
    """
    C = finite("coefficient", coefficient)
    if np.any(C > 0.0):
        raise InputError(
            "the pitch damping coefficient must be zero or negative: C_mq below zero damps; got"
            f" {C.max():.6g}"
        )
    speeds = RATES[one_of("per", per, RATES)]  # 2 of q L/(2 V), 1 of q L/V
    numbers = {
        "dynamic_pressure": positive("dynamic_pressure", dynamic_pressure, "Pa"),
        "reference_area": positive("reference_area", reference_area, "m^2"),
        "reference_length": positive("reference_length", reference_length, "m"),
        "velocity": positive("velocity", velocity, "m/s"),
    }
    together(coefficient=C, **numbers)
    pressure, area, length, speed = numbers.values()
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        damping = np.abs(C) * pressure * area * length**2 / (speeds * speed)
    return plain(finite("the damping of these numbers", damping, "N m s/rad"))


def jet_damping(mass_flow: ArrayLike, exit_arm: ArrayLike, inertia_rate: ArrayLike) -> Any:
    """Return the damping M_q of the jet [N m s/rad], for the `pitch_damping` of `Vehicle`.

    Parameters
    ----------
    mass_flow : array_like
        m' [kg/s], zero or positive.
    exit_arm : array_like
        l_e [m], from the centre of gravity aft to the nozzle's exit, positive.
    inertia_rate : array_like
        I' [kg m^2/s], zero or negative while propellant leaves. Zero gives an upper bound.

    Returns
    -------
    float or ndarray
        M_q [N m s/rad]; the arguments broadcast.

    Raises
    ------
    InputError
        For numbers out of range, and an inertia rate that makes the damping negative.

    Examples
    --------
    >>> import tvclin as tv
    >>> tv.vehicle.jet_damping(2.0, 1.5, inertia_rate=-0.5)
    4.0
    """
    flow = nonnegative("mass_flow", mass_flow, "kg/s")
    arm = positive("exit_arm", exit_arm, "m")
    rate = finite("inertia_rate", inertia_rate, "kg m^2/s")
    together(mass_flow=flow, exit_arm=arm, inertia_rate=rate)
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        damping = finite("the damping of these numbers", flow * arm**2 + rate, "N m s/rad")
    if np.any(damping < 0.0):
        raise InputError(
            "mass_flow times exit_arm squared must be at least what the moment of inertia loses,"
            f" -inertia_rate: the damping would be negative, {damping.min():.6g} N m s/rad (check"
            " the units, and that exit_arm reaches to the nozzle's exit)"
        )
    return plain(damping)


def damping_of(values: Mapping[str, Any], table: FileTable) -> dict[str, Any]:
    """Return the numbers of a vehicle with pitch_damping [N m s/rad] in place of its sources.

    `values`: numbers of `table`, the table [vehicle], in SI units by name: either pitch_damping, or
    an aerodynamic coefficient per q L/V and the numbers of the jet, whose dampings add up. The arm
    of the jet is the control arm unless exit_arm is given.
    """
    coefficient, flow = "pitch_damping_coefficient", "jet_mass_flow"
    sources = [name for name in (coefficient, flow) if name in values]
    # QUANTITIES: names of all numbers of damping, which `Vehicle` does not have
    result = {name: value for name, value in values.items() if name not in QUANTITIES}
    if "pitch_damping" in values:
        if sources:
            raise InputError(
                f"{table.heading} has both pitch_damping and {sources[0]}; keep one"
                " (pitch_damping is that of air and jet together)"
            )
        result["pitch_damping"] = values["pitch_damping"]
    required = {"reference_length": coefficient, "inertia_rate": flow, "exit_arm": flow}
    for name, source in required.items():
        if name in values and source not in values:
            raise InputError(f"{name} in {table.heading} needs {table.spelled(source)} beside it")
    dampings = []
    if coefficient in values:
        names = ("dynamic_pressure", "reference_area", "reference_length", "velocity")
        table.need(values, names)
        air = {name: values[name] for name in names}
        dampings.append(aerodynamic_damping(values[coefficient], "qL/V", **air))
    if flow in values:
        if "inertia_rate" not in values:
            raise InputError(
                f"jet_mass_flow in {table.heading} needs {table.spelled('inertia_rate')}, the rate"
                " of the moment of inertia: negative while propellant leaves, and 0 for an upper"
                " bound of the damping"
            )
        arm = values.get("exit_arm", values["control_arm"])
        dampings.append(jet_damping(values[flow], arm, values["inertia_rate"]))
    return result | ({"pitch_damping": sum(dampings)} if dampings else {})
