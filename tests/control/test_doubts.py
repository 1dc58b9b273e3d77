"""What an autopilot warns of on a stable vehicle, and what it does not."""

import warnings

import numpy as np
import pytest

import tvclin as tv

STABLE = tv.Coefficients(mu_alpha=-0.28, mu_delta=2.6)
PLANT = tv.Plant.from_coefficients(STABLE)


@pytest.mark.parametrize("natural_frequency", [0.2, 0.28**0.5, 1.0])
def test_feedback_of_the_angle_of_attack_may_give_back_a_vehicles_own_stiffness(natural_frequency):
    stiffness = (natural_frequency**2 + STABLE.mu_alpha) / STABLE.mu_delta  # of load-minimum gains
    autopilot = tv.Autopilot(attitude_gain=0.0, alpha_gain=stiffness, rate_gain=0.4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        poles = autopilot.close(PLANT).poles()
    assert np.prod(poles).real == pytest.approx(natural_frequency**2, rel=1e-12)


def test_more_than_its_own_is_positive_feedback():
    autopilot = tv.Autopilot(attitude_gain=0.0, alpha_gain=-0.12, rate_gain=0.4)
    with pytest.warns(UserWarning, match=r"attitude_gain \+ alpha_gain = -0\.12 is positive"):
        poles = autopilot.close(PLANT).poles()
    assert poles.real.max() > 0.0


def test_attitude_feedback_of_the_wrong_sign_stays_doubtful_on_a_stable_vehicle():
    autopilot = tv.Autopilot(attitude_gain=-0.05, rate_gain=0.4)
    with pytest.warns(UserWarning, match=r"attitude_gain = -0\.05 is positive feedback"):
        autopilot.margins(PLANT)
