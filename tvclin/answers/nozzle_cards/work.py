"""Torque, power and energy of a moving nozzle, with the contributions of its vehicle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tvclin.answers.nozzle import NozzleData
from tvclin.answers.nozzle_cards.motion import Motion, largest, rms
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.linear.extremes import Point
from tvclin.vehicle.vehicle import Vehicle

AT_REST = 1e-6
"""Fraction of the largest rate below which a rate counts as zero."""


@dataclass(frozen=True)
class Work(Shown):
    """Torque, power and energy of the actuators.

    `torque`: largest torque [N m] while the nozzle turns, with friction. `holding`: largest torque
    [N m] at rest, to which friction adds or takes up to M_f. `rms_torque`: root of the mean square
    [N m] at all times, with friction in motion. `power`: largest power [W] of the actuators.
    `energy`: work of the actuators [J], from which `returned` [J], the work of the nozzle on them,
    is not subtracted.
    `corner_power`: largest torque times largest rate [W], never below the largest power.
    `stiffness`: k + s_E a_x [N m/rad]; with a negative one the nozzle turns away by itself.
    """

    torque: Point
    holding: float
    rms_torque: float
    power: Point
    energy: float
    returned: float
    corner_power: float
    stiffness: float

    as_dict = keyed(
        "torque_N_m=torque.value torque_time_s=torque.time holding_torque_N_m=holding"
        " rms_torque_N_m=rms_torque power_W=power.value power_time_s=power.time"
        " corner_power_W=corner_power energy_J=energy returned_energy_J=returned"
    )


def work_of(motion: Motion, nozzle: NozzleData, vehicle: Vehicle | None) -> tuple[Work, list[str]]:
    """Return torque, power and energy of a motion, and notes on omitted terms.

    See `nozzle_card` for the equation; without a vehicle the nozzle is on a bench.
    """
    engine, weights, rate = nozzle.engine, motion.weights, motion.rate
    inertia, moment = float(engine.inertia_about_gimbal), float(engine.static_moment)
    stiffness, constant, inertial = nozzle.stiffness, 0.0, np.zeros(rate.size)
    notes = []
    if vehicle is None:
        notes.append("without a vehicle the torque is that on a bench: no thrust, no acceleration")
    else:
        mass, thrust = float(vehicle.mass), float(vehicle.thrust)
        a_x = (thrust - float(vehicle.axial_force)) / mass
        force = float(vehicle.normal_force_slope) * motion.angle_of_attack
        force = force + float(vehicle.control_force) * motion.angle
        a_n = force / mass - float(vehicle.control_arm) * motion.swing
        inertial = inertia * motion.swing - moment * a_n
        stiffness += moment * a_x
        constant = float(engine.mass) * a_x * nozzle.offset + thrust * nozzle.thrust_offset
        if stiffness < 0.0:
            notes.append("k + s_E a_x is negative: the nozzle turns away by itself")
    frictionless = inertia * motion.acceleration + stiffness * motion.angle + constant + inertial
    moving = np.abs(rate) > AT_REST * np.abs(rate).max()
    torque = (
        frictionless
        + nozzle.damping * rate
        + np.where(moving, nozzle.friction * np.sign(rate), 0.0)
    )
    power = torque * rate
    moving_torque, resting_torque = (
        np.where(moving, torque, 0.0),
        np.where(moving, 0.0, np.abs(torque)),
    )
    peak, peak_power = largest(moving_torque, motion.at), int(np.argmax(power))
    work = Work(
        torque=peak,
        holding=float(resting_torque.max()),
        rms_torque=rms(torque, weights),
        power=Point(max(float(power[peak_power]), 0.0), float(motion.at[peak_power])),
        energy=float((np.maximum(power, 0.0) * weights).sum()),
        returned=float((np.maximum(-power, 0.0) * weights).sum()),
        corner_power=abs(peak.value) * float(np.abs(rate).max()),
        stiffness=stiffness,
    )
    return work, notes
