"""Campaigns of vehicles that bend and slosh: each case is what the library says of its numbers."""

from dataclasses import replace

import numpy as np
import pytest

import tvclin as tv
from tests.flexible import MODE, TANK
from tvclin.ensembles.campaign.case_replay import replay_case
from tvclin.ensembles.campaign.cases import draw_cases, evaluate
from tvclin.ensembles.campaign.folder import read, written
from tvclin.studyfile.campaign_file import parse_campaign

VEHICLE = tv.load_vehicle("configuration-i")
STRUCTURE = tv.Structure(bending=(MODE,), slosh=(TANK,))
NOTCH = tv.vehicle.Filter.notch(24.0 * np.pi, 0.05, 0.5)
DESIGN = tv.AutopilotDesign(natural_frequency=1.5, delay=0.01, filters=(NOTCH,))
NOZZLE = tv.Nozzle(limit=np.radians(0.41))
FACTORS = ("bending_frequency", "bending_1_damping", "slosh_frequency", "slosh_1_damping")


def campaign(**changes):
    spreads = [tv.Dispersion(name, "uniform", 0.25) for name in FACTORS]
    given = {
        "vehicle": VEHICLE.replace(structure=STRUCTURE),
        "design": DESIGN,
        "wind": tv.ShapedWind("triangular", peak=np.radians(5), duration=7.5),
        "dispersions": tv.Dispersions((*spreads, tv.Dispersion("thrust", "truncated", 0.01))),
        "cases": 40,
        "model": "drift-exact",
        "outputs": ("margins", "flight"),
        "nozzle": NOZZLE,
    }
    return tv.Campaign(**(given | changes))


def plant_of(values, structure=STRUCTURE):
    """Return the flexible plant of drawn numbers, from its equations alone."""
    one = {name: float(value[0]) for name, value in values.items()}
    mode = replace(
        MODE,
        frequency=MODE.frequency * one["bending_frequency"],
        damping=MODE.damping * one["bending_1_damping"],
    )
    tank = replace(
        TANK,
        pendulum_length=TANK.pendulum_length / one["slosh_frequency"] ** 2,
        damping=TANK.damping * one["slosh_1_damping"],
    )
    whole = replace(structure, bending=(mode,), slosh=(tank,))
    return tv.FlexiblePlant.from_vehicle(
        VEHICLE.replace(thrust=one["thrust"]), whole, "drift-exact"
    )


@pytest.mark.thorough
def test_each_case_has_the_margins_and_the_flight_of_its_own_modes():
    plan = campaign()
    result = evaluate(plan, 0, 12)
    autopilot = DESIGN.autopilot(tv.Plant.from_vehicle(VEHICLE, "drift-exact"), NOZZLE.actuator)
    wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    flying = tv.SaturatedLaw(replace(autopilot, actuator=None, delay=0.0))
    for k in range(0, 12, 3):
        plant = plant_of(draw_cases(plan, k, 1).values)
        bands = autopilot.band_margins(plant)
        assert result["margin_stable"][k] == bands.margins.stable
        pairs = {
            "margin_aero_dB": bands.margins.aero_margin_dB,
            "margin_gain_dB": bands.margins.gain_increase_dB,
            "margin_phase_deg": bands.margins.phase_margin_deg,
            "margin_delay": bands.margins.delay_margin,
            "margin_bending_1_peak_dB": bands.mode("bending 1").peak_dB,
        }
        for name, value in pairs.items():
            assert result[name][k] == pytest.approx(value, rel=1e-9, nan_ok=True)
        flown = tv.fly_many(
            plant,
            flying,
            wind,
            deflection_limit=NOZZLE.limit,
            actuator=tv.Actuator(natural_frequency=25.1, damping=0.7),
            sample_rate=100.0,
            delay=0.01,
        )
        assert result["flight_survived"][k] == (flown.status == "survived")


@pytest.mark.thorough
def test_a_case_has_the_same_bits_alone_and_among_others():
    plan = campaign()
    together = evaluate(plan, 0, 12)
    single = evaluate(plan, 7, 1)
    for name, values in single.items():
        assert values[0] == together[name][7] or np.isnan(values[0])


