"""Torque, power and energy of a nozzle that moves, with what its vehicle adds."""

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
"""A rate below this part of the largest is none."""


@dataclass(frozen=True)
class Work(Shown):
    """What the actuators give.

    `torque` is the largest [N m] while the nozzle turns, with friction; `holding` that at rest, to
    which friction adds or takes up to M_f; the root of the mean square includes it. `power` is the
    largest [W] that is given, `energy` [J] what is given, of which what the nozzle gives back,
    `returned`, is not taken off. `corner_power` [W] is the largest torque times the largest rate,
    never below the largest power. `stiffness` is k + s_E a_x [N m/rad] at the least; below zero the
    nozzle turns away by itself.
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
    """Return torque, power and energy of a motion, and what is left out of them.

    See `nozzle_card` for the equation; without a vehicle the nozzle is on a bench.
    """
    engine, weights, rate = nozzle.engine, motion.weights, motion.rate
    inertia, moment = float(engine.inertia_about_gimbal), float(engine.static_moment)
    stiffness, steady, felt = nozzle.stiffness, 0.0, np.zeros(rate.size)
    notes = []
    if vehicle is None:
        notes.append("without a vehicle the torque is that on a bench: no thrust, no acceleration")
    else:
        mass, thrust = float(vehicle.mass), float(vehicle.thrust)
        ahead = (thrust - float(vehicle.axial_force)) / mass
        force = float(vehicle.normal_force_slope) * motion.angle_of_attack
        force = force + float(vehicle.control_force) * motion.angle
        aside = force / mass - float(vehicle.control_arm) * motion.swing
        felt = inertia * motion.swing - moment * aside
        stiffness += moment * ahead
        steady = float(engine.mass) * ahead * nozzle.offset + thrust * nozzle.thrust_offset
        if stiffness < 0.0:
            notes.append("k + s_E a_x is negative: the nozzle turns away by itself")
    held = inertia * motion.acceleration + stiffness * motion.angle + steady + felt
    moves = np.abs(rate) > AT_REST * np.abs(rate).max()
    torque = held + nozzle.damping * rate + np.where(moves, nozzle.friction * np.sign(rate), 0.0)
    power = torque * rate
    turning, resting = np.where(moves, torque, 0.0), np.where(moves, 0.0, np.abs(torque))
    most, given = largest(turning, motion.at), int(np.argmax(power))
    found = Work(
        torque=most,
        holding=float(resting.max()),
        rms_torque=rms(torque, weights),
        power=Point(max(float(power[given]), 0.0), float(motion.at[given])),
        energy=float((np.maximum(power, 0.0) * weights).sum()),
        returned=float((np.maximum(-power, 0.0) * weights).sum()),
        corner_power=abs(most.value) * float(np.abs(rate).max()),
        stiffness=stiffness,
    )
    return found, notes
