"""Flights of 120 s at 50 Hz along a varying vehicle with bending, and sweeps of its margins."""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from peers import PROCESSOR, ratio
from scipy.integrate import solve_ivp

import tvclin as tv
from tvclin.ascent import StructureSchedule
from tvclin.control.autopilot.actuator import plant_with_actuator
from tvclin.control.autopilot.sweep import plants_along
from tvclin.ensembles import Dispersion, Dispersions, FlightPlan
from tvclin.ensembles.campaign.cases import evaluate
from tvclin.vehicle import BendingMode, Filter, SloshTank, Structure

RATE_HZ, LIMIT, RATE = 50.0, 0.1, 0.3
TIMES = np.linspace(0.0, 120.0, 13)
GUST = tv.TriangularWind(peak=np.radians(4.0), duration=8.0).shift(60.0)


@lru_cache
def flight() -> tv.FlightSchedule:
    """A made-up flight with two modes around 20 Hz."""

    def over(first: float, last: float) -> Any:
        return np.linspace(first, last, TIMES.size)

    modes = tuple(
        BendingMode(
            frequency=over(first, last),
            damping=0.005,
            modal_mass=5e4,
            gimbal_displacement=1.0,
            gimbal_slope=-0.068,
            attitude_slope=slope * over(1.0, 1.2),
            rate_slope=0.9 * slope,
        )
        for first, last, slope in ((110.0, 125.0, 0.002), (130.0, 150.0, -0.002))
    )
    tank = SloshTank(
        mass=over(2400.0, 1200.0), station=over(19.9, 16.0), damping=0.02, frequency=3.0
    )
    structure = Structure(bending=modes, slosh=(tank,))
    schedule = StructureSchedule(TIMES, structure, ("first", "second"), ("lox",))
    vehicle = tv.load_vehicle("configuration-i").replace(
        time=TIMES,
        velocity=over(250.0, 900.0),
        weight=over(1.9e6, 1.1e6),
        moment_of_inertia=over(2.8e7, 1.4e7),
        attitude=np.radians(over(80.0, 30.0)),
        aerodynamic_arm=over(11.0, 8.0),
    )
    return tv.FlightSchedule(vehicle, altitude=over(4e3, 4e4), structure=schedule)


@lru_cache
def autopilot() -> tv.control.GainSchedule:
    """Gains by a rule, with a lag, a notch, an actuator and a delay of half a sample."""
    plants = flight().plants(TIMES, "drift-exact", "pitch")
    gains = tv.control.GainSchedule.design(
        TIMES,
        plants.coefficients,
        tv.design_gains,
        natural_frequency=1.1,
        damping=0.7,
        actuator=tv.Actuator(),
        delay=0.01,
    )
    filters = (Filter.low_pass(40.0, 0.7), Filter.notch(115.0, 0.1, 0.6))
    return replace(gains, autopilot=replace(gains.autopilot, filters=filters, sample_rate=RATE_HZ))


@lru_cache
def tables() -> Any:
    """Matrices of vehicle and actuator at even times, for a solver."""
    times = np.linspace(0.0, 120.0, 241)
    plants = plants_along(flight(), times, "drift-exact", "pitch")
    return plant_with_actuator(plants, tv.Actuator())


def solved(seconds: float) -> Any:
    """The sampled loop without its filters, in a solver that starts anew with each command."""
    moving, gains = tables(), autopilot().autopilot
    x, command, h = np.zeros(len(moving.states)), 0.0, 1.0 / RATE_HZ

    def slope(t: float, x: Any, c: float) -> Any:
        k, part = divmod(2.0 * t, 1.0)
        A, B = ((1.0 - part) * m[int(k)] + part * m[int(k) + 1] for m in (moving.A, moving.B))
        return A @ x + B[:, 0] * c + B[:, 2] * float(GUST(t))

    options = {"method": "LSODA", "rtol": 1e-6, "atol": 1e-9}
    for k in range(int(seconds * RATE_HZ)):
        t, row = 62.0 + k * h, moving.C[int(2.0 * (62.0 + k * h))]
        sensed = dict(zip(moving.outputs, row @ x, strict=True))
        asked = float(np.interp(t, TIMES, gains.attitude_gain)) * sensed["attitude"]
        asked += float(np.interp(t, TIMES, gains.rate_gain)) * sensed["attitude_rate"]
        x = solve_ivp(slope, (t, t + 0.5 * h), x, args=(command,), **options).y[:, -1]
        command = min(max(asked, -LIMIT), LIMIT)
        x = solve_ivp(slope, (t + 0.5 * h, t + h), x, args=(command,), **options).y[:, -1]
    return x


