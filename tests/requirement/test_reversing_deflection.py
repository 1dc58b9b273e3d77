"""Near lift-off two poles are a pair, and the effect of a deflection on the unstable mode reverses.

No control then needs less than ``|integral of p.w alpha_w|`` over the integral of ``|p.b|``, here
with the costate p integrated by scipy.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tvclin.requirement.flight.flight_requirement import FlightMode
from tvclin.time_varying.requirements import varying_requirement
from tvclin.time_varying.steps import step_times
from tvclin.winds.wind_angles import NominalWind

PAD = """time_s,altitude_m,velocity_m_per_s,mass_kg,thrust_kN,attitude_deg,moment_of_inertia_kg_m2,\
aerodynamic_arm_m,control_arm_m,dynamic_pressure_kPa,reference_area_m2,\
normal_force_coefficient_slope_per_rad,axial_force_coefficient
0,0,5,28500,380,90,490000,2.6,6.2,0.015,1.54,3,0.4
5,125,25,27750,381.7,87.14,483500,2.667,6.25,0.376,1.54,3.033,0.41
10,250,45,27000,383.3,84.66,477000,2.733,6.3,1.198,1.54,3.067,0.42
20,950,100,25500,386.7,80.03,464000,2.867,6.4,5.368,1.54,3.133,0.44
30,2200,165,24000,390,75.64,451000,3,6.5,12.285,1.54,3.2,0.46
"""
WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)


@pytest.fixture(scope="module")
def mode(tmp_path_factory):
    """The unstable mode of a flight from the pad."""
    path = tmp_path_factory.mktemp("pad") / "pad.csv"
    path.write_text(PAD)
    flight = tv.load_schedule(path)
    return FlightMode(flight, "drift-exact", "pitch", (-5.0, flight.span[1]))


def matrices(mode, time):
    """Return A, and the columns of deflection and wind, of the vehicle at a time [s]."""
    time = np.asarray(min(time, mode.last_unstable))
    return mode.schedule.plants(time, mode.model, mode.plane).matrices()[:2]


def moments(mode, times):
    """Return p.b and p.w of the costate of the mode at rising times [s], by scipy."""
    end, breaks = mode.last_unstable, [*mode.schedule.times[::-1], times[0]]
    A, _ = matrices(mode, end)
    values, vectors = np.linalg.eig(A.T)
    p, of_b, of_w = np.real(vectors[:, np.argmax(np.real(values))]), [], []
    for stop, start in pairwise(breaks):
        inside = times[(times >= start) & (times < stop)][::-1]
        run = solve_ivp(
            lambda t, p: -matrices(mode, t)[0].T @ p,
            (stop, start),
            p,
            method="DOP853",
            t_eval=np.append(inside[inside > start], start),
            rtol=1e-9,
            atol=1e-12,
        )
        p = run.y[:, -1]
        columns = np.array([matrices(mode, t)[1] for t in inside])
        found = np.einsum("in,nij->nj", run.y[:, : inside.size], columns)
        of_b, of_w = [*of_b, *found[:, 0]], [*of_w, *found[:, 1]]
    return np.array(of_b)[::-1], np.array(of_w)[::-1]


@pytest.mark.thorough
@pytest.mark.parametrize("middle", [3.2, 3.7])
def test_no_control_needs_less_where_the_effect_of_a_deflection_reverses(mode, middle):
    wind = WIND.shift(middle - 0.5 * WIND.duration)
    answer = varying_requirement(mode, [NominalWind(wind)])
    edges = np.linspace(float(wind.onset), mode.last_unstable, 3001)
    middles = 0.5 * (edges[1:] + edges[:-1])
    of_b, of_w = moments(mode, middles) * np.array(np.diff(edges))
    final, _ = matrices(mode, mode.last_unstable)
    assert np.min(of_b) < 0.0 < np.max(of_b)
    need = float(np.sum(of_w * wind(middles)))
    # after the flight the vehicle is frozen: p.b decays with the pole
    pole = np.max(np.real(np.linalg.eigvals(final)))
    of_b = np.append(of_b, of_b[-1] / (edges[1] - edges[0]) / pole)
    dual = abs(need) / np.abs(of_b).sum()
    # of the one step, or interval, in which p.b changes its sign a part is missing
    assert answer.minimum[0] == pytest.approx(dual, rel=1e-3)
    assert answer.minimum[0] < answer.required[0] == pytest.approx(answer.trim[0], rel=1e-4)


@pytest.mark.parametrize("dead_band", [1.0, 0.5])
def test_winds_before_and_after_the_reversal_require_the_same_together_as_alone(mode, dead_band):
    short = tv.TriangularWind(peak=np.radians(5.0), duration=2.0)
    onsets = [*np.arange(0.5, 3.5, 0.5), *np.arange(12.5, 18.0, 0.5)]
    groups = {}  # winds with the same number of steps are marched together
    for onset in onsets:
        wind = NominalWind(short.shift(onset))
        groups.setdefault(step_times(wind.history, mode).shape[1], []).append(wind)
    assert max(map(len, groups.values())) > 3
    for winds in groups.values():
        together = varying_requirement(mode, winds, dead_band)
        for k, wind in enumerate(winds):
            alone = varying_requirement(mode, [wind], dead_band)
            for name in ("minimum", "required"):
                value, expected = getattr(together, name)[k], getattr(alone, name)[0]
                assert value == pytest.approx(expected, rel=1e-9), (name, k)
