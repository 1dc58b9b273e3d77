"""Count the right digits of the attitude at three wind durations, on the stability boundary.

The peer is `control.forced_response`, given its best case: a held deflection and a triangular
wind with every knot on the grid, and the best of five grids. The judge is the closed form, to
120 digits. Run: python benchmarks/digits_on_the_boundary.py
"""

import control
import mpmath as mp
import numpy as np

import tvclin as tv

BETA, B, PEAK = 0.5, 0.1, 0.1


def digits(found: float, exact: float) -> float:
    """Return how many decimal digits of `found` are right, at most 16."""
    error = abs(found / exact - 1.0)
    return min(16.0, -np.log10(error)) if error else 16.0


def exact_attitude(tau_beta: float) -> float:
    """Return the attitude at t = 3 tau with the deflection held on the boundary of K = 0.

    After the wind the growing mode is at rest, and eq (13) with K = 0 is what is left.
    """
    with mp.workdps(120):
        x, t = mp.mpf(tau_beta), mp.mpf(3)
        y = 2 * (1 - mp.exp(-x / 2)) ** 2 / x
        ramps = sum(
            w * (mp.sinh(x * (t - k)) - x * (t - k)) for w, k in ((1, 0), (-2, 0.5), (1, 1))
        )
        return float(-PEAK * 2 / x * (ramps - y * x / 2 * (mp.cosh(x * t) - 1)))


def main() -> None:
    """Print the table."""
    plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=BETA, B=B))
    system = plant.ss()
    print("| tau beta | control.forced_response | tvclin |")
    print("| --- | --- | --- |")
    for tau_beta in (4.0, 10.0, 20.0, 40.0):
        wind = tv.TriangularWind(peak=PEAK, duration=tau_beta / BETA)
        limit = tv.boundary_limit(plant, wind, dead_band=0.0).deflection
        held = tv.linear.ConstantDeflection(limit=limit)
        exact = exact_attitude(tau_beta)
        peer = 0.0
        for steps in (8, 32, 128, 512, 2048):
            times = np.linspace(0.0, 3.0 * wind.duration, 3 * steps + 1)
            inputs = np.stack([held(times), wind(times)])
            outputs = control.forced_response(system, times, inputs).outputs
            peer = max(peer, digits(outputs[0, -1], exact))
        ours = tv.attitude_response(plant, held, wind, [0.0, 3.0 * wind.duration])
        right = digits(ours.outputs["attitude"][-1], exact)
        print(f"| {tau_beta:g} | {peer:.1f} | {right:.1f} |")


if __name__ == "__main__":
    main()
