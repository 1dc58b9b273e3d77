"""Every public figure with one good call, for the same hostile values as of `tests/doors.py`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import tvclin as tv
from tests.doors import Door, hasty
from tvclin import plots
from tvclin.requirement.study_tables import study_response


def figures(folder: Path) -> dict[str, Door]:
    """Return the figures by name; files that they write are in the folder."""
    vehicle = tv.load_vehicle("configuration-i")
    coefficients = tv.Coefficients.from_vehicle(vehicle)
    plant = tv.Plant.from_coefficients(coefficients, "drift-exact")
    wind = tv.TriangularWind(peak=0.09, duration=7.5)
    autopilot = tv.control.canonical_gains(coefficients)
    lagging = tv.control.canonical_gains(coefficients, actuator=tv.Actuator())
    limit = float(tv.boundary_limit(plant, wind).deflection)
    constant = tv.trim_then_hold(plant, wind, limit)
    response = tv.attitude_response(plant, constant, wind, np.linspace(0.0, 15.0, 16))
    study = tv.Study.from_vehicle(vehicle, duration=7.5, peak=0.09, limit=0.014)
    slanting = tv.Study.from_vehicle(vehicle, duration=7.5, peak=0.09, limit=0.014, heading=1.0)
    schedule = tv.load_schedule("configuration-i", start=60.0, stop=90.0, step=10.0)
    sizing = tv.size(schedule, wind, times=[66.0, 76.0])
    west = tv.WindProfile(height=[0.0, 12e3, 40e3], east=[0.0, 60.0, 0.0], north=[0.0, 0.0, 1.0])
    archive = tv.winds.Soundings.from_profiles([west, west], ["2024-02-01T00", "2024-02-01T12"])
    available = tv.availability(
        tv.load_schedule("configuration-i", step=5.0), archive, limit=0.01, azimuth=1.5
    )
    beside = tv.flights.compare_flight(
        vehicle, tv.flights.ReportControl(), wind, [0.0, 4.0, 8.0], deflection_limit=0.01
    )
    law = tv.SaturatedLaw(autopilot)
    flown = [
        tv.flights.flown_margins(plant, law, wind, limit=one, sample_rate=20.0)
        for one in (0.03, 0.04)
    ]
    mapped = tv.flights.boundary_map(
        plant, law, wind, np.array([0.8, 1.0, 1.25]), np.array([0.0, 0.1]), sample_rate=20.0
    )
    gains = hasty(tv.minimum_deflection_gains)(plant=plant, winds=wind, actuator=tv.Actuator())
    minimum = hasty(tv.design.gain_trade_off)(gains=gains, disk_margin=[0.1, 0.2])
    load = tv.boundary.load_trade_off(plant, wind, limit=0.014, load=0.05)
    rate = tv.boundary.rate_trade_off(plant, wind, limit=0.014, rate_limit=0.05)
    gusty = tv.control.turbulence_covariance(autopilot, plant, tv.winds.Turbulence(6.0), 540.0)
    compared = tv.compare_with_trim(plant, autopilot, wind)
    curves = plots.flight_curves(beside, 0.01, "fly", "few")
    loop: dict[str, Any] = {"autopilot": lagging, "plant": plant}
    responses: dict[str, Any] = {
        "dead_band": 0.5, "tau_beta": (2.0, 4.0), "factors": (0.9, 1.0), "until": 1.0, "points": 11,
    }  # fmt: skip
    titles = {"name": "attitude", "title": "Attitude"}
    report = {
        f"figure_{k}": Door(getattr(plots, f"figure_{k}"), dict(responses))
        for k in range(3, 10)
        if k != 5
    }
    for k in range(6, 10):
        report[f"figure_{k}"].good["vehicle"] = "configuration-i"
    return report | {
        "Column": Door(
            plots.Column,
            {"label": "a", "values": np.ones(3), "unit": "deg", "panel": "b", "note": "c"},
        ),
        "Curves": Door(
            plots.Curves,
            {
                "name": "a",
                "parameters": "b",
                "abscissa_label": "c",
                "abscissa": np.arange(3.0),
                "columns": (plots.Column("a", np.ones(3)),),
            },
        ),
        "Curves.column": Door(
            curves.column, {"label": curves.columns[0].label, "panel": curves.columns[0].panel}
        ),
        "attitude_chart": Door(
            plots.attitude_chart, {"plant": plant, **responses, **titles, "flights": None}
        ),
        "availability_chart": Door(
            plots.availability_chart, {"availability": available, "name": "a"}
        ),
        "bode_chart": Door(plots.bode_chart, loop),
        "boundary_chart": Door(
            plots.boundary_chart,
            {"tau_beta": [2.0, 4.0], "dead_bands": (1.0, 0.5), "coefficients": coefficients},
        ),
        "boundary_map_chart": Door(
            plots.boundary_map_chart, {"boundary_map": mapped, "limit": 0.03}
        ),
        "comparison_chart": Door(plots.comparison_chart, {"comparison": compared}),
        "curves_of": Door(plots.curves_of, {"plot": plots.sketch_a()}),
        "figure_1": Door(
            plots.figure_1,
            {
                "attitude_deg": 60.0,
                "flight_path_deg": 30.0,
                "wind_deg": 12.0,
                "deflection_deg": 1.0,
            },
        ),
        "figure_2": Door(plots.figure_2, {"tau_beta": [2.0, 4.0], "dead_bands": (1.0, 0.5)}),
        "figure_5": Door(
            plots.figure_5,
            {
                "tau_beta": [2.0, 4.0],
                "dead_bands": (1.0,),
                "vehicles": ("configuration-i", vehicle),
            },
        ),
        **{
            f"figure_{k}": Door(
                getattr(plots, f"figure_{k}"),
                {
                    "vehicle": "configuration-i",
                    "dead_bands": (1.0,),
                    "tau_beta": (2.0,),
                    "along": 2.0,
                    "engine": "planar",
                },
            )
            for k in (10, 11)
        },
        "flight_chart": Door(plots.flight_chart, {"curves": curves, "title": "a"}),
        "flight_curves": Door(
            plots.flight_curves,
            {
                "flight": beside,
                "limit": 0.01,
                "name": "a",
                "parameters": "b",
                "reference": "linear",
            },
        ),
        "flown_margins_chart": Door(plots.flown_margins_chart, {"flown_margins": flown}),
        "laws_chart": Door(
            plots.laws_chart,
            {
                "plant": plant,
                "laws": {"trim": tv.TrimLaw(plant)},
                "peak": 0.09,
                "tau_beta": [2.0, 3.0],
                "sample_rate": 20.0,
            },
        ),
        "gain_trade_off_chart": Door(plots.gain_trade_off_chart, {"trade_offs": [minimum]}),
        "load_chart": Door(plots.load_chart, {"trade_off": load, "flown": (), "title": "a"}),
        "load_curves": Door(plots.load_curves, {"trade_off": load, "flown": ()}),
        "nichols_chart": Door(plots.nichols_chart, {**loop, "criteria": tv.CRITERIA["classic"]}),
        "nyquist_chart": Door(plots.nyquist_chart, loop),
        "spectrum_chart": Door(plots.spectrum_chart, {"covariance": gusty, "title": "a"}),
        "spectrum_curves": Door(plots.spectrum_curves, {"covariance": gusty}),
        "plane_chart": Door(
            plots.plane_chart,
            {
                "plant": plant,
                "wind": tv.winds.PlaneWind.veering(wind, 0.3, 0.1),
                "limit_shape": "round",
                "dead_band": 0.5,
                "yaw_plant": plant,
            },
        ),
        "pole_map": Door(plots.pole_map, {"coefficients": coefficients, "models": ("drift",)}),
        "rate_chart": Door(plots.rate_chart, {"trade_off": rate, "title": "a"}),
        "rate_curves": Door(plots.rate_curves, {"trade_off": rate}),
        "response_chart": Door(
            plots.response_chart, {"response": response, "title": "a", "limit": 0.01, "across": 2}
        ),
        "response_curves": Door(
            plots.response_curves,
            {
                "response": response,
                "name": "a",
                "parameters": "b",
                "limit": 0.01,
                "deflection": constant,
                "wind": wind,
            },
        ),
        "root_locus_chart": Door(plots.root_locus_chart, {**loop, "gains": [0.5, 1.0]}),
        "save_figure": Door(
            lambda plot, path: plots.save_figure(plots.sketch_a() if plot is GOOD else plot, path),
            {"plot": GOOD, "path": folder / "a.svg"},
        ),
        "deflection_use_chart": Door(
            plots.deflection_use_chart,
            {
                "use": tv.requirement.deflection_use(
                    sizing, tv.flights.fly_along(schedule, lagging, wind.shift(62.0)), 0.02
                ),
                "name": "made up",
            },
        ),
        "flight_along_chart": Door(
            plots.flight_along_chart,
            {
                "flown": tv.flights.fly_along(schedule, lagging, wind.shift(62.0)),
                "limit": 0.02,
                "name": "made up",
            },
        ),
        "sweep_chart": Door(
            plots.sweep_chart,
            {
                "sweep": tv.control.sweep(schedule, lagging, [60.0, 70.0]),
                "name": "made up",
            },
        ),
        "sizing_chart": Door(plots.sizing_chart, {"sizing": sizing, "limit": 0.01, "name": "a"}),
        "sketch_a": Door(plots.sketch_a, {"tau_beta": 4.0}),
        "sketch_b": Door(plots.sketch_b, {"tau_beta": 4.0, "dead_band": 0.5}),
        "sketch_c": Door(plots.sketch_c, {"ratios": (0.1,), "highest": 5.0, "points": 11}),
        "step_chart": Door(plots.step_chart, loop),
        "study_chart": Door(plots.study_chart, {"study": study, "durations": [5.0, 7.5]}),
        "study_response_chart": Door(
            plots.study_response_chart, {"response": study_response(study)}
        ),
        "study_planes_chart": Door(plots.study_planes_chart, {"study": slanting}),
        "vehicle_chart": Door(plots.vehicle_chart, {"vehicle": vehicle, "limit": 0.01}),
        "wind_chart": Door(plots.wind_chart, {**loop, "wind": wind}),
    }


GOOD = object()
"""Stands for a figure that is drawn anew, since it is closed once it is saved."""
