"""The chart of both planes: its curves are vectors of the theory, and touch the stop."""

import numpy as np
import pytest

import tvclin as tv
from tvclin.plots import curves_of, plane_chart, study_planes_chart
from tvclin.plots.trade_offs import HELD, MEANS, STOP, TRIMS

PLANT = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
GUST = tv.TriangularWind(peak=0.08, duration=8.0)


def vectors(curves, label: str) -> np.ndarray:
    """Return the vectors [rad] of a curve."""
    across = curves.column(label)
    return (curves.abscissa + 1j * across)[~np.isnan(across)] * np.pi / 180.0


@pytest.mark.thorough
@pytest.mark.parametrize("stop", ["round", "square"])
def test_the_stop_meets_what_is_held_which_is_a_mean_of_the_trim_to_come(stop) -> None:
    wind = tv.winds.PlaneWind.veering(GUST, angle=0.4, rate=np.radians(120) / GUST.duration)
    drawn = curves_of(plane_chart(PLANT, wind, stop))
    shape = tv.boundary.CircularShape() if stop == "round" else tv.boundary.SquareShape()
    limit = tv.plane_limit(PLANT, wind, shape).deflection
    assert shape.gauge(vectors(drawn, STOP)) == pytest.approx(limit, rel=1e-12)
    _, held = vectors(drawn, HELD)
    assert shape.gauge(held) == pytest.approx(limit, rel=1e-9)
    assert np.abs(vectors(drawn, MEANS) - held).min() < 0.01 * abs(held)
    sizes = np.abs(vectors(drawn, TRIMS))
    assert sizes.max() == pytest.approx(0.1 * float(wind.peak), rel=1e-3)


@pytest.mark.thorough
def test_of_a_study_it_is_that_of_its_wind() -> None:
    vehicle = tv.load_vehicle("configuration-i")
    options = {"duration": 7.5, "peak": 0.08}
    study = tv.Study.from_vehicle(vehicle, **options, heading=4.0, limit_shape="square")
    drawn = curves_of(study_planes_chart(study))
    assert study.planes is not None
    assert tv.boundary.SquareShape().gauge(vectors(drawn, STOP)) == pytest.approx(
        study.planes.deflection, rel=1e-9
    )
    with pytest.raises(tv.InputError, match="a wind with a direction"):
        study_planes_chart(tv.Study.from_vehicle(vehicle, **options))
