"""What laws need over the rate limit: each boundary by itself, over flight times and winds."""

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.winds.shaped import FixedWind

VEHICLE = tv.load_vehicle("configuration-i")
NOZZLE = tv.Nozzle(limit=np.radians(0.4), rate_limit=np.radians(0.5), actuator=None)
LAWS = ("trim", "recoverable-attitude")


@pytest.fixture(scope="module")
def flown():
    """The vehicle, and with less thrust, as at another time; and another wind."""
    gust = tv.ShapedWind("one-minus-cosine", np.radians(5.0), 7.5)
    cases = {
        "now": tv.Case(vehicle=VEHICLE, nozzle=NOZZLE),
        "later": tv.Case(vehicle=VEHICLE.replace(thrust=0.9 * VEHICLE.thrust), nozzle=NOZZLE),
        "gust": tv.Case(vehicle=VEHICLE, wind=gust, nozzle=NOZZLE),
    }
    calls = []
    rates = np.radians([0.3])
    trade_offs = tv.nozzle.flown_trade_offs(
        cases, rates, laws=LAWS, progress=lambda done, total: calls.append((done, total))
    )
    return cases, trade_offs, calls


@pytest.mark.thorough
def test_each_number_is_a_boundary_of_a_law_designed_for_its_rate(flown):
    cases, trade_offs, calls = flown
    done = [one for one, _ in calls]
    assert done == sorted(done)
    assert {one for one in done if one.is_integer()} == set(range(1, 13))
    assert {total for _, total in calls} == {12}
    for name, case in cases.items():
        trade_off = trade_offs[name]
        rates = trade_off.minimum.rates
        assert np.degrees(rates) == pytest.approx([0.3, 0.5])
        peak = float(case.history.peak)
        for law in LAWS:
            designed = tv.control.design_law(law, case.plant, peak, rate_limit=rates[1])
            single = tv.closed_loop_boundary(
                case.plant,
                designed,
                case.history,
                rate_limit=rates[1],
                sample_rate=100,
                cuts=1,
                highest=3.0,
            )
            assert trade_off.limits[law][1] == abs(single.deflection) == trade_off.required[law]
            assert trade_off.survives[law] == bool(NOZZLE.limit >= trade_off.required[law])


@pytest.mark.thorough
def test_no_law_needs_less_than_its_bound_and_more_rate_is_never_worse(flown):
    """The law that knows its rate comes near the bound; a boundary is known to 1e-3 of trim."""
    cases, trade_offs, _ = flown
    for name, trade_off in trade_offs.items():
        slack = 1e-3 * abs(float(cases[name].plant.coefficients.B * cases[name].history.peak))
        for values in trade_off.limits.values():
            assert np.all(values >= trade_off.minimum.no_forecast_bounds - slack)
            assert np.all(values[1:] <= values[:-1] + slack)
        assert np.all(
            trade_off.limits["recoverable-attitude"] < 1.35 * trade_off.minimum.no_forecast_bounds
        )


def test_unknown_laws_and_what_is_no_case_are_refused():
    case = tv.Case(vehicle=VEHICLE, nozzle=NOZZLE)
    with pytest.raises(tv.InputError, match="laws must be one of"):
        tv.nozzle.flown_trade_offs({"one": case}, laws=("trm",))
    with pytest.raises(tv.InputError, match="cases must"):
        tv.nozzle.flown_trade_offs({"one": VEHICLE})


def test_progress_advances_within_a_boundary():
    calls = []
    case = tv.Case(vehicle=VEHICLE, nozzle=NOZZLE)
    options = {"laws": ("trim",), "progress": lambda done, total: calls.append(done / total)}
    tv.nozzle.flown_trade_offs({"now": case}, NOZZLE.rate_limit * np.ones(1), **options)
    assert len(calls) > 2
    assert 0.0 < calls[0] < 0.3
    assert calls[-1] == 1.0


@pytest.mark.parametrize("given", usual([{"sample_rate": 1e5}, {"duration": 4000.0}], 0))
def test_more_samples_than_can_be_flown_are_refused_at_once(given):
    """The default is 30 boundaries of 2 winds with up to 253 limits: 1.5e4 flights."""
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=given.get("duration", 7.5))
    design = tv.AutopilotDesign(sample_rate=given.get("sample_rate"))
    case = tv.Case(vehicle=VEHICLE, wind=wind, nozzle=NOZZLE, design=design)
    with pytest.raises(tv.InputError, match=r"at most 2e\+09 samples"):
        tv.nozzle.flown_trade_offs({"one": case})


@pytest.mark.parametrize(
    "actuator", usual([None, tv.Actuator(natural_frequency=10.0, damping=0.7)], 0)
)
def test_at_the_required_rate_of_an_autopilot_the_limit_is_its_requirement(actuator):
    """The boundary over the limit is known to 1e-3 of static trim; the rate to 2e-4 of itself."""
    nozzle = tv.Nozzle(limit=np.radians(0.8), actuator=actuator)
    case = tv.Case(vehicle=VEHICLE, nozzle=nozzle)
    law = tv.SaturatedLaw.of(case.autopilot)
    rate = tv.nozzle.flown_required_rate(case, law)
    hardware = {**case.hardware, "rate_limit": rate}
    boundary = tv.closed_loop_boundary(case.plant, law, case.history, **hardware)
    trim = abs(float(case.plant.coefficients.B * case.history.peak))
    assert abs(boundary.deflection) == pytest.approx(nozzle.limit, abs=1e-3 * trim)
    fly = {**hardware, "deflection_limit": nozzle.limit}
    attitudes = [
        tv.fly(case.plant, law, case.history, [0.0, 60.0], **{**fly, "rate_limit": x * rate})
        for x in (0.999, 1.001)
    ]
    lost, survived = (abs(float(flown.outputs[0, -1])) for flown in attitudes)
    assert lost > 10.0
    assert survived < 0.1


def test_no_rate_is_sufficient_for_an_autopilot_that_is_lost_without_a_rate_limit():
    case = tv.Case(vehicle=VEHICLE, nozzle=NOZZLE)
    law = tv.SaturatedLaw.of(case.autopilot)
    assert tv.nozzle.flown_required_rate(case, law) == np.inf
    with pytest.raises(tv.InputError, match="needs a nozzle with a limit"):
        tv.nozzle.flown_required_rate(tv.Case(vehicle=VEHICLE), law)


@pytest.mark.thorough
def test_no_law_survives_for_sure_in_a_wind_that_is_not_known_throughout():
    wind, nozzle = tv.TriangularWind(peak=0.03, duration=5.0), tv.Nozzle(limit=0.02, rate_limit=0.1)
    vehicle = tv.load_vehicle("configuration-i")
    survives = []
    for unknown in ("", "the wind is not known from 3 to 6 km"):
        case = tv.Case(vehicle=vehicle, wind=FixedWind(wind, unknown), nozzle=nozzle)
        (found,) = tv.nozzle.flown_trade_offs({"": case}, [0.1], laws=("trim",), cuts=0).values()
        survives.append(found.survives)
        assert any(unknown in note for note in found.notes)
    assert survives == [{"trim": True}, None]
