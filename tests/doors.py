"""Every public name of the package with one good call, and values that no argument expects."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from functools import wraps
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

import tvclin as tv
from tests.schedules import rocketpy_standin
from tests.schedules.samples import FOLDER as SCHEDULES
from tests.schedules.samples import MAP
from tvclin.ascent.nominal_flight import load_flight_condition
from tvclin.base.public_names import CHAPTERS
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.gain_table import GainTable
from tvclin.design import minimum_gains, worst_case
from tvclin.flights.closed_loop import fly_planes as in_step
from tvclin.linear.system import LinearSystem
from tvclin.requirement.flight.total import Line

SOUNDINGS = Path(__file__).parent / "soundings"

ANSWERS = {
    "DeflectionUse",
    "FlightAlong",
    "Largest",
    "EqualValues",
    "Sweep",
    "SurvivalFraction",
    "Today",
    "BoundaryLimit",
    "BoundaryMap",
    "AutopilotRequirements",
    "ClosedLoopBoundary",
    "Crossings",
    "DispersedStudy",
    "FlownBoundary",
    "FlownCases",
    "FlownMargin",
    "FlownMargins",
    "FlownPlaneLimit",
    "FlownPlanes",
    "FlownLoad",
    "ForecastFreeLimit",
    "GainTradeOff",
    "LawTrial",
    "MinimumGains",
    "MinimumGainSchedule",
    "FinalMotion",
    "LoadTradeOff",
    "MarginBounds",
    "Margins",
    "ModeBand",
    "Modes",
    "NozzleDuty",
    "Optimum",
    "PlaneLimit",
    "PlaneOptimum",
    "RateTradeOff",
    "RateLimitedOptimum",
    "RequiredDeflection",
    "RigidBand",
    "Measurement",
    "TrimComparison",
    "Verdict",
    "Worst",
    "WorstCase",
    "WorstDuration",
}
"""What the package alone makes, and what has no door: fields to be read."""

NO_CALLS = {
    "CRITERIA",
    "CircularShape",
    "History",
    "InputError",
    "Law",
    "LimitShape",
    "list_vehicles",
}
"""A table, a stop and a function without an argument, three abstract classes, and an exception."""

INSIDE = {
    "Availability",
    "BandMargins",
    "CampaignResults",
    "ControllabilityRatio",
    "CovarianceHistory",
    "Detuned",
    "FlightComparison",
    "FlightDuty",
    "FlightTurbulence",
    "Loads",
    "LoopCovariance",
    "LoopInTurbulence",
    "RangeReference",
    "Responses",
    "SimulatedFlight",
    "Sizing",
    "Study",
    "TurbulenceFlights",
}
"""Answers whose methods are doors, but not their making."""

BARE = {
    "table",  # of an answer, for who shows it
    "deflections",
    "demand",  # of laws, for every sample of every flight
    "parts",
    "take",
    "aliases",
    "w_to_s",
    "s_to_w",  # of the arithmetic that a loop stands on
    "case",
    "cases",
    "some",
    "attitude_fractions",
    "altitude_text",
    "deviates",
    "history",
    "chosen",
    "designed",
}
"""Methods for the innermost loops of the package, which check nothing."""


TOLD = {
    "all_modes": (".deflection_residues", ".wind_residues"),
    "unstable_modes": (".deflection_residues", ".wind_residues"),
    "triangle_error": ("",),
    "single_pole_validity": ("",),
    "judge": (".final_motion.offset", ".final_motion.rate"),
    "DeflectionTotal": (".needed_rate",),
    "compare_with_trim": (".peak_flight_path_angle",),
    "compare_flight": (".flown", ".linear"),
    "fly_turbulence": (".limited_time", ".limited_time_error"),
    "deflection_use": (".remaining", ".used"),
}
"""Where NaN is the answer, as the docstrings say: of poles that are repeated or not there, and of a
flight that is lost."""


def public() -> dict[str, Any]:
    """Return what stands at the doors of the package and of its chapters, but figures, by name."""
    doors = [tv, *(getattr(tv, chapter) for chapter in CHAPTERS if chapter != "plots")]
    return {name: getattr(door, name) for door in doors for name in door.__all__}


class Door(NamedTuple):
    """A public name, and arguments with which it answers."""

    call: Callable[..., Any]
    good: dict[str, Any]


def hasty(call: Callable[..., Any]) -> Callable[..., Any]:
    """The same search with few points or samples: what it takes and refuses is the same."""

    @wraps(call)
    def run(**arguments: Any) -> Any:
        few = {"per_round": 4, "rounds": 1}
        with (
            patch.dict(minimum_gains._LINEAR_SEARCH, few),
            patch.dict(minimum_gains._FLOWN_SEARCH, few),
            patch.dict(minimum_gains._STOPPED_SEARCH, few),
            patch.dict(minimum_gains._REFINEMENT, few),
            patch.dict(worst_case._SEARCH_OPTIONS, few),
            patch.object(minimum_gains, "_BOX_POINTS", 64),
            patch.object(in_step, "_MAX_SAMPLES_AFTER_WIND", 2000),
            patch.object(worst_case, "_INTERIOR_POINTS", 8),
        ):
            return call(**arguments)

    return run


def doors(folder: Path) -> dict[str, Door]:
    """Return the doors by name; files that they write are in the folder."""
    # Short names, since the table below is long.
    slow = tv.load_vehicle("configuration-i")
    # of a tenth of the inertia: flights and their waiting are three times shorter
    booster = slow.replace(moment_of_inertia=0.1 * slow.moment_of_inertia)
    coefficients = tv.Coefficients.from_vehicle(booster)
    plant = tv.Plant.from_coefficients(coefficients, "fixed-path")
    exact = tv.Plant.from_coefficients(coefficients, "drift-exact")
    gains_in_steps = LinearSystem(
        *(np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((1, 0)), np.array([[0.4, 0.5]])),
        ("attitude", "attitude_rate"),
        ("deflection_command",),
        (),
        np.asarray(0.02),
    )
    wind = tv.TriangularWind(peak=0.09, duration=2.5)
    limit = float(tv.boundary_limit(plant, wind).deflection)
    constant = tv.trim_then_hold(plant, wind, limit)
    gust = tv.OneMinusCosineGust(peak=0.01, duration=1.0)
    autopilot = tv.control.canonical_gains(coefficients)
    actuator = tv.Actuator()
    law = tv.TrimLaw(plant)
    margins = autopilot.margins(plant)
    condition = load_flight_condition("configuration-i")
    schedule = tv.load_schedule("configuration-i", step=5.0)
    west = tv.WindProfile(height=[0.0, 9e3, 4e4], east=[0, 30, 0], north=[0, 0, 0])
    encountered = tv.fly_through(west, schedule, azimuth=np.pi / 2)
    study = tv.Study.from_vehicle(booster, duration=7.5, peak=0.09, limit=0.01, model="fixed-path")
    west = tv.WindProfile(height=[0.0, 12e3, 40e3], east=[0.0, 60.0, 0.0], north=[0.0, 0.0, 1.0])
    calm = tv.WindProfile(height=[0.0, 40e3], east=[0.0, 5.0], north=[0.0, 0.0])
    archive = tv.winds.Soundings.from_profiles([west, west], ["2024-02-01T00", "2024-02-01T12"])
    available = tv.availability(schedule, archive, limit=0.01, azimuth=1.5)
    days_asked = tv.ensembles.AvailabilityRequest(flight=schedule, soundings=archive, azimuth=1.5)
    months = tv.winds.read_range_reference(SOUNDINGS / "T1cap19.txt")[:1]
    climb = tv.winds.steady_climb(booster, height=11950.0, start=53.0, stop=79.0)
    dispersions = tv.Dispersions((tv.Dispersion("thrust", "truncated", 0.01),))
    shaped = tv.ShapedWind("triangular", 0.09, 7.5)
    slanting = tv.ShapedWind("triangular", 0.09, 7.5, heading=1.0)
    campaign = tv.Campaign(vehicle=booster, wind=shaped, dispersions=dispersions, cases=8, chunk=4)
    done = folder / "done"
    results = tv.run_campaign(campaign, done)
    sizing = tv.size(schedule, wind, times=[60.0, 66.0])
    request = tv.requirement.SizingRequest(schedule=schedule, every=30.0)
    along = request.turbulence(study.case, tv.case.TurbulenceRequest(intensity=6.0))
    once = tv.requirement.SizingRequest(schedule=schedule, start=66.0, stop=66.0)
    carded = tv.Case(vehicle=booster, nozzle=tv.Nozzle(limit=0.02))
    sampled = tv.SampledWind(time=[50.0, 60.0, 70.0], angle=[0.0, 0.09, 0.0])
    modes = folder / "modes.csv"
    modes.write_text(
        "time_s,name,frequency_rad_per_s,damping,modal_mass_kg,gimbal_displacement,"
        "gimbal_slope_per_m,attitude_slope_per_m,rate_slope_per_m\n"
        "40,first,20,0.005,5e5,1,-0.06,0.02,0.02\n120,first,30,0.005,4e5,1,-0.06,0.02,0.02\n"
    )
    bends = tv.ascent.load_structure(modes)
    bent = dataclasses.replace(schedule, structure=bends)
    mode_notch = tv.control.ModeNotch(mode="first", zero_damping=0.1, pole_damping=0.6)
    two = tv.control.GainSchedule([40.0, 90.0], autopilot)
    estimator = tv.control.WindEstimator(bandwidth=10.0)
    beside = tv.flights.compare_flight(
        booster, tv.flights.ReportControl(), wind, [0.0, 5.0], deflection_limit=0.01, boundary=0.006
    )
    responses = tv.attitude_responses(plant, constant, wind, [0.0, 5.0])
    line = Line("wind tunnel", 0.001)
    times = [0.0, 5.0, 20.0]
    poles = {"natural_frequency": 1.0, "damping": 0.7}
    veering = tv.winds.PlaneWind.veering(wind, 0.3, 0.1)
    severe = tv.winds.Turbulence.mil_f_8785c("severe")
    noise = {"times": [0.0, 0.5, 1.0], "speed": [530.0, 540.0, 550.0], "altitude": 9000.0}
    noise |= {"seed": 3, "first": 2, "runs": 2}
    gusty = {"autopilot": tv.Autopilot(attitude_gain=0.3, rate_gain=0.5, actuator=actuator)}
    gusty |= {"plant": plant, "turbulence": severe, "speed": 540.0, "altitude": 9000.0}
    gusty |= {"noise": tv.control.SensorNoise(1e-5), "loads": tv.control.LoadSlopes(3e4)}
    spread = tv.control.turbulence_covariance(**gusty)
    gusty_flight = tv.control.turbulence_history(**gusty, duration=2.0)
    of_output = {"output": "deflection"}
    square, ellipse = tv.boundary.SquareShape(), tv.boundary.EllipticShape(1.0, 0.5)
    kite = tv.boundary.PolygonShape([1.0, 1.0j, -1.0, -1.0j])
    engines = [tv.boundary.ClusterEngine(at=at) for at in (1.0, 1.0j, -1.0)]
    three = tv.boundary.Cluster(engines)
    stops = {
        "LimitShape": square,
        "CircularShape": tv.boundary.CircularShape(),
        "EllipticShape": ellipse,
        "PolygonShape": kite,
        "Cluster": three,
    }
    drifting = {"tau_beta": 4.0, "dead_band": 0.5, "beta": 0.5, "b1": 0.02, "b2": -0.01}
    planes = {"plant": exact, "wind": veering, "limit_shape": ellipse, "yaw_plant": exact}
    lateral = {"drift_rate_gain": 1e-4, "drift_gain": 0.0, "acceleration_gain": 1e-3}
    lateral |= {"acceleration_station": 2.0, "accelerometer_bandwidth": 80.0}
    options = {"actuator": actuator, "delay": 0.01, "integral_gain": 0.0, "pade_order": 2}
    hardware = {"rate_limit": 1.0, "actuator": actuator}
    history = {"plant": plant, "wind": wind}
    hinge = tv.case.NozzleData(engine=tv.vehicle.Engine(mass=2000.0, arm=1.0))
    both = {"plant": plant, "deflection": constant, "wind": wind}
    study_file, campaign_file = folder / "study.toml", folder / "campaign.toml"
    study_file.write_text(
        '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
    )
    sizing_file = folder / "size.toml"
    sizing_file.write_text(study_file.read_text() + "[size]\nevery_s = 30\n")
    campaign_file.write_text(
        '[campaign]\nvehicle = "configuration-i"\ncases = 8\n'
        '[wind]\npeak_deg = 5\nduration_s = 7.5\n[[dispersion]]\nparameter = "thrust"\n'
        'shape = "normal"\npercent = 1\n'
    )

    turbulence_file = folder / "turbulence.csv"
    turbulence_file.write_text("altitude_km,intensity_m_per_s,length_m\n0,2,200\n12,5,533\n")
    system_file = folder / "system.npz"
    tv.linear.write_system(gains_in_steps, system_file)

    def run_anew(folder: Any = None, **others: Any) -> Any:
        given = mkdtemp(dir=done.parent) if folder is NEW else folder
        return tv.run_campaign(folder=given, **others)

    pulse = {"peak": 0.09, "duration": 7.5}
    span = {"start": 0.5, "stop": 5.0, "max_rows": 50}
    simulated = {"gimbal_station": 2.95, "ground": 0.0, **span}
    bending = {"frequency": 13.6, "damping": 0.005, "modal_mass": 5.1e4}
    bending |= {"gimbal_displacement": 1.0, "gimbal_slope": -0.068, "attitude_slope": 0.27}
    bending |= {"rate_slope": 0.25, "pressure_displacement": -0.43, "drift_displacement": 0.9}
    bending |= {"accelerometer_displacement": 0.9, "accelerometer_slope": 0.25}
    bending |= {"tank_displacements": (0.25,), "tank_slopes": (0.17,)}
    sloshing = {"mass": 2400.0, "station": 19.9, "damping": 0.01, "pendulum_length": 2.1}
    swinging = {"mass": 700.0, "arm": 1.4, "moment_of_inertia": 2e3}
    structure = tv.Structure(
        bending=(tv.vehicle.BendingMode(**bending),),
        slosh=(tv.vehicle.SloshTank(**sloshing),),
        engine=tv.vehicle.Engine(**swinging),
        rate_gyro=tv.vehicle.Filter.low_pass(120.0, 0.7),
    )
    rising = tv.Plant.from_vehicle(booster)
    flexible = tv.FlexiblePlant.from_vehicle(booster, structure, "drift-exact")
    notch = tv.vehicle.Filter.notch(32.0, 0.06, 0.6)
    steered = tv.Autopilot(attitude_gain=0.36, rate_gain=0.56, actuator=actuator, filters=(notch,))
    easy = tv.control.Criteria.custom(aero_margin_dB=1.0)
    sought = {"winds": wind, "criteria": easy, "actuator": actuator, "delay": 0.02}
    result = hasty(tv.minimum_deflection_gains)(plant=plant, **sought)
    detuned = {"autopilot": steered, "plant": flexible, "factors": [1.1]}
    of_stops = {
        f"{name}.{method}": Door(getattr(stop, method), {argument: [1.0, 0.5 + 1.0j]})
        for name, stop in stops.items()
        for method, argument in (
            ("support", "direction"),
            ("gauge", "vector"),
            ("farthest", "direction"),
        )
        if name != "Cluster" or method == "support"
    }
    return {
        **of_stops,
        "LimitShape.reach": Door(three.reach, {"angle": [0.0, 0.5]}),
        "LimitShape.inscribed": Door(square.inscribed, {"sides": 8}),
        "EllipticShape": Door(tv.boundary.EllipticShape, {"pitch": 1.0, "yaw": 0.5}),
        "PolygonShape": Door(tv.boundary.PolygonShape, {"corners": kite.corners}),
        "SquareShape": Door(tv.boundary.SquareShape, {"rotation": 0.3}),
        "ClusterEngine": Door(
            tv.boundary.ClusterEngine,
            {"at": 1.0, "share": 1.0, "limit_shape": ellipse, "state": "stuck", "deflection": 0.1},
        ),
        "Cluster": Door(tv.boundary.Cluster, {"engines": engines, "hold_roll": True}),
        "Cluster.offset": Door(three.offset, {"control_arm": 20.0}),
        "PlaneWind": Door(tv.winds.PlaneWind, {"pitch": wind, "yaw": gust}),
        "PlaneWind.__call__": Door(veering, {"t": [0.0, 1.0]}),
        "PlaneWind.component": Door(veering.component, {"angle": 0.3}),
        "PlaneWind.remaining_integral": Door(veering.remaining_integral, {"s": 0.5, "t": 1.0}),
        "PlaneWind.towards": Door(tv.winds.PlaneWind.towards, {"wind": wind, "angle": 0.3}),
        "PlaneWind.veering": Door(
            tv.winds.PlaneWind.veering, {"wind": wind, "angle": 0.3, "rate": 0.1}
        ),
        "Turbulence": Door(
            tv.winds.Turbulence,
            {
                "intensity": [3.0, 6.0],
                "length": 533.4,
                "spectrum": "von-karman",
                "component": "along",
                "altitude": [0.0, 9000.0],
                "cutoff_wavelength": 800.0,
            },
        ),
        "Turbulence.mil_f_8785c": Door(
            tv.winds.Turbulence.mil_f_8785c,
            {
                "exceedance": 1e-4,
                "spectrum": "dryden",
                "component": "along",
                "wind_at_20_ft": 10.0,
            },
        ),
        "fly_turbulence": Door(
            tv.ensembles.fly_turbulence,
            {
                **{name: gusty[name] for name in ("plant", "turbulence", "speed", "altitude")},
                "autopilot": dataclasses.replace(gusty["autopilot"], sample_rate=25.0),
                "duration": 10.0,
                "deflection_limit": 0.1,
                "rate_limit": 1.0,
                "wind": wind,
                "runs": 2,
                "seed": 1,
            },
        ),
        "fly_turbulence_along": Door(
            tv.ensembles.fly_turbulence_along,
            {
                "schedule": schedule,
                "autopilot": dataclasses.replace(gusty["autopilot"], sample_rate=25.0),
                "turbulence": severe,
                "deflection_limit": 0.1,
                "rate_limit": 1.0,
                "model": "drift-exact",
                "plane": "pitch",
                "start": 60.0,
                "stop": 64.0,
                "wind": wind,
                "runs": 2,
                "seed": 1,
            },
        ),
        "LoadSlopes": Door(
            tv.control.LoadSlopes,
            {
                "dynamic_pressure": 3e4,
                "alpha_moment": 2e7,
                "deflection_moment": -1e7,
                "bandwidth": 6.0,
            },
        ),
        "SensorNoise": Door(tv.control.SensorNoise, {"attitude": 1e-4, "rate": 2e-4}),
        "turbulence_covariance": Door(tv.control.turbulence_covariance, gusty),
        "turbulence_history": Door(
            tv.control.turbulence_history,
            {**gusty, "duration": 5.0, "wind": wind, "settled": False},
        ),
        "turbulence_along": Door(
            tv.control.turbulence_along,
            {
                "schedule": schedule,
                "autopilot": autopilot,
                "turbulence": severe,
                "model": "drift-exact",
                "plane": "pitch",
                "start": 60.0,
                "stop": 64.0,
                "wind": wind,
                "structure": None,
                "noise": None,
                "loads": None,
            },
        ),
        **{
            f"LoopCovariance.{name}": Door(getattr(spread, name), values)
            for name, values in {
                "rms": of_output,
                "quantile": {"probability": 0.99, **of_output},
                "mean_absolute_rate": of_output,
                "crossing_rate": {"limit": 0.01, **of_output},
                "probability_of_none": {"limit": 0.01, "duration": 30.0, **of_output},
                "exceedance": {"limit": 0.01, **of_output},
                "spectrum": {"omega": [0.5, 2.0], **of_output},
            }.items()
        },
        **{
            f"CovarianceHistory.{name}": Door(getattr(gusty_flight, name), values)
            for name, values in {
                "mean": of_output,
                "deviation": of_output,
                "largest": {"sigmas": 3.0, **of_output},
                "travel": of_output,
                "travel_deviation": of_output,
                "exceedance": {"limit": 0.01, **of_output},
                "time_fraction": {"limit": 0.01, **of_output},
                "crossings": {"limit": 0.01, **of_output},
                "crossing_rate": {"limit": 0.01, **of_output},
                "probability_of_none": {"limit": 0.01, **of_output},
                "quantile": {"probability": 0.99, **of_output},
            }.items()
        },
        "TurbulenceRequest": Door(
            tv.case.TurbulenceRequest,
            {
                "intensity": None,
                "severity": "light",
                "exceedance": None,
                "altitude": 9000.0,
                "length": 500.0,
                "spectrum": "dryden",
                "component": "along",
                "cutoff_wavelength": 600.0,
                "sigmas": None,
                "probability": 0.99,
                "table": None,
            },
        ),
        "LoopInTurbulence.of": Door(
            tv.case.LoopInTurbulence.of,
            {
                "request": tv.case.TurbulenceRequest(intensity=6.0),
                "vehicle": booster,
                "plant": plant,
                "autopilot": gusty["autopilot"],
                "wind": wind,
                "limit": 0.02,
                "altitude": 9000.0,
                "load": tv.case.LoadBound(load=0.05),
            },
        ),
        "LoadBound.at_pressure": Door(tv.case.LoadBound(load=0.05).at_pressure, {"ratio": 1.2}),
        "TurbulenceRequest.at": Door(
            tv.case.TurbulenceRequest(severity="light").at, {"altitude": 9000.0}
        ),
        "Turbulence.at": Door(severe.at, {"altitude": 9000.0}),
        "Turbulence.over": Door(severe.over, {"altitude": [9000.0, 9500.0]}),
        "Turbulence.shaping_filter": Door(
            severe.shaping_filter, {"speed": 540.0, "altitude": 9000.0}
        ),
        "Turbulence.power_spectrum": Door(
            severe.power_spectrum, {"omega": [0.5, 2.0], "speed": 540.0, "altitude": 9000.0}
        ),
        "Turbulence.remaining_variance": Door(severe.remaining_variance, {"altitude": 9000.0}),
        "Turbulence.samples": Door(severe.samples, noise),
        "Turbulence.winds": Door(severe.winds, noise),
        "WindProfile.to_winds": Door(west.to_winds, {"flight": climb, "azimuth": 1.0}),
        "plane_limit": Door(tv.plane_limit, {**planes, "dead_band": 0.5, "switch": "literal"}),
        "plane_optimum": Door(tv.boundary.plane_optimum, planes),
        "Actuator": Door(tv.Actuator, {"natural_frequency": 25.0, "damping": 0.7}),
        "BandMargins.mode": Door(steered.band_margins(flexible).mode, {"name": "slosh 1"}),
        "BendingMode": Door(tv.vehicle.BendingMode, bending),
        "Engine": Door(tv.vehicle.Engine, swinging),
        "SloshTank": Door(tv.vehicle.SloshTank, {**sloshing, "frequency": None}),
        "Structure": Door(
            tv.Structure,
            {
                "bending": structure.bending,
                "slosh": structure.slosh,
                "engine": structure.engine,
                "attitude_sensor": None,
                "rate_gyro": structure.rate_gyro,
                "thrust_follows": True,
            },
        ),
        "AsymmetricTriangularWind": Door(
            tv.winds.AsymmetricTriangularWind, {**pulse, "peak_time": 2.0}
        ),
        "Autopilot": Door(
            tv.Autopilot,
            {
                "attitude_gain": 0.2,
                "rate_gain": 0.2,
                "alpha_gain": 0.0,
                **options,
                **lateral,
                "filters": steered.filters,
                "attitude_filters": (),
                "rate_filters": steered.filters,
                "sample_rate": 25.0,
            },
        ),
        "Autopilot.band_margins": Door(steered.band_margins, {"plant": flexible}),
        "Autopilot.exact_loop": Door(steered.exact_loop, {"plant": flexible}),
        "Autopilot.wind_response": Door(autopilot.wind_response, history),
        "Autopilot.close": Door(autopilot.close, {"plant": plant}),
        "Autopilot.closed_loop_poles": Door(autopilot.closed_loop_poles, {"plant": plant}),
        "Autopilot.frequency_response": Door(
            autopilot.frequency_response, {"plant": plant, "omega": [0.5, 2.0]}
        ),
        "Autopilot.wind_response_function": Door(
            lambda plant, wind: autopilot.wind_response_function(plant)(wind), history
        ),
        "Autopilot.deflection_peaks_function": Door(
            lambda plant, winds: autopilot.deflection_peaks_function(plant)(winds),
            {"plant": plant, "winds": [history["wind"]]},
        ),
        "Autopilot.loop": Door(autopilot.loop, {"plant": plant}),
        "Autopilot.margins": Door(autopilot.margins, {"plant": plant}),
        "Autopilot.rational_loop": Door(autopilot.rational_loop, {"plant": plant}),
        "Autopilot.respond": Door(autopilot.respond, {**history, "timepts": times}),
        "Availability.curve": Door(available.curve, {"limits": [0.01, 0.02]}),
        "Availability.placard": Door(available.placard, {"fractions": [0.5]}),
        "Availability.reaches": Door(available.reaches, {"fraction": 0.5}),
        "Availability.to_csv": Door(available.to_csv, {"path": folder / "available.csv"}),
        "Availability.today": Door(available.today, {"profile": west}),
        "Availability.with_limit": Door(available.with_limit, {"limit": 0.01}),
        "AvailabilityRequest": Door(
            tv.ensembles.AvailabilityRequest,
            {
                "flight": schedule,
                "soundings": archive,
                "azimuth": 1.5,
                "plane": "pitch",
                "persistence": 0.001,
                "known_to": 20e3,
                "confidence": 0.9,
                "least_part": 0.9,
                "gust_speed": 9.0,
            },
        ),
        "AvailabilityRequest.availability": Door(
            days_asked.availability, {"case": study.case, "azimuth": None, "progress": None}
        ),
        "BangBang": Door(
            tv.linear.BangBang, {"limit": 0.01, "switch_times": [1.0, 2.0], "start": 0.0}
        ),
        "Campaign": Door(
            tv.Campaign,
            {
                **{f.name: getattr(campaign, f.name) for f in dataclasses.fields(campaign)},
                "until": 0.1,
                "outputs": ("required", "flight"),
                "law": "trim",
                "nozzle": tv.Nozzle(limit=0.01),
                "design": tv.AutopilotDesign(natural_frequency=1.0),
            },
        ),
        "Case": Door(
            tv.Case,
            {
                "vehicle": booster,
                "model": "drift",
                "plane": "yaw",
                "wind": slanting,
                "nozzle": tv.Nozzle(limit=0.01),
                "design": tv.AutopilotDesign(),
                "plant_system": exact.system,
                "controller": gains_in_steps,
                "sign": "frozen",
            },
        ),
        "Case.wind_at": Door(tv.Case(vehicle=booster, wind=slanting).wind_at, {"dead_band": 0.5}),
        "Case.history_at": Door(
            tv.Case(vehicle=booster, wind=slanting).history_at, {"dead_band": 0.5}
        ),
        "Case.directions": Door(tv.Case(vehicle=booster).directions, {"plane": "yaw"}),
        "Case.wind_in_plane_at": Door(
            tv.Case(vehicle=booster, wind=slanting).wind_in_plane_at, {"dead_band": 0.5}
        ),
        "Case.placed_wind": Door(
            tv.Case(vehicle=booster, wind=slanting).placed_wind, {"dead_band": 0.5}
        ),
        "FlightPlan": Door(
            tv.ensembles.FlightPlan,
            {
                "flight": schedule,
                "autopilot": dataclasses.replace(autopilot, sample_rate=20.0),
                "start": 60.0,
                "stop": 75.0,
            },
        ),
        "SoundingEnsemble": Door(
            tv.ensembles.SoundingEnsemble,
            {"time": [0.0, 1.0], "angle": [[0.0, 0.1]], "soundings": ()},
        ),
        "SoundingEnsemble.of": Door(
            tv.ensembles.SoundingEnsemble.of, {"soundings": (encountered,)}
        ),
        "Campaign.span": Door(campaign.span, {"chunk": 1}),
        "CampaignResults.answers": Door(results.answers, {"output": results.angles[0]}),
        "CampaignResults.column": Door(results.column, {"name": "thrust"}),
        "CampaignResults.convergence": Door(
            results.convergence,
            {"output": results.angles[0], "probability": 0.9, "confidence": 0.9},
        ),
        "CampaignResults.drivers": Door(results.drivers, {"output": results.angles[0]}),
        "CampaignResults.loss": Door(results.loss, {"confidence": 0.9}),
        "CampaignResults.quantile": Door(
            results.quantile,
            {"output": results.angles[0], "probability": 0.5, "confidence": 0.5},
        ),
        "CampaignResults.read": Door(tv.ensembles.CampaignResults.read, {"folder": done}),
        "CampaignResults.replay": Door(results.replay, {"case": 3}),
        "CampaignResults.success": Door(
            results.success, {"limit": 0.01, "output": results.angles[0], "confidence": 0.9}
        ),
        "CampaignResults.to_csv": Door(results.to_csv, {"path": folder / "campaign.csv"}),
        "CampaignResults.survival": Door(results.survival, {"confidence": 0.9}),
        "CampaignResults.worst": Door(results.worst, {"count": 2, "output": results.angles[0]}),
        "Climb": Door(
            tv.winds.Climb,
            {
                "time": [0.0, 1.0],
                "height": [0.0, 100.0],
                "speed": [100.0, 100.0],
                "flight_path_angle": [1.0, 1.0],
            },
        ),
        "LinearVehicle": Door(
            tv.vehicle.LinearVehicle,
            {"coefficients": coefficients, "name": "Mine", "path_known": True},
        ),
        "LinearVehicle.coefficients_for": Door(
            tv.vehicle.LinearVehicle(coefficients=coefficients).coefficients_for,
            {"model": "fixed-path"},
        ),
        "Coefficients": Door(
            tv.Coefficients,
            {
                "mu_alpha": 0.3,
                "mu_delta": 2.6,
                "C1": 0.1,
                "C2": 0.0,
                "b1": 0.1,
                "b2": 0.1,
                "q": 0.0,
                "damping": 0.03,
                "velocity": 400.0,
                "name": "Booster",
            },
        ),
        "Coefficients.from_beta": Door(
            tv.Coefficients.from_beta, {"beta": 0.53, "B": 0.1, "C1": 0.0}
        ),
        "Coefficients.from_vehicle": Door(
            tv.Coefficients.from_vehicle, {"vehicle": booster, "plane": "yaw"}
        ),
        "Coefficients.replace": Door(coefficients.replace, {"mu_alpha": 0.3}),
        "Criteria": Door(
            tv.control.Criteria,
            {
                "name": "own",
                "limits": tv.CRITERIA["classic"].limits,
                "base": tv.CRITERIA["aircraft"],
            },
        ),
        "Criteria.are_satisfied": Door(tv.CRITERIA["classic"].are_satisfied, {"margins": margins}),
        "Criteria.with_limits": Door(
            tv.CRITERIA["classic"].with_limits, {"source": "us", "phase_margin_deg": 20.0}
        ),
        "Criteria.judge": Door(tv.CRITERIA["classic"].judge, {"margins": margins}),
        "Criteria.custom": Door(
            tv.control.Criteria.custom, {"name": "own", "source": "us", "phase_margin_deg": 20.0}
        ),
        "EstimatedLaw": Door(
            tv.control.EstimatedLaw, {"law": law, "estimator": estimator, "plant": plant}
        ),
        "FilteredLaw": Door(
            tv.control.FilteredLaw,
            {
                "law": law,
                "filters": (notch,),
                "attitude_filters": (notch,),
                "rate_filters": (notch,),
            },
        ),
        "DeadBandLaw": Door(
            tv.control.DeadBandLaw, {"plant": plant, "gain": 1.0, "dead_band": 0.5}
        ),
        "DeflectionTotal.words_with": Door(
            tv.requirement.DeflectionTotal((line,), 0.1).words_with, {"autopilot": "SURVIVED"}
        ),
        "DeflectionTotal": Door(
            tv.requirement.DeflectionTotal,
            {
                "lines": (line,),
                "reserve": 0.1,
                "limit": 0.01,
                "time": 66.0,
                "not_sized": ("above 12 km",),
                "rate_limit": 0.1,
                "needed_rate": 0.05,
                "end": "the first of the schedule: more may be needed before",
                "listed": (65.0, 70.0),
                "counted": "K = 1",
            },
        ),
        "Dispersion": Door(
            tv.Dispersion,
            {"parameter": "thrust", "shape": "normal", "spread": 0.1, "relative": True},
        ),
        "Dispersions": Door(
            tv.Dispersions, {"distributions": dispersions.distributions, "correlation": ((1.0,),)}
        ),
        "Dispersions.apply": Door(
            dispersions.apply, {"nominal": {"thrust": 1e6}, "numbers": [[0.4], [0.6]]}
        ),
        "Document": Door(
            tv.studyfile.Document,
            {"project": "Booster 1", "author": "A", "date": "2026-01-31", "revision": "B"},
        ),
        "Document.from_table": Door(tv.studyfile.Document.from_table, {"table": {"revision": "B"}}),
        "Earth": Door(tv.flights.Earth, {"latitude": 0.5, "heading": 1.5, "altitude": 12e3}),
        "SystemPlant": Door(
            tv.linear.SystemPlant,
            {
                "system": exact.ss(),
                "coefficients": coefficients,
                "inputs": exact.inputs,
                "outputs": exact.outputs,
            },
        ),
        "SystemPlant.with_effectiveness": Door(
            tv.linear.SystemPlant(exact.ss()).with_effectiveness, {"factor": 1.1}
        ),
        "lateral_plant": Door(
            tv.linear.lateral_plant, {"plant": rising, "station": 2.0, "position": True}
        ),
        "SystemPlant.lateral_rows": Door(
            tv.linear.SystemPlant(exact.ss(), rising.coefficients).lateral_rows,
            {"signal": "drift_rate", "station": 2.0},
        ),
        "SystemPlant.lateral_numerator": Door(
            tv.linear.SystemPlant(exact.ss(), rising.coefficients).lateral_numerator,
            {"signal": "drift_rate", "input": "wind", "station": 2.0},
        ),
        "SystemPlant.numerator": Door(
            tv.linear.SystemPlant(exact.ss()).numerator, {"output": "attitude", "input": "wind"}
        ),
        "FlexiblePlant": Door(
            tv.FlexiblePlant,
            {"vehicle": booster, "structure": structure, "model": "fixed-path", "plane": "yaw"},
        ),
        "FlexiblePlant.from_vehicle": Door(
            tv.FlexiblePlant.from_vehicle,
            {"vehicle": booster, "structure": structure, "model": "drift-exact", "plane": "pitch"},
        ),
        "FlexiblePlant.lateral_rows": Door(
            flexible.lateral_rows, {"signal": "acceleration", "station": 2.0}
        ),
        "FlexiblePlant.with_effectiveness": Door(flexible.with_effectiveness, {"factor": 1.1}),
        "Filter": Door(tv.vehicle.Filter, {"numerator": [1.0], "denominator": [1.0, 0.5]}),
        "Filter.__call__": Door(tv.vehicle.Filter.notch(32.0, 0.06, 0.6), {"s": [0.0, 1.0 + 2.0j]}),
        "Filter.from_coefficients": Door(
            tv.vehicle.Filter.from_coefficients, {"numerator": [1.0], "denominator": [1.0, 0.5]}
        ),
        "Filter.lead_lag": Door(tv.vehicle.Filter.lead_lag, {"zero": -3.0, "pole": 5.0}),
        "Filter.low_pass": Door(tv.vehicle.Filter.low_pass, {"frequency": 13.0, "damping": 0.95}),
        "Filter.notch": Door(
            tv.vehicle.Filter.notch, {"frequency": 32.0, "zero_damping": 0.06, "pole_damping": 0.6}
        ),
        "FlightComparison.in_unknown_wind": Door(beside.in_unknown_wind, {}),
        "FlightComparison.peaks": Door(beside.peaks, {"name": "attitude"}),
        "FlightSchedule": Door(
            tv.FlightSchedule,
            {
                "vehicle": booster.replace(time=[60.0, 70.0]),
                "nominal_deflection": [0.0, 0.0],
                "altitude": [1e4, 1.1e4],
                "notes": ("made up",),
                "structure": bends,
                "actuator_frequency": [24.0, 28.0],
                "actuator_damping": 0.7,
            },
        ),
        "FlightSchedule.actuator_at": Door(schedule.actuator_at, {"time": 66.0}),
        "StructureSchedule": Door(
            tv.ascent.StructureSchedule,
            {
                "times": [40.0, 120.0],
                "structure": bends.structure,
                "modes": ("first",),
                "tanks": (),
                "notes": ("made up",),
            },
        ),
        "StructureSchedule.at": Door(bends.at, {"time": 66.0}),
        "StructureSchedule.mode_number": Door(bends.mode_number, {"name": "first"}),
        "load_structure": Door(
            tv.ascent.load_structure, {"source": modes, "common": tv.Structure()}
        ),
        "FlightSchedule.at": Door(schedule.at, {"time": 66.0}),
        "FlightSchedule.between": Door(schedule.between, {"start": 60.0, "stop": 70.0}),
        "FlightSchedule.from_flight": Door(
            tv.FlightSchedule.from_flight,
            {
                "vehicle": booster,
                "condition": condition,
                "start": 60.0,
                "stop": 70.0,
                "step": 5.0,
            },
        ),
        "FlightSchedule.clamped_at": Door(schedule.clamped_at, {"time": 66.0, "rigid": True}),
        "FlightSchedule.plants": Door(
            schedule.plants, {"time": 66.0, "model": "drift", "plane": "yaw"}
        ),
        "FlightSchedule.to_csv": Door(schedule.to_csv, {"path": folder / "schedule.csv"}),
        "FlightSchedule.nominal_at": Door(schedule.nominal_at, {"time": 66.0}),
        "GainSchedule": Door(
            tv.control.GainSchedule,
            {
                "breakpoints": [40.0, 90.0],
                "autopilot": autopilot,
                "variable": "time",
                "notches": (mode_notch,),
            },
        ),
        "GainSchedule.at": Door(two.at, {"value": 66.0}),
        "GainSchedule.along": Door(two.along, {"flight": bent, "time": 66.0}),
        "ModeNotch": Door(
            tv.control.ModeNotch,
            {"mode": "first", "zero_damping": 0.1, "pole_damping": 0.6, "ratio": 1.0},
        ),
        "ModeNotch.at": Door(mode_notch.at, {"flight": bent, "time": 66.0}),
        "flight_variable": Door(
            tv.ascent.flight_variable, {"flight": schedule, "variable": "mach", "time": 66.0}
        ),
        "sweep": Door(
            tv.control.sweep,
            {
                "flight": bent,
                "autopilot": two,
                "times": [60.0, 66.0],
                "criteria": tv.control.CRITERIA["classic"],
                "factors": [0.9],
                "model": "drift-exact",
                "plane": "pitch",
            },
        ),
        "Sweep.time_table": Door(
            tv.control.sweep(bent, two, times=[60.0, 66.0]).time_table, {"rows": 2}
        ),
        "fly_along": Door(
            tv.flights.fly_along,
            {
                "flight": schedule,
                "autopilot": dataclasses.replace(autopilot, sample_rate=20.0),
                "wind": sampled,
                "deflection_limit": 0.1,
                "rate_limit": 0.5,
                "sign": "head",
                "gust_time": None,
                "start": 60.0,
                "stop": 70.0,
                "model": "drift-exact",
                "plane": "pitch",
                "alpha_moment": 1e6,
                "deflection_moment": 0.0,
            },
        ),
        "fly_planes_along": Door(
            tv.flights.fly_planes_along,
            {
                "flight": schedule,
                "autopilot": dataclasses.replace(autopilot, sample_rate=20.0),
                "wind": tv.winds.PlaneWind.veering(wind.shift(60.0), 0.3, 0.1),
                "deflection_limit": 0.1,
                "limit_shape": ellipse,
                "rate_limit": 0.5,
                "sign": "frozen",
                "gust_time": None,
                "start": 60.0,
                "stop": 70.0,
                "model": "drift-exact",
            },
        ),
        "fly_many_along": Door(
            tv.flights.fly_many_along,
            {
                "flight": schedule,
                "autopilot": dataclasses.replace(autopilot, sample_rate=20.0),
                "wind": sampled,
                "deflection_limit": [0.1],
                "rate_limit": 0.5,
                "sign": "head",
                "start": 60.0,
                "stop": 70.0,
                "model": "drift-exact",
                "plane": "pitch",
            },
        ),
        "survival_limit_along": Door(
            tv.flights.survival_limit_along,
            {
                "flight": schedule,
                "autopilot": dataclasses.replace(autopilot, sample_rate=20.0),
                "wind": wind.shift(62.0),
                "rate_limit": 0.5,
                "sign": "head",
                "gust_time": None,
                "start": 60.0,
                "stop": 75.0,
                "model": "drift-exact",
                "plane": "pitch",
                "highest": 2.0,
            },
        ),
        "autopilot_requirements": Door(
            tv.requirement.autopilot_requirements,
            {
                "sizing": tv.size(schedule, wind, times=[66.0]),
                "autopilot": dataclasses.replace(autopilot, sample_rate=20.0),
                "winds": wind,
                "rate_limit": 0.5,
                "sign": "head",
                "placing": "peak",
                "window": 20.0,
                "progress": lambda done, total: None,
            },
        ),
        "FlightAlong.largest": Door(
            tv.flights.fly_along(schedule, autopilot, sampled, start=55.0, stop=75.0).largest,
            {"output": "attitude"},
        ),
        "deflection_use": Door(
            tv.requirement.deflection_use,
            {
                "sizing": sizing,
                "flown": tv.flights.fly_along(schedule, autopilot, sampled, start=55.0, stop=75.0),
                "limit": 0.02,
                "requirements": None,
                "labels": None,
            },
        ),
        "equal_values": Door(
            tv.control.equal_values,
            {
                "flight": schedule,
                "variable": "dynamic_pressure",
                "times": [60.0, 66.0],
                "autopilot": autopilot,
            },
        ),
        "GainSchedule.design": Door(
            tv.control.GainSchedule.design,
            {
                "breakpoints": [40.0, 90.0],
                "coefficients": coefficients,
                "rule": tv.design_gains,
                "variable": "time",
                **poles,
            },
        ),
        "drift_gains": Door(
            tv.control.drift_gains,
            {
                "plant": rising,
                "natural_frequency": 1.2,
                "damping": 0.7,
                "drift_frequency": 0.1,
                "drift_damping": 0.8,
                **options,
            },
        ),
        "steady_drift": Door(tv.control.steady_drift, {"autopilot": steered, "plant": rising}),
        "GainSchedule.to_csv": Door(two.to_csv, {"path": None}),
        "GainSchedule.margins": Door(two.margins, {"plants": plant}),
        "AutopilotDesign": Door(
            tv.AutopilotDesign,
            {
                "design": "canonical",
                "natural_frequency": 1.0,
                "damping": 0.7,
                "drift_frequency": 0.1,
                "drift_damping": 0.8,
                "alpha_weight": 0.5,
                "drift_rate_weight": 0.5,
                "drift_weight": 0.5,
                "attitude_gain": 0.2,
                "rate_gain": 0.2,
                "alpha_gain": 0.1,
                "integral_gain": 0.0,
                **lateral,
                "delay": 0.0,
                "crossover": 5.0,
                "minimum": "peak",
                "sudden_ends": 1,
                "filters": (notch,),
                "attitude_filters": (notch,),
                "rate_filters": (notch,),
                "sample_rate": 50.0,
                "schedule": GainTable(notches=(mode_notch,)),
            },
        ),
        "AutopilotDesign.options": Door(
            tv.AutopilotDesign(design="canonical").options, {"actuator": tv.Actuator()}
        ),
        "AutopilotDesign.from_table": Door(
            tv.AutopilotDesign.from_table,
            {"table": {"attitude_gain": 0.2, "rate_gain_s": 0.2}, "folder": folder},
        ),
        "AutopilotDesign.autopilot": Door(
            tv.AutopilotDesign(design="canonical").autopilot,
            {"plant": plant, "actuator": tv.Actuator()},
        ),
        "ConstantDeflection": Door(tv.linear.ConstantDeflection, {"limit": 0.01, "start": 0.0}),
        "History.__call__": Door(wind, {"t": [0.0, 1.0]}),
        "History.before": Door(wind.before, {"time": 5.0}),
        "History.filter": Door(wind.filter, {"numerator": [1.0], "denominator": [1.0, 0.5]}),
        "History.remaining_integral": Door(wind.remaining_integral, {"s": 0.5, "t": 1.0}),
        "History.remaining_integral_of": Door(wind.remaining_integral_of, {"s": 0.5}),
        "History.laplace": Door(wind.laplace, {"s": 0.5}),
        "History.laplace_magnitude": Door(wind.laplace_magnitude, {"s": 0.5}),
        "History.probe_times": Door(wind.probe_times, {"between": 4}),
        "History.shift": Door(wind.shift, {"dt": 1.0}),
        "LawsRequest": Door(
            tv.design.LawsRequest,
            {
                "names": ("trim",),
                "winds": ("triangle",),
                "sample_rate": 50.0,
                "cuts": 1,
            },
        ),
        "minimum_deflection_gains": Door(
            hasty(tv.minimum_deflection_gains),
            {
                "plant": plant,
                **sought,
                "gains": ("attitude", "rate"),
                "crossover": 20.0,
                "filters": (),
                "attitude_filters": (),
                "rate_filters": (),
                "limits": False,
                "stops": 0,
                "sample_rate": 50.0,
            },
        ),
        "minimum_gain_schedule": Door(
            hasty(tv.design.minimum_gain_schedule),
            {
                "time": [66.0, 70.0],
                "plants": tv.Plant(coefficients.replace(q=[0.0, 0.0]), "fixed-path"),
                **sought,
            },
        ),
        "gain_trade_off": Door(
            hasty(tv.design.gain_trade_off), {"gains": result, "disk_margin": [0.1, 0.2]}
        ),
        "margin_bounds": Door(
            tv.control.margin_bounds, {"plant": plant, "actuator": actuator, "delay": 0.02}
        ),
        "worst_case": Door(
            hasty(tv.worst_case),
            {
                "subject": booster,
                "autopilot": autopilot,
                "box": {"delay": (0.0, 0.01), "wind_peak": (0.05, 0.09)},
                "model": "fixed-path",
                "plane": "pitch",
                "wind": shaped,
                "dead_band": 1.0,
            },
        ),
        "LayeredGust": Door(tv.winds.LayeredGust, {"peak": 0.09, "blend": 1.0, "plateau": 2.0}),
        "Loop": Door(tv.Loop, {"numerator": [1.0], "denominator": [1.0, 1.0], "delay": 0.1}),
        "Loop.analysis": Door(tv.Loop([1.0], [1.0, 1.0]).analysis, {"delays": False}),
        "Loop.from_matrices": Door(
            tv.Loop.from_matrices,
            {"A": [[-1.0]], "B": [[1.0]], "C": [[2.0]], "D": 0.0, "delay": 0.1},
        ),
        "Loop.from_system": Door(
            tv.Loop.from_system, {"system": autopilot.loop(plant), "delay": 0.1}
        ),
        "Loop.response": Door(tv.Loop([1.0], [1.0, 1.0]).response, {"omega": [0.5, 2.0]}),
        "MeasuredWind": Door(
            tv.ascent.MeasuredWind,
            {
                "wind": sampled,
                "window": 20.0,
                "gust": gust,
                "notes": ("calm",),
                "speeds": None,
                "gaps": encountered.gaps,
            },
        ),
        "MeasuredWind.__call__": Door(tv.ascent.MeasuredWind(sampled), {"vehicle": booster}),
        "MeasuredWind.samples": Door(tv.ascent.MeasuredWind(sampled).samples, {"vehicle": booster}),
        "MeasuredWind.of_both_signs": Door(
            tv.ascent.MeasuredWind(sampled).of_both_signs, {"vehicle": booster}
        ),
        "Nozzle": Door(
            tv.Nozzle,
            {
                "limit": 0.01,
                "limit_shape": "square",
                "rate_limit": 0.2,
                "actuator": tv.Actuator(),
                "data": hinge,
                "acceleration_limit": 1.0,
                "travel_limit": 1.0,
                "torque_limit": 1e4,
                "power_limit": 1e3,
            },
        ),
        "Nozzle.from_table": Door(tv.Nozzle.from_table, {"table": {"limit_deg": 1.0}}),
        "OneMinusCosineGust": Door(tv.OneMinusCosineGust, pulse),
        "plant_of": Door(
            tv.linear.plant_of, {"vehicle": booster, "model": "fixed-path", "plane": "yaw"}
        ),
        "Plant": Door(tv.Plant, {"coefficients": coefficients, "model": "drift-exact"}),
        "Plant.from_coefficients": Door(
            tv.Plant.from_coefficients, {"coefficients": coefficients, "model": "drift"}
        ),
        "Plant.from_vehicle": Door(
            tv.Plant.from_vehicle, {"vehicle": booster, "model": "drift", "plane": "yaw"}
        ),
        "Plant.numerator": Door(exact.numerator, {"output": "attitude", "input": "wind"}),
        "Plant.lateral_numerator": Door(
            rising.lateral_numerator, {"signal": "drift_rate", "input": "wind", "station": 2.0}
        ),
        "Plant.lateral_rows": Door(rising.lateral_rows, {"signal": "acceleration", "station": 2.0}),
        "Plant.with_effectiveness": Door(exact.with_effectiveness, {"factor": 1.1}),
        "Plant.tf": Door(exact.tf, {"output": "attitude", "input": "wind"}),
        "RangeReference.component": Door(months[0].component, {"percentile": 95.0, "azimuth": 1.5}),
        "RangeReference.profile": Door(months[0].profile, {"percentile": 95.0, "azimuth": 1.5}),
        "RangeReference.speed": Door(months[0].speed, {"percentile": 95.0}),
        "RecoverableAttitudeLaw": Door(
            tv.RecoverableAttitudeLaw,
            {
                "plant": plant,
                "reach": 0.9,
                "gain": 10.0,
                "design_peak": 0.09,
                "trust": 0.8,
                "dead_band": 0.0,
                "rate_limit": 0.01,
                "estimator": estimator,
            },
        ),
        "PairGrowth": Door(tv.ensembles.PairGrowth, {"hours": 3.5, "quantile": 0.95}),
        "RectangularWind": Door(tv.RectangularWind, pulse),
        "Requirement": Door(
            tv.requirement.Requirement,
            {"quantity": "dead band", "dead_band": 0.5, "varying": True, "direction": "head"},
        ),
        "ReportControl": Door(tv.flights.ReportControl, {"dead_band": 0.5}),
        "Responses.__getitem__": Door(lambda label: responses[label], {"label": "attitude"}),
        "SampledWind": Door(tv.SampledWind, {"time": [0.0, 1.0], "angle": [0.1, 0.0]}),
        "AccelerometerLaw": Door(
            tv.control.AccelerometerLaw,
            {
                "autopilot": tv.control.half_relief_gains(slow),
                "vehicle": slow,
                "station": 5.0,
                "bandwidth": 100.0,
                "plane": "pitch",
            },
        ),
        "SaturatedLaw": Door(tv.SaturatedLaw, {"autopilot": autopilot}),
        "SaturatedLaw.of": Door(tv.SaturatedLaw.of, {"autopilot": autopilot}),
        "SystemAutopilot": Door(
            tv.control.SystemAutopilot,
            {
                "system": gains_in_steps,
                "inputs": ("attitude", "attitude_rate"),
                **dict.fromkeys(GAINS, 0.0),
                "actuator": tv.Actuator(),
                "delay": 0.01,
                "pade_order": 4,
                "filters": (),
                "attitude_filters": (),
                "rate_filters": (),
                "acceleration_station": 0.0,
                "accelerometer_bandwidth": 100.0,
                "sample_rate": 50.0,
            },
        ),
        "read_system": Door(tv.linear.read_system, {"source": system_file}),
        "write_system": Door(
            tv.linear.write_system, {"system": gains_in_steps, "path": folder / "written.mat"}
        ),
        "SystemLaw": Door(
            tv.control.SystemLaw, {"autopilot": tv.control.SystemAutopilot(gains_in_steps)}
        ),
        "ShapedWind": Door(
            tv.ShapedWind,
            {
                "shape": "triangular",
                **pulse,
                "heading": 1.0,
                "gust": gust,
                "gust_at": 3.0,
                "speed": 40.0,
                "gust_speed": 9.0,
            },
        ),
        "ShapedWind.scaled": Door(slanting.scaled, {"factor": 0.9}),
        "ShapedWind.gust_history": Door(
            tv.ShapedWind("triangular", 0.09, 7.5, gust=gust).gust_history,
            {"values": {"wind_duration": 7.0}},
        ),
        "ShapedWind.with_gust_speed": Door(
            tv.ShapedWind("triangular", 0.09, 7.5, gust=gust).with_gust_speed,
            {"speed": 20.0, "vehicle": slow, "plane": "pitch"},
        ),
        "ShapedWind.for_vehicle": Door(
            tv.ShapedWind("triangular", 0.09, 7.5).with_speed(20.0, slow, "pitch").for_vehicle,
            {"vehicle": slow, "plane": "yaw"},
        ),
        "ShapedWind.in_plane": Door(slanting.in_plane, {"plane": "pitch", "attitude": 0.8}),
        "ShapedWind.in_planes": Door(
            slanting.in_planes, {"values": {"wind_peak": 0.08}, "attitude": 0.8}
        ),
        "ShapedWind.with_speed": Door(
            shaped.with_speed, {"speed": 20.0, "vehicle": slow, "plane": "pitch"}
        ),
        "ShapedWind.peaks": Door(slanting.peaks, {"attitude": 0.8}),
        "Sizing.at_times": Door(sizing.at_times, {"name": "K = 1"}),
        "Sizing.not_sized": Door(sizing.not_sized, {"name": "K = 1"}),
        "Sizing.arising": Door(sizing.arising, {"name": "K = 1"}),
        "Sizing.worst_in": Door(sizing.worst_in, {"wind": sizing.winds[0]}),
        "Sizing.to_csv": Door(sizing.to_csv, {"path": folder / "sizing.csv"}),
        "SizingRequest": Door(
            tv.requirement.SizingRequest,
            {
                **{f.name: getattr(request, f.name) for f in dataclasses.fields(request)},
                "others": (shaped,),
                "soundings": {"west": tv.requirement.SoundingRequest(west, 1.5)},
                "window": 20.0,
                "start": 60.0,
                "stop": 70.0,
                "peak_speed": 40.0,
                "count": "K = 1",
                "rate_noise": 1e-4,
            },
        ),
        "SizingRequest.at": Door(request.at, {"case": study.case, "time": 66.0, "pulse": shaped}),
        "SizingRequest.counted": Door(request.counted, {"sizing": sizing, "sign": "head"}),
        "SizingRequest.pulses": Door(request.pulses, {"case": study.case}),
        "SizingRequest.sizing": Door(request.sizing, {"case": study.case, "progress": None}),
        "SizingRequest.times": Door(request.times, {"case": study.case}),
        "SizingRequest.total": Door(
            request.total,
            {"case": study.case, "sizing": request.sizing(study.case), "turbulence": None},
        ),
        "SizingRequest.turbulence": Door(
            request.turbulence,
            {"case": study.case, "turbulence": tv.case.TurbulenceRequest(intensity=6.0)},
        ),
        "SizingRequest.winds": Door(request.winds, {"case": study.case}),
        "Soundings": Door(
            tv.winds.Soundings,
            {f.name: getattr(archive, f.name) for f in dataclasses.fields(archive)},
        ),
        "Soundings.__getitem__": Door(lambda index: archive[index], {"index": slice(1)}),
        "Soundings.from_profiles": Door(
            tv.winds.Soundings.from_profiles,
            {"profiles": [west], "times": ["2024-02-01"], "station": "X"},
        ),
        "Soundings.with_utc_offset": Door(archive.with_utc_offset, {"utc_offset": -5.0}),
        "Soundings.select": Door(archive.select, {"month": 2, "year": 2024, "hour": 0}),
        "SoundingRequest": Door(
            tv.requirement.SoundingRequest, {"profile": west, "azimuth": 1.5, "bias": calm}
        ),
        "Study.from_vehicle": Door(
            tv.Study.from_vehicle,
            {
                "vehicle": booster,
                "wind": "triangular",
                **pulse,
                "limit": 0.01,
                "dead_band": 0.5,
                "model": "drift",
                "plane": "yaw",
                "switch": "report",
                "sign": "frozen",
                "gust": gust,
                "gust_at": 3.0,
                "heading": 1.0,
                "limit_shape": ellipse,
            },
        ),
        "Study.of": Door(tv.Study.of, {"case": study.case, "dead_band": 0.5, "switch": "report"}),
        "Study.required_at": Door(study.required_at, {"size": 0.9}),
        "StudyPlan": Door(
            tv.studyfile.StudyPlan,
            {
                "vehicle": booster.replace(structure=structure),
                "model": "drift",
                "plane": "yaw",
                "wind": slanting,
                "plant_system": exact.system,
                "controller": None,
                "reading": tv.winds.soundings.sounding_files.NO_READING,
                "dead_band": 0.5,
                "load": tv.case.LoadBound(load=0.05),
                "switch": "report",
                "sign": "frozen",
                "nozzle": tv.Nozzle(limit=0.01, limit_shape="square"),
                "laws": tv.design.LawsRequest(),
                "design": tv.AutopilotDesign(design="canonical"),
                "criteria": tv.CRITERIA["classic"],
                "dispersions": dispersions,
                "cases": 100,
                "seed": 1,
                "method": "sobol",
                "probability": 0.9,
                "confidence": 0.9,
                "sizing": request,
                "availability": days_asked,
                "document": tv.studyfile.Document(project="Booster 1"),
                "turbulence": tv.case.TurbulenceRequest(intensity=6.0),
            },
        ),
        "StudyPlan.of_study": Door(tv.studyfile.StudyPlan.of_study, {"study": study}),
        "TrapezoidalWind": Door(
            tv.winds.TrapezoidalWind, {"peak": 0.09, "rise": 1.0, "hold": 2.0, "fall": 1.0}
        ),
        "TriangularWind": Door(tv.TriangularWind, pulse),
        "TrimLaw": Door(tv.TrimLaw, {"plant": plant, "gain": 10.0}),
        "TrimLaw.suited": Door(
            tv.TrimLaw.suited, {"plant": plant, "peak": 0.09, "rate_limit": 0.01}
        ),
        "Vehicle": Door(
            tv.Vehicle, {f.name: getattr(booster, f.name) for f in dataclasses.fields(booster)}
        ),
        "aerodynamic_damping": Door(
            tv.vehicle.aerodynamic_damping,
            {
                "coefficient": -40.0,
                "per": "qL/V",
                "dynamic_pressure": 4.5e4,
                "reference_area": 34.2,
                "reference_length": 6.6,
                "velocity": 540.0,
            },
        ),
        "jet_damping": Door(
            tv.vehicle.jet_damping, {"mass_flow": 9000.0, "exit_arm": 25.0, "inertia_rate": -5e5}
        ),
        "Vehicle.from_aerodynamics": Door(
            tv.Vehicle.from_aerodynamics,
            {
                "dynamic_pressure": 4e4,
                "reference_area": 10.0,
                "normal_force_coefficient_slope": 2.0,
                "axial_force_coefficient": 0.3,
                "weight": 1e6,
                "moment_of_inertia": 2e7,
                "thrust": 2e6,
                "aerodynamic_arm": 9.0,
                "control_arm": 20.0,
                "velocity": 500.0,
                "attitude": 0.8,
            },
        ),
        "Vehicle.replace": Door(booster.replace, {"weight": 1e6}),
        "WindEnsemble": Door(
            tv.winds.WindEnsemble, {"time": [0.0, 1.0], "angle": [[0.1, 0.0], [0.0, 0.1]]}
        ),
        "WindEstimator": Door(
            tv.control.WindEstimator, {"bandwidth": 10.0, "rate_noise": 0.0, "seed": 1}
        ),
        "WindEstimator.states": Door(estimator.states, {"plant": plant}),
        "WindProfile": Door(
            tv.WindProfile,
            {
                "height": [0.0, 1e4],
                "east": [0.0, 10.0],
                "north": [0.0, 10.0],
                "source": "here",
                "notes": ("a note",),
            },
        ),
        "WindProfile.at": Door(west.at, {"height": 5e3}),
        "WindProfile.between": Door(west.between, {"low": 1e3, "high": 2e4}),
        "WindProfile.cross_plane": Door(west.cross_plane, {"azimuth": 1.0}),
        "WindProfile.gaps_between": Door(west.gaps_between, {"low": 1e3, "high": 2e4}),
        "WindProfile.in_plane": Door(west.in_plane, {"azimuth": 1.0}),
        "WindProfile.notes_along": Door(west.notes_along, {"flight": climb}),
        "WindProfile.smoothed": Door(west.smoothed, {"thickness": 500.0}),
        "WindProfile.to_wind": Door(
            west.to_wind, {"flight": climb, "azimuth": 1.0, "plane": "pitch"}
        ),
        "add_gust": Door(
            tv.winds.add_gust,
            {
                "profile": west,
                "base": 5e3,
                "amplitude": 9.0,
                "blend": 100.0,
                "thickness": 300.0,
                "azimuth": 1.0,
            },
        ),
        "all_modes": Door(tv.linear.all_modes, {"plant": exact}),
        "angle_from_speed": Door(
            tv.angle_from_speed, {"speed": 50.0, "velocity": 500.0, "flight_path_angle": 0.8}
        ),
        "attitude_response": Door(tv.attitude_response, {**both, "timepts": times}),
        "attitude_responses": Door(
            tv.attitude_responses, {**both, "timepts": times, "outputs": ("attitude",)}
        ),
        "available_models": Door(tv.linear.available_models, {"coefficients": coefficients}),
        "boundary_limit": Door(
            tv.boundary_limit, {**history, "dead_band": 0.5, "switch": "literal"}
        ),
        "canonical_gains": Door(tv.control.canonical_gains, {"plant": coefficients, **options}),
        "closed_loop_boundary": Door(
            tv.closed_loop_boundary,
            {
                "progress": None,
                **history,
                "law": law,
                "rate_limit": 1.0,
                "actuator": actuator,
                "sample_rate": 60.0,
                "delay": 0.01,
                "gain": 1.0,
                "cuts": 0,
                "lowest": 0.5,
                "highest": 1.0,
            },
        ),
        "compare_with_trim": Door(
            tv.compare_with_trim, {"plant": exact, "autopilot": autopilot, "wind": wind}
        ),
        "Detuned.row": Door(tv.control.detuned(**detuned).row, {"change": "nominal"}),
        "detuned": Door(tv.control.detuned, {**detuned, "criteria": tv.CRITERIA["classic"]}),
        "design_gains": Door(tv.design_gains, {"plant": coefficients, **poles, **options}),
        "disperse_study": Door(
            tv.ensembles.disperse_study,
            {
                "study": study,
                "dispersions": dispersions,
                "cases": 50,
                "seed": 1,
                "probability": 0.9,
                "confidence": 0.9,
                "method": "plain",
            },
        ),
        "drift_minimum_gains": Door(
            tv.control.drift_minimum_gains, {"plant": coefficients, **poles, **options}
        ),
        "equivalent_triangle": Door(tv.winds.equivalent_triangle, {"wind": wind}),
        "explore": Door(tv.explore, {"vehicle": "configuration-i"}),
        "flown_boundary": Door(
            tv.flown_boundary,
            {
                "vehicle": booster,
                "wind": wind,
                "dead_band": 1.0,
                "law": law,
                "engine": "planar",
                "plane": "pitch",
                "frozen": True,
                "tolerance": 0.5,
                "highest": 1.5,
                "drift": True,
                "condition": None,
                **hardware,
            },
        ),
        "fly": Door(
            tv.fly,
            {
                **history,
                "law": law,
                "timepts": [0.0, 2.0],
                "deflection_limit": 0.01,
                "sample_rate": 60.0,
                "delay": 0.01,
                "gain": 1.0,
                **hardware,
            },
        ),
        "compare_flight": Door(
            tv.flights.compare_flight,
            {
                "vehicle": booster,
                "control": tv.flights.ReportControl(),
                "wind": wind,
                "timepts": [0.0, 3.0],
                "deflection_limit": 0.01,
                "engine": "planar",
                "plane": "pitch",
                "condition": None,
                "boundary": 0.006,
            },
        ),
        "boundary_map": Door(
            tv.flights.boundary_map,
            {
                **history,
                "law": law,
                "gains": [0.8, 1.0],
                "delays": [0.0, 0.02],
                "rate_limit": 1.0,
                "actuator": actuator,
                "sample_rate": 60.0,
                "cuts": 0,
                "lowest": 0.5,
                "highest": 1.0,
            },
        ),
        "flown_margins": Door(
            tv.flights.flown_margins,
            {
                **history,
                "law": law,
                "limit": 0.02,
                "rate_limit": 1.0,
                "actuator": actuator,
                "sample_rate": 60.0,
                "delay": 0.01,
                "cuts": 0,
            },
        ),
        "fly_many": Door(
            tv.fly_many,
            {
                **history,
                "law": law,
                "deflection_limit": 0.01,
                "sample_rate": 60.0,
                "until": 20.0,
                "delay": 0.01,
                "gain": 1.0,
                **hardware,
            },
        ),
        "fly_planes": Door(
            hasty(tv.flights.fly_planes),
            {
                "plant": exact,
                "law": law,
                "wind": veering,
                "deflection_limit": 0.01,
                "limit_shape": ellipse,
                "saturate": "radial",
                "sample_rate": 60.0,
                "delay": 0.01,
                "yaw_plant": exact,
                "rate_limit": 1.0,
                "actuator": tv.Actuator(natural_frequency=25.0, damping=None),
            },
        ),
        "flown_plane_limit": Door(
            hasty(tv.flights.flown_plane_limit),
            {
                "plant": exact,
                "law": law,
                "wind": veering,
                "limit_shape": ellipse,
                "saturate": "radial",
                "sample_rate": 20.0,
                "lowest": 0.5,
                "highest": 1.5,
            },
        ),
        "fly_planar": Door(
            tv.fly_planar,
            {
                "vehicle": booster,
                "control": law,
                "wind": wind,
                "timepts": [0.0, 2.0],
                "deflection_limit": 0.01,
                "plane": "pitch",
                "drift": True,
                "condition": None,
                **hardware,
            },
        ),
        "fly_sixdof": Door(
            tv.fly_sixdof,
            {
                "vehicle": booster,
                "control": law,
                "wind": wind,
                "timepts": [0.0, 0.5],
                "deflection_limit": 0.01,
                "plane": "pitch",
                "drift": True,
                "step": 0.01,
                "earth": None,
                "condition": None,
                **hardware,
            },
        ),
        "fly_through": Door(
            tv.fly_through,
            {
                "profile": west,
                "schedule": schedule,
                "azimuth": 1.5,
                "plane": "pitch",
                "window": 20.0,
                "gust": gust,
                "bias": calm,
                "pressure": True,
            },
        ),
        "forecast_free_limit": Door(
            tv.forecast_free_limit, {**history, "reversal": 0.1, "turn": 1.0}
        ),
        "is_stable": Door(tv.is_stable, both),
        "is_sufficient": Door(tv.is_sufficient, {**history, "limit": 0.01, "dead_band": 0.5}),
        "judge": Door(tv.linear.judge, both),
        "law_trials": Door(
            tv.design.law_trials,
            {
                "plant": plant,
                "laws": {"trim": law},
                "winds": {"triangle": wind},
                "sample_rate": 60.0,
                "delay": 0.01,
                "cuts": 0,
                "loads": False,
                "progress": None,
                **hardware,
            },
        ),
        "load_campaign": Door(tv.studyfile.load_campaign, {"path": campaign_file}),
        "half_relief_gains": Door(tv.control.half_relief_gains, {"plant": coefficients, **options}),
        "load_minimum_gains": Door(
            tv.control.load_minimum_gains, {"plant": coefficients, **poles, **options}
        ),
        "load_schedule": Door(
            tv.load_schedule,
            {"source": "configuration-i", "start": 60.0, "stop": 70.0, "step": 5.0},
        ),
        "load_sizing": Door(tv.studyfile.load_sizing, {"source": sizing_file, "soundings": None}),
        "load_study": Door(tv.load_study, {"source": "configuration-i", "time": 60.0}),
        "load_any_vehicle": Door(tv.vehicle.load_any_vehicle, {"source": "configuration-i"}),
        "load_vehicle": Door(tv.load_vehicle, {"source": "configuration-i"}),
        "loop_margins": Door(tv.control.loop_margins, {"loop": tv.Loop([1.0], [1.0, 1.0])}),
        "lqr_gains": Door(
            tv.control.lqr_gains,
            {
                "plant": plant,
                "attitude_weight": 1.0,
                "rate_weight": 0.1,
                "alpha_weight": 0.1,
                "drift_rate_weight": 0.0,
                "drift_weight": 0.0,
                "deflection_weight": 1.0,
                **options,
            },
        ),
        "open_campaign": Door(tv.ensembles.open_campaign, {"folder": done}),
        "flown_trade_offs": Door(
            tv.nozzle.flown_trade_offs,
            {
                "cases": {"one": tv.Case(vehicle=booster)},
                "rates": [0.02],
                "laws": ("half-relief",),
                "cuts": 0,
                "progress": lambda done, total: None,
            },
        ),
        "flown_required_rate": Door(
            tv.nozzle.flown_required_rate,
            {"case": carded, "law": tv.SaturatedLaw.of(carded.autopilot)},
        ),
        "FlightDuty.to_csv": Door(
            tv.nozzle.flight_duty(carded, once).to_csv, {"path": folder / "card.csv"}
        ),
        "SizingRequest.ratio": Door(request.ratio, {"case": carded, "sizing": sizing}),
        "controllability_ratio": Door(
            tv.requirement.controllability_ratio,
            {
                "sizing": sizing,
                "limit": 0.02,
                "gust": 0.01,
                "thrust_offset": 0.001,
                "gravity_offset": 0.01,
            },
        ),
        "read_log": Door(
            tv.ascent.read_log,
            {
                "path": SCHEDULES / "log.csv",
                "columns": None,
                "start": 2.0,
                "stop": 8.0,
                "max_rows": 50,
            },
        ),
        "SimulatedFlight.write_wind": Door(
            tv.ascent.read_log(SCHEDULES / "log.csv").write_wind, {"path": folder / "wind.csv"}
        ),
        "LoadBound.trade_off": Door(
            tv.case.LoadBound(load=0.05).trade_off,
            {"case": carded, "fraction": 0.9, "only_bound": False},
        ),
        "FlownLoad.of": Door(
            tv.case.FlownLoad.of,
            {
                "case": carded,
                "name": "trim",
                "law": law,
                "bound": tv.case.LoadBound(load=0.05),
            },
        ),
        "flight_duty": Door(
            tv.nozzle.flight_duty,
            {
                "case": carded,
                "request": once,
                "law": "autopilot",
                "turbulence": tv.case.TurbulenceRequest(intensity=6.0),
                "progress": None,
            },
        ),
        "nozzle_duty": Door(
            tv.nozzle.nozzle_duty,
            {
                "times": np.linspace(0.0, 1.0, 5),
                "deflection": 0.01 * np.arange(5),
                "limit": 0.1,
                "window": 0.5,
                "nozzle": hinge,
                "vehicle": booster,
                "angle_of_attack": 0.01 * np.ones(5),
                "attitude": 0.01 * np.ones(5),
            },
        ),
        "LoadBound": Door(
            tv.case.LoadBound,
            {
                "load": None,
                "q_alpha": None,
                "dynamic_pressure": None,
                "moment": 1e6,
                "alpha_moment": 2e7,
                "deflection_moment": 1e7,
            },
        ),
        "NozzleData": Door(
            tv.case.NozzleData,
            {
                "engine": hinge.engine,
                "stiffness": 1e5,
                "damping": 1e4,
                "friction": 100.0,
                "offset": 0.01,
                "thrust_offset": 0.01,
            },
        ),
        "rate_trade_off": Door(
            tv.boundary.rate_trade_off,
            {
                **history,
                "rates": [0.05, 0.1],
                "limit": 0.02,
                "rate_limit": 0.1,
                "acceleration_limit": 5.0,
                "forecast": True,
            },
        ),
        "load_trade_off": Door(
            tv.boundary.load_trade_off,
            {
                **history,
                "loads": [0.08, 0.09],
                "limit": 0.02,
                "load": 0.09,
                "rate_limit": 0.1,
                "moment_ratio": 0.5,
            },
        ),
        "optimum_deflection": Door(
            tv.optimum_deflection, {**history, "start": 0.0, "horizon": 20.0}
        ),
        "optimum_with_rate_limit": Door(
            tv.boundary.optimum_with_rate_limit,
            {**history, "rate_limit": 0.1, "start": 0.0, "horizon": 20.0, "steps": 20},
        ),
        "power_law_shear": Door(tv.winds.power_law_shear, {"change": 20.0, "thickness": 500.0}),
        "read_openrocket": Door(
            tv.ascent.read_openrocket,
            {
                **simulated,
                "path": SCHEDULES / "openrocket.csv",
                "normal_force_coefficient_slope": 2.0,
                "reference_area": 0.0165,
            },
        ),
        "availability": Door(
            tv.availability,
            {
                "flight": schedule,
                "soundings": archive,
                "limit": 0.01,
                "azimuth": 1.5,
                "plane": "both",
                "limit_shape": "round",
                "model": "drift-exact",
                "persistence": 0.001,
                "gust": gust,
                "gust_speed": 9.0,
                "sign": "frozen",
                "known_to": 12e3,
                "utc_offset": -5.0,
                "confidence": 0.9,
                "progress": None,
            },
        ),
        "WindGrowth": Door(tv.ensembles.WindGrowth, {"speed": [5.0, 6.0], "height": [0.0, 1e4]}),
        "WindGrowth.at": Door(tv.ensembles.WindGrowth(5.0).at, {"height": [0.0, 1e4]}),
        "read_turbulence": Door(
            tv.winds.read_turbulence,
            {"path": turbulence_file, "spectrum": "dryden", "component": "transverse"},
        ),
        "read_range_reference": Door(
            tv.winds.read_range_reference, {"path": SOUNDINGS / "T1cap19.txt"}
        ),
        "read_rasaero": Door(
            tv.ascent.read_rasaero,
            {
                **simulated,
                "path": SCHEDULES / "rasaero-flight.csv",
                "moment_of_inertia": ([0.0, 5.0], [24.0, 20.0]),
                "normal_force_coefficient_slope": SCHEDULES / "rasaero-aerodynamics.csv",
            },
        ),
        "read_sounding": Door(
            tv.read_sounding,
            {
                "path": SOUNDINGS / "wyoming.txt",
                "format": "wyoming",
                "time": None,
                "units": None,
                "above_ground": None,
            },
        ),
        "read_table": Door(
            tv.ascent.read_table,
            {"path": SCHEDULES / "table.csv", "columns": MAP, **span},
        ),
        "read_soundings": Door(
            tv.read_soundings,
            {
                "source": SOUNDINGS / "igra.txt",
                "months": [2],
                "years": (2024, 2024),
                "station": None,
                "times": None,
                "in_order": False,
                "dates": None,
                "utc_offset": 0.0,
                "format": None,
                "units": None,
                "above_ground": None,
                "progress": None,
            },
        ),
        "relief_gains": Door(
            tv.control.relief_gains,
            {"plant": coefficients, **poles, "alpha_ratio": 0.5, **options},
        ),
        "report_html": Door(tv.report_html, {"source": study}),
        "required_deflection": Door(
            tv.required_deflection,
            {**history, "dead_band": 1.0, "two_sided": wind - 0.5 * wind.shift(9.0)},
        ),
        "residues": Door(tv.residues, both),
        "resume_campaign": Door(
            tv.ensembles.resume_campaign,
            {"folder": done, "executor": None, "shard": "1/1", "progress": None},
        ),
        "run_campaign": Door(
            run_anew,
            {
                "campaign": campaign,
                "folder": NEW,
                "executor": None,
                "shard": "1/1",
                "compiled": False,
                "progress": None,
            },
        ),
        "schedule_from_rocketpy": Door(
            tv.ascent.schedule_from_rocketpy,
            {
                "flight": rocketpy_standin.Flight(),
                "gimbal_position": -1.2,
                "without": ("Fins",),
                **span,
            },
        ),
        "single_pole_validity": Door(
            tv.boundary.single_pole_validity, {"coefficients": coefficients}
        ),
        "size": Door(
            tv.size,
            {
                "schedule": schedule,
                "winds": {"wind": wind},
                "times": [66.0],
                "dead_bands": [1.0],
                "model": "drift-exact",
                "plane": "pitch",
                "limit_shape": "round",
                "progress": None,
                "placing": "peak",
                "window": 20.0,
                "law": "bound",
                "varying": False,
            },
        ),
        "standard_laws": Door(
            tv.design.standard_laws,
            {"plant": plant, "peak": 0.09, "autopilot": autopilot, "rate_limit": 0.01},
        ),
        "design_law": Door(
            tv.control.design_law,
            {"name": "trim", "plant": plant, "peak": 0.09, "rate_limit": 0.01},
        ),
        "standard_winds": Door(tv.design.standard_winds, pulse),
        "steady_climb": Door(
            tv.winds.steady_climb, {"vehicle": booster, "height": 12e3, "start": 60.0, "stop": 70.0}
        ),
        "survivable_peak": Door(tv.survivable_peak, {**history, "limit": 0.01, "dead_band": 0.5}),
        "synthetic_profile": Door(
            tv.winds.synthetic_profile,
            {
                "height": [0.0, 1e4, 2e4],
                "speed": [10.0, 50.0, 20.0],
                "peak_height": 1e4,
                "thickness": [100.0, 1000.0, 9000.0],
                "change": [5.0, 20.0, 50.0],
                "azimuth": 1.5,
            },
        ),
        "total_deflection": Door(
            tv.requirement.total_deflection,
            {
                "vehicle": booster,
                "wind": 0.006,
                "nominal": 0.001,
                "dispersion": 0.001,
                "thrust_offset": 0.001,
                "gravity_offset": 0.01,
                "others": (line,),
                "reserve": 0.1,
                "limit": 0.02,
            },
        ),
        "triangle_error": Door(tv.boundary.triangle_error, {**history, "dead_band": 0.5}),
        "rectangular_limit": Door(tv.boundary.rectangular_limit, {"tau_beta": 4.0, "K1": 0.9}),
        "triangular_limit": Door(tv.boundary.triangular_limit, {"tau_beta": 4.0, "dead_band": 0.5}),
        "triangular_limit_with_drift": Door(tv.boundary.triangular_limit_with_drift, drifting),
        "solve_triangular_with_drift": Door(tv.boundary.solve_triangular_with_drift, drifting),
        "trim_deflection": Door(tv.trim_deflection, history),
        "trim_then_hold": Door(
            tv.trim_then_hold,
            {**history, "limit": limit, "dead_band": 0.5, "switch": "literal"},
        ),
        "unstable_modes": Door(tv.unstable_modes, {"plant": exact}),
        "wind_loads": Door(tv.linear.wind_loads, both),
        "worst_duration": Door(
            tv.control.worst_duration,
            {
                "plant": plant,
                "autopilot": autopilot,
                "peak": 0.09,
                "shortest": 5.0,
                "longest": 6.0,
                "shape": tv.TriangularWind,
            },
        ),
        "worst_month": Door(tv.winds.worst_month, {"months": months, "percentile": 95.0}),
        "FlightTurbulence.quantile_at": Door(
            along.quantile_at, {"time": 66.0, "output": "deflection"}
        ),
        "worst_total": Door(
            tv.worst_total,
            {
                "turbulence": along,
                "sizing": sizing,
                "name": "K = 1",
                "dispersion": 0.1,
                "rate_limit": 0.1,
                "thrust_offset": 0.001,
                "gravity_offset": 0.01,
                "reserve": 0.1,
                "limit": 0.02,
            },
        ),
    }


NEW = object()
"""Stands for a folder that is not there yet."""


def nested(depth: int, kind: type = list) -> Any:
    """Return lists or tables, one in the other."""
    made: Any = 1.0
    for _ in range(depth):
        made = [made] if kind is list else {"a": made}
    return made


class Rude:
    """A value that cannot even be shown."""

    def __repr__(self) -> str:
        """Fail."""
        raise RuntimeError("not shown")


def hostile() -> dict[str, Any]:
    """Return values that no argument expects, by name."""
    batch = tv.TriangularWind(peak=[0.01, 0.02, 0.03], duration=7.5)
    return {
        "none": None,
        "text": "x",
        "no text": "",
        "null byte": "a\0b",
        "long text": "x" * 5000,
        "surrogate": "\udc80",
        "bytes": b"x",
        "object": object(),
        "rude": Rude(),
        "class": dict,
        "function": lambda *_, **__: None,
        "generator": (x for x in [1.0]),
        "empty list": [],
        "empty array": np.zeros(0),
        "rows without columns": np.zeros((3, 0)),
        "matrix": np.ones((2, 3)),
        "array without axes": np.array(5),
        "row": np.ones(7),
        "row with nan": np.array([0.5, np.nan]),
        "many dimensions": np.ones((1,) * 40),
        "ragged": [[1.0], [1.0, 2.0]],
        "strings": ["a", "b"],
        "twice": ("x", "x"),
        "unhashable": ([], {}),
        "nan": np.nan,
        "inf": np.inf,
        "-inf": -np.inf,
        "-1": -1,
        "-0.5": -0.5,
        "0": 0,
        "1": 1,
        "1e308": 1e308,
        "-1e308": -1e308,
        "1e-308": 1e-308,
        "1e18": 1e18,
        "1e-18": 1e-18,
        "1e9": 10**9,
        "huge": 10**400,
        "true": True,
        "complex": 1.0 + 1.0j,
        "wind": tv.TriangularWind(peak=0.02, duration=3.0),
        "winds": batch,
        "long wind": tv.RectangularWind(peak=0.01, duration=1e9),
        "short wind": tv.RectangularWind(peak=1e-12, duration=1e-9),
        "late wind": tv.TriangularWind(peak=0.01, duration=3.0).shift(1e6),
        "held": tv.linear.ConstantDeflection(limit=-0.004),
        "calm": batch * 0.0,
        "vehicle": tv.load_vehicle("configuration-ii"),
        "vehicles": tv.load_vehicle("configuration-i").replace(weight=[1e6, 2e6]),
        "plant": tv.Plant.from_vehicle(tv.load_vehicle("configuration-ii"), "fixed-path"),
        "stable plant": tv.Plant.from_coefficients(
            tv.Coefficients(mu_alpha=-0.2, mu_delta=2.0, C1=0.1), "drift"
        ),
        "plant without moment": tv.Plant.from_coefficients(
            tv.Coefficients(mu_alpha=0.0, mu_delta=2.0), "drift-exact"
        ),
        "plants": tv.Plant.from_coefficients(
            tv.Coefficients(mu_alpha=[0.2, 0.3], mu_delta=2.0), "drift-exact"
        ),
        "extreme plant": tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=1e18, mu_delta=1e-18)),
        "slow plant": tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=1e-18, mu_delta=1e-18)),
        "coefficients": tv.Coefficients(mu_alpha=-0.2, mu_delta=2.0),
        "deep": nested(3000),
        "deep table": nested(3000, dict),
        "table": {"a": 1},
        "path": Path("nothing/there"),
        "folder": Path(),
        "date": np.datetime64("2020-01-01"),
        "masked": np.ma.masked_array([1.0, 2.0], [True, False]),
        "records": np.zeros(2, dtype=[("a", float)]),
    }


def flaws(value: Any, name: str = "") -> Iterator[str]:
    """Yield where a value holds a number that is none; not where its status says so."""
    if isinstance(value, tv.winds.History):
        pieces = value.pieces
        value = {"knots": pieces.knots, "pieces": pieces.coefficients, "peak": value.peak}
    elif isinstance(value, tuple | list):
        value = dict(enumerate(value))
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        if np.all(np.asarray(value.get("status", "ok")) == "ok"):
            for key, one in value.items():
                yield from flaws(one, f"{name}.{key}")
    elif isinstance(value, float | complex | np.number | np.ndarray):
        array = np.asarray(value)
        if array.dtype.kind in "fc" and np.any(np.isnan(array)):
            yield name