@pytest.mark.parametrize("flights", [1, 1000])
def test_seconds_of_a_flight_beside_lsoda(benchmark: Any, flights: int) -> None:
    limits = np.linspace(0.05, LIMIT, flights)

    def ours() -> Any:
        options = {"deflection_limit": limits, "rate_limit": RATE}
        return tv.flights.fly_many_along(flight(), autopilot(), GUST, **options)

    ratio(
        benchmark,
        ours,
        lambda: solved(0.2),
        peer_name="solve_ivp LSODA from command to command, no filters",
        per=120.0 * flights,
        peer_per=0.2,
        floor="matrices of some 150 times, then one sample after the other",
        clock=PROCESSOR,
    )


def test_seconds_of_flights_of_different_vehicles_beside_lsoda(benchmark: Any) -> None:
    spread = Dispersions(
        (
            Dispersion("thrust", "normal", 0.01),
            Dispersion("normal_force_slope", "normal", 0.05),
            Dispersion("bending_1_frequency", "uniform", 0.05),
        )
    )
    campaign = tv.Campaign(
        vehicle=flight().at(64.0),
        wind=tv.ShapedWind("triangular", np.radians(4.0), 8.0),
        dispersions=spread,
        cases=1000,
        outputs=("flight",),
        nozzle=tv.Nozzle(limit=LIMIT, rate_limit=RATE),
        along=FlightPlan(flight(), autopilot(), start=0.0),
        sign="head",
    )
    ratio(
        benchmark,
        lambda: evaluate(campaign, 0, 20),
        lambda: solved(0.2),
        peer_name="solve_ivp LSODA from command to command, no filters",
        per=120.0 * 20,
        peer_per=0.2,
        floor="matrices of some 200 times of each vehicle, and their interpolation",
        clock=PROCESSOR,
    )


def test_seconds_of_flights_in_soundings_beside_lsoda(benchmark: Any) -> None:
    height = np.linspace(0.0, 4.5e4, 451)
    jet = -40.0 * np.exp(-(((height - 1.1e4) / 3e3) ** 2))
    rough = 0.6 * np.cumsum(np.random.default_rng(1).normal(size=(20, height.size)), axis=1)
    soundings = [
        tv.fly_through(
            tv.WindProfile(height=height, east=east, north=5.0 * np.sin(height / 3e3)),
            flight(),
            azimuth=np.pi / 2,
        )
        for east in jet + rough
    ]
    limits = {"deflection_limit": LIMIT, "rate_limit": RATE}
    ratio(
        benchmark,
        lambda: tv.flights.fly_many_along(flight(), autopilot(), soundings, **limits),
        lambda: solved(0.2),
        peer_name="solve_ivp LSODA from command to command, no filters",
        per=120.0 * len(soundings),
        peer_per=0.2,
        floor="interpolation of the matrices of each sample in time and dynamic pressure",
        clock=PROCESSOR,
    )


def test_a_sweep_of_100_times_beside_times_by_themselves(benchmark: Any) -> None:
    times = np.linspace(1.0, 119.0, 100)
    ratio(
        benchmark,
        lambda: tv.control.sweep(flight(), autopilot(), times),
        lambda: tv.control.sweep(flight(), autopilot(), times[:1]),
        peer_name="one time",
        per=times.size,
        floor="linear equations at each frequency for crossovers, with six detuned loops each",
        clock=PROCESSOR,
    )