@pytest.mark.thorough
def test_a_flight_that_rings_has_not_survived():
    """Without a notch the mode grows near rest in every case."""
    result = evaluate(campaign(design=replace(DESIGN, filters=())), 0, 6)
    assert result["flight_survived"].tolist() == [0.0] * 6
    assert result["margin_stable"].tolist() == [0.0] * 6
    assert np.all(np.isinf(result["flight_peak_attitude"]))


@pytest.mark.thorough
def test_a_manifest_keeps_structure_and_autopilot_to_the_last_bit():
    engine = tv.vehicle.Engine(mass=2000.0, arm=1.4, moment_of_inertia=2e3)
    whole = replace(STRUCTURE, engine=engine, rate_gyro=tv.vehicle.Filter.low_pass(120.0, 0.7))
    plan = campaign(vehicle=VEHICLE.replace(structure=whole))
    again = read(written(plan))
    assert written(again) == written(plan)
    assert again.vehicle.structure.bending == whole.bending
    assert again.vehicle.structure.slosh == whole.slosh
    assert again.vehicle.structure.engine == engine
    one, other = evaluate(plan, 0, 3), evaluate(again, 0, 3)
    for name in one:
        np.testing.assert_array_equal(one[name], other[name])


@pytest.mark.parametrize("damaged", [3, None, [], {"bending": [{"frequency": 1.0}]}, {"spring": 1}])
def test_a_manifest_with_another_structure_is_refused(damaged):
    record = written(campaign())
    record["vehicle"]["structure"] = damaged
    with pytest.raises(
        tv.InputError, match="a manifest must hold|must be a Structure|has no nominal"
    ):
        read(record)


@pytest.mark.thorough
def test_a_case_is_flown_again_as_the_flexible_vehicle():
    plan = campaign()
    fates = evaluate(plan, 0, 12)["flight_survived"]
    assert set(fates) == {0.0, 1.0}
    one = replay_case(plan, int(fates.argmax()))
    values = {name: np.array([value]) for name, value in one.inputs.items()}
    np.testing.assert_allclose(
        one.planes["pitch"].batch.flexible.poles, plant_of(values).poles, rtol=1e-12, atol=1e-12
    )
    flown = one.flown()
    attitude = np.abs(flown.outputs["attitude"]).max()
    assert attitude == pytest.approx(one.outputs["flight_peak_attitude"], rel=1e-9)
    assert "sensed_attitude" in flown.output_labels


def test_modes_that_are_not_there_cannot_be_dispersed():
    spread = tv.Dispersions((tv.Dispersion("bending_frequency", "uniform", 0.1),))
    with pytest.raises(tv.InputError, match="bending_frequency is dispersed, but has no nominal"):
        campaign(vehicle=VEHICLE, dispersions=spread)
    second = tv.Dispersions((tv.Dispersion("bending_2_frequency", "uniform", 0.1),))
    with pytest.raises(tv.InputError, match="bending_2_frequency is dispersed, but has no nominal"):
        campaign(dispersions=second)
    with pytest.raises(tv.InputError, match="parameter"):
        tv.Dispersion("bending_0_frequency", "uniform", 0.1)
    with pytest.raises(tv.InputError, match="unknown key structure|structure"):
        parse_campaign(
            {"campaign": {"vehicle": "configuration-i", "cases": 3, "structure": {}}}
            | {"wind": {"shape": "triangular", "peak_deg": 5, "duration_s": 7.5}}
        )


def test_margins_of_a_rigid_vehicle_are_an_output_as_well():
    spread = tv.Dispersions((tv.Dispersion("thrust", "uniform", 0.1),))
    plan = campaign(vehicle=VEHICLE, dispersions=spread, outputs=("margins",))
    result = evaluate(plan, 0, 2)
    autopilot = DESIGN.autopilot(tv.Plant.from_vehicle(VEHICLE, "drift-exact"), NOZZLE.actuator)
    thrust = float(draw_cases(plan, 1, 1).values["thrust"][0])
    plant = tv.Plant.from_vehicle(VEHICLE.replace(thrust=thrust), "drift-exact")
    expected = autopilot.margins(plant).gain_increase_dB
    assert result["margin_gain_dB"][1] == pytest.approx(expected, rel=1e-9)
