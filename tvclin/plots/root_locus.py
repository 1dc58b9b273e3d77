"""Pole map of a plant, and the root locus of a loop: closed-loop poles over the loop gain.

The poles are eigenvalues, at factors that resolve each branch and the points where poles meet. Of
`control.root_locus_map` neither is used: for a loop with bending and slosh it chooses 120 factors
up to 3e30, from the polynomials of the loop, its branches do not pass through those points, and
discrete poles stay in the z plane. `control.pole_zero_map` draws no residues, and its import takes
longer than these figures, which do without.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.errors import InputError, different, instance, nonnegative, one_of, single
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.margins.loop import Loop, SampledLoop
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import Modes, all_modes
from tvclin.linear.plant import MODELS, Plant
from tvclin.numerics import polynomials
from tvclin.numerics.loops import Rational
from tvclin.numerics.state_space import Matrices, pade_delay, series
from tvclin.plots.curves import Column, Curves
from tvclin.plots.loop_samples import (
    MODE,
    LoopSamples,
    corner_frequencies,
    margin_marks,
    sampled,
    title,
)
from tvclin.plots.style import (
    COLOURS,
    INK,
    MARKS,
    WARM,
    Mark,
    control_plot,
    cycle,
    draw_marks,
    fine_grid,
    literal,
    named_once,
    numbered,
    write_numbers,
)
from tvclin.vehicle.coefficients import Coefficients

if TYPE_CHECKING:
    from control import ControlPlot
    from matplotlib.axes import Axes


def pole_map(coefficients: Coefficients, models: Sequence[str] = MODELS) -> ControlPlot:
    """Draw the poles of the models, each with its residue from deflection to attitude.

    The right panel enlarges the origin.

    Parameters
    ----------
    coefficients : Coefficients
        Coefficients of one vehicle.
    models : sequence of str
        Models to draw.
    """
    import matplotlib.pyplot as plt

    instance("coefficients", coefficients, Coefficients, "see Coefficients.from_vehicle")
    single("coefficients", coefficients.batch)
    models = different("models", tuple(models) if isinstance(models, list) else models)
    models = [one_of("model", model, MODELS) for model in models]
    _, panels = plt.subplots(1, 2, figsize=(10.4, 5.6), layout="constrained")
    modes_of = {model: all_modes(Plant(coefficients, model)) for model in models}
    poles = np.concatenate([modes.poles for modes in modes_of.values()])
    radius_of_all = float(np.abs(poles).max()) or 1.0
    small = np.abs(poles)[np.abs(poles) < radius_of_all / 5]  # those that the right panel enlarges
    inner_radius = 1.6 * float(small.max(initial=0.0)) or radius_of_all / 5
    lines: list[Any] = []
    for axes, radius, min_size in (
        (panels[0], 1.5 * radius_of_all, inner_radius),
        (panels[1], inner_radius, -1.0),  # below every size: also of a pole at the origin
    ):
        _prepare(axes, radius)
        for row, model in enumerate(models):
            lines += _mark_poles(axes, modes_of[model], model, row, (min_size, radius))
    panels[0].set_title("Poles, and residues of attitude per deflection [1/s]")
    panels[1].set_title("Near the origin")
    panels[1].locator_params(axis="x", nbins=6)  # small numbers are long
    if coefficients.name:
        panels[0].figure.suptitle(literal(coefficients.name))
    panels[0].legend(loc="lower center", ncols=2)
    return control_plot(lines, panels)


def _prepare(axes: Axes, radius: float) -> None:
    """Set limits and grid of the axes of a pole map, with the right half plane shaded.

    `radius`: half of the width and the height [1/s].
    """
    axes.axhline(0.0, color="0.6", lw=0.8)
    axes.axvline(0.0, color="0.6", lw=0.8)
    axes.axvspan(0.0, radius, color=WARM, alpha=0.07)
    axes.set(
        xlim=(-radius, radius),
        ylim=(-radius, radius),
        xlabel="real part [1/s]",
        ylabel="imaginary part [rad/s]",
    )
    fine_grid(axes)


def _mark_poles(
    axes: Axes, modes: Modes, model: str, row: int, named: tuple[float, float]
) -> list[Any]:
    """Return the marks of the poles of one model, drawn into axes, with residues at some poles.

    A residue is that from deflection to attitude [1/s]. It is written once for a conjugate pair,
    higher for each further model, so that equal poles do not hide each other.

    `modes`: poles [1/s] and residues. `model`: name of the model. `row`: number of the model, for
    colour and mark. `named`: smallest and largest size [1/s] of poles whose residues are written;
    in the panel of the origin the smallest is -1, so that a pole at zero is included.
    """
    poles, residues = modes.poles.astype(complex), modes.deflection_residues + 0j
    colour, size = cycle(COLOURS)[row], np.abs(poles)
    mark = {"marker": cycle(MARKS)[row], "ms": 8 - row, "mfc": "none", "mew": 1.6}
    lines = axes.plot(poles.real, poles.imag, ls="", color=colour, label=model, **mark)
    smallest, largest = named
    inside = (size > smallest) & (size <= largest) & (poles.imag >= 0.0)  # one of each pair
    lift = 12 + 14 * (row if smallest >= 0.0 else row % 2)  # the panel of the origin has less room
    for pole, residue in zip(poles[inside], residues[inside], strict=True):
        numbers = (pole, residue) if pole.imag else (pole.real, residue.real)
        axes.annotate(
            "{:.4g}: {:.4g}".format(*numbers),
            (pole.real, pole.imag),
            xytext=(0, lift),
            textcoords="offset points",
            ha="center",
            fontsize=9.5,
            color=colour,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
        )
    return lines


_STEP_OVER_SIZE, _STEP_OVER_DISTANCE = 0.015, 0.5
"""Largest step of a pole, over its size and over its distance from the nearest other one."""
_REFINEMENTS, _PARTS = 5, 4
"""Number of refinements of the factors, and of the parts into which each divides a long step."""
_MIN_STEP = 0.02 * _STEP_OVER_SIZE
"""A step of a pole below this is not divided, over the smallest size of interest."""
_FAR = 0.2
"""The sample rate over the farthest pole of a sampled loop, which z = 0 would put at infinity."""
_HALVINGS = 60
"""Bisections for the gain at which two real poles meet: more than a float has bits."""
_MEETING_FRACTIONS = np.linspace(0.0, 1.0, 9)[1:-1] ** 2
"""Where poles meet they move with the root of the gain: parts of the step to the next gain."""


@dataclass(frozen=True, eq=False)
class LocusPoles:
    """The poles of one loop, whose gain is multiplied by a factor.

    `poles`, `zeros`: of the loop, with the approximation of its delay [1/s], ``(n,)`` and ``(m,)``.
    `closed`: from factors ``(k,)`` to closed-loop poles [1/s], ``(k, n)``, in any order.
    """

    poles: AnyArray
    zeros: AnyArray
    closed: Callable[[FloatArray], AnyArray]

    @classmethod
    def of(cls, loop: Loop, order: int) -> LocusPoles:
        """Return the poles of one loop with a Pade approximation of its delay, of this order.

        Poles of a sampled loop, where the delay is exact, are s = ln(z)/h of its discrete poles z.

        The form of a loop is a fraction of polynomials, or state space A, B, C with the direct term
        D, of which its first case is drawn. A zero that is at infinity is NaN there. The zeros of a
        Pade approximation are its poles, mirrored in the imaginary axis.
        """
        if isinstance(loop.form, Rational):
            return cls._of_polynomials(loop, order)
        form, k = loop.form, loop.form.case[0]  # k: index of the matrices of the first case
        A, B, C, D = form.A[k], form.B[k, :, np.newaxis], form.C[k, np.newaxis], form.direct[0]
        zeros = form.zeros()[0].astype(complex)
        zeros = zeros[~np.isnan(zeros)]
        if isinstance(loop, SampledLoop):  # matrices of w, the bilinear image of z
            to_s = partial(_in_s_plane, half=0.5 * float(loop.period))
            return cls._of_system((A, B, C, np.reshape(D, (1, 1))), zeros, to_s)
        pade = pade_delay(float(loop.delay), order)
        pade_matrix, *_ = pade  # A of the approximation
        mirrored = -np.linalg.eigvals(pade_matrix).astype(complex)
        system = series((A, B, C, np.zeros((1, 1))), pade)
        return cls._of_system(system, np.concatenate([zeros, mirrored]), np.asarray)

    @classmethod
    def _of_polynomials(cls, loop: Loop, order: int) -> LocusPoles:
        """Return the locus of a loop of polynomials, which resolve poles that meet more closely.

        `order`: order of the Pade approximation of its delay. With numerator n and denominator d of
        the loop, highest power first, closed-loop poles are roots of d + k n at the factor k.
        """
        above, below = np.trim_zeros(loop.numerator, "f"), loop.denominator
        delay = float(loop.delay)
        if delay > 0.0:
            import control

            # for a delay of 1 s, then s replaced by s delay, with a constant term of one
            powers = delay ** np.arange(order, -1.0, -1.0)
            top, bottom = (powers * p / p[-1] for p in control.pade(1.0, order))
            above, below = polynomials.multiply(above, top), polynomials.multiply(below, bottom)
        padded = np.pad(above, (below.size - above.size, 0))  # as long as the denominator

        def closed(factors: FloatArray) -> AnyArray:
            """Return b closed-loop poles [1/s] at m factors ``(m,)`` on the gain, ``(m, b)``."""
            return polynomials.roots(below + factors[:, np.newaxis] * padded).astype(complex)

        return cls(closed(np.zeros(1))[0], polynomials.roots(above).astype(complex), closed)

    @classmethod
    def _of_system(
        cls, system: Matrices, zeros: AnyArray, to_s: Callable[[AnyArray], AnyArray]
    ) -> LocusPoles:
        """Return the locus of matrices: the eigenvalues of A - k B C/(1 + k D), in the s plane.

        k is the factor on the loop gain, 1 for the loop itself. `system`: A, B, C and D of the
        loop L, fed back with a minus sign, in the s or the w plane. `zeros`: zeros of L in that
        plane. `to_s`: function from poles or zeros in that plane to the s plane [1/s].
        """
        A, B, C, D = system

        def closed(factors: FloatArray) -> AnyArray:
            """Return b closed-loop poles [1/s] at m factors ``(m,)`` on the gain, ``(m, b)``."""
            k = factors[:, np.newaxis, np.newaxis]
            return to_s(np.linalg.eigvals(A - k / (1.0 + k * D) * (B @ C)).astype(complex))

        return cls(closed(np.zeros(1))[0], to_s(zeros), closed)

    def refined(self, factors: FloatArray, min_size: float, max_size: float) -> FloatArray:
        """Return gain factors, rising, between which poles below `max_size` take small steps.

        The factors at which two poles meet on the real axis are included.

        `factors`: initial factors, rising. `min_size`: size of a pole [1/s] below which its step is
        relative to `min_size`. `max_size`: size of a pole [1/s] above which steps may be larger.
        """
        for _ in range(_REFINEMENTS):
            poles = self.closed(factors)
            # step of each pole: to the nearest pole at the factor before
            steps = np.abs(poles[1:, :, np.newaxis] - poles[:-1, np.newaxis, :]).min(axis=-1)
            sizes = np.abs(poles[1:])
            distances = np.abs(poles[1:, :, np.newaxis] - poles[1:, np.newaxis, :])
            nearest = np.where(np.eye(sizes.shape[-1]) > 0.0, np.inf, distances).min(axis=-1)
            max_step = np.minimum(
                _STEP_OVER_SIZE * np.maximum(sizes, min_size), _STEP_OVER_DISTANCE * nearest
            )
            long = (steps > np.maximum(max_step, _MIN_STEP * min_size)) & (sizes < 2.0 * max_size)
            intervals = np.flatnonzero(np.any(long, axis=-1))
            between = np.linspace(factors[intervals], factors[intervals + 1], _PARTS + 1)
            factors = np.unique(np.concatenate([factors, between.ravel()]))
        for _ in range(2):  # the second time between factors that the first has added
            factors = self._with_meetings(factors)
        return factors

    def _with_meetings(self, factors: FloatArray) -> FloatArray:
        """Return rising factors on the loop gain, ``(n,)``, and further ones where real poles meet.

        `factors`: those without the further ones. Between two factors with different numbers of
        real poles the meeting is found by bisection. Near it poles move with the root of the
        factor, so that the fractions of the step on both sides, `_MEETING_FRACTIONS`, are squares.
        """
        count = self._count_real(factors)
        intervals = np.flatnonzero(count[1:] != count[:-1])
        low, high, before = factors[intervals], factors[intervals + 1], count[intervals]
        ends = low, high
        if not intervals.size:
            return factors
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            same = self._count_real(middle) == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        close = [
            low[:, np.newaxis] + (end - low)[:, np.newaxis] * _MEETING_FRACTIONS for end in ends
        ]
        return np.unique(np.concatenate([factors, low, *(row.ravel() for row in close)]))

    def _count_real(self, factors: FloatArray) -> IndexArray:
        """Return the number of real closed-loop poles at each factor on the loop gain, ``(n,)``."""
        return np.sum(np.imag(self.closed(factors)) == 0.0, axis=-1)

    def branches(self, factors: FloatArray) -> AnyArray:
        """Return n poles at each of k rising factors, ``(k, n)``, a column for each branch.

        Poles of successive factors are assigned with the smallest sum of squared distances.
        """
        from scipy.optimize import linear_sum_assignment  # late: it takes 0.2 s to import

        poles = self.closed(factors)
        for k in range(1, len(poles)):
            distances = np.abs(poles[k - 1][:, np.newaxis] - poles[k])
            _, order = linear_sum_assignment(distances**2)
            poles[k] = poles[k][order]
        return poles


def _in_s_plane(w: AnyArray, half: float) -> AnyArray:
    """Return s = ln(z)/h [1/s] of poles or zeros in the w plane; `half`: half the period h [s].

    The bilinear rule is z = (1 + w h/2)/(1 - w h/2). A pole z = 0, whose s is at infinity, is put
    at the distance 2 pi/(h `_FAR`) from the origin; of a zero at infinity s is NaN.
    """
    with np.errstate(divide="ignore", invalid="ignore"):  # z at infinity
        z = (1.0 + w * half) / (1.0 - w * half) + 0.0  # an imaginary part of 0, not -0, of a real z
        size = np.maximum(np.abs(z), np.exp(-2.0 * np.pi / _FAR))
        return (np.log(size) + 1j * np.angle(z)) / (2.0 * half)


_END: dict[str, Any] = {"ls": "", "color": INK, "zorder": 4}
_MAX_OVER_NYQUIST = 1.2
"""Largest pole of a sampled loop in the frame, over half its rate."""
_HEIGHT_OVER_MODE = 1.15
"""Height of the frame of the modes, over the frequency of the fastest one."""


def root_locus_chart(
    autopilot: Autopilot | Loop, plant: AnyPlant | None = None, gains: ArrayLike | None = None
) -> ControlPlot:
    """Draw the root locus: the closed-loop poles over a factor on the loop gain.

    Each branch leads from a pole of the loop to a zero or to infinity. For a flexible vehicle a
    further panel shows the modes, by their names, with a stretched real axis.

    Parameters
    ----------
    autopilot, plant
        One autopilot and one plant of any model, or one loop alone. Discrete poles z of a sampled
        loop are drawn as s = ln(z)/h, up to half the sample rate: the unit circle is the imaginary
        axis.
    gains : array_like, optional
        Factors on the loop gain, zero or positive, ``(n,)``; by default from zero to beyond the
        gain-increase margin. The factor 1 is the loop itself.

    Raises
    ------
    InputError
        For a batch, a loop with a plant, and factors that are not a row of numbers from zero on.

    Notes
    -----
    A delay is its Pade approximation, whose poles are outside the frame.
    """
    import matplotlib.pyplot as plt

    samples = sampled("root_locus_chart", autopilot, plant)
    locus = LocusPoles.of(samples.loop, samples.pade_order)
    (poles,) = locus.closed(np.ones(1))  # of the loop itself, at the factor one
    radii = _radii(samples, poles)  # [1/s]: of the whole locus, and of the origin if that is denser
    factors = _default_factors(locus, samples, radii) if gains is None else _checked_factors(gains)
    branches = locus.branches(factors)
    # panels of these radii, and one of the modes if there are any
    count = len(radii) + bool(samples.modes)
    rows: Any = [[0, 0]] if count == 1 else [[0, 1], [2, 2]][: count - 1]
    size = (8.6, 7.4) if count == 1 else (10.4, 6.4 * len(rows))
    figure, placed = plt.subplot_mosaic(rows, figsize=size, layout="constrained")
    panels = [placed[k] for k in range(count)]
    # ends of branches that lead neither to a zero nor out of the frame
    ends = branches[-1][np.abs(branches[-1]) < radii[0]]
    ended = f"end of the locus (factor {factors[-1]:.3g})"
    highest = samples.loop.max_frequency().item()
    marks = [
        *named_once(_pole_mark(pole, highest) for pole in poles[np.argsort(-poles.imag)]),
        *_axis_marks(samples),
        *named_once(Mark(end.real, end.imag, shape="|", name=ended) for end in ends),
    ]
    lines: list[Any] = []
    for axes in panels:
        lines += _draw_locus(axes, locus, _within(branches, samples.loop))
    for axes, radius in zip(panels, radii, strict=False):
        _frame_round(axes, radius, locus.poles)
    shown = [marks]  # the marks of each panel
    if len(radii) > 1:
        panels[0].set_title("the whole locus", fontsize="medium")
        panels[1].set_title("near the origin", fontsize="medium")
        # the whole locus has the numbers outside the other panel alone, and none beside modes
        outside = (not samples.modes and not mark.inside(panels[1]) for mark in marks)
        shown.insert(
            0, [numbered(mark, number) for mark, number in zip(marks, outside, strict=True)]
        )
    if samples.modes:
        _frame_modes(panels[-1], samples)
        shape, colour = MODE
        begun: Any = {"shape": shape, "name": "modes in the vehicle (factor 0)", "colour": colour}
        named = [Mark(mode.pole.real, mode.pole.imag, mode.name, **begun) for mode in samples.modes]
        shown.append([*(numbered(mark, with_number=False) for mark in marks), *named_once(named)])
    for axes, drawn in zip(panels, shown, strict=True):
        lines += draw_marks(axes, drawn)
    name = "Root locus of the loop gain"
    name += ", s = ln(z)/h" if isinstance(samples.loop, SampledLoop) else ""
    figure.suptitle(title(name, samples))
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    write_numbers(*zip(panels, shown, strict=True))
    return control_plot(lines, panels, _locus_curves(factors, branches, samples))


def _within(branches: AnyArray, loop: Loop) -> AnyArray:
    """Return branches of poles, interrupted where a sampled pole wraps around half the rate.

    `branches`: poles [1/s] at n factors on the gain, a column for each of b branches, ``(n, b)``.
    `loop`: the loop, sampled or continuous.
    """
    if not isinstance(loop, SampledLoop):
        return branches
    steps = np.abs(np.diff(branches.imag, axis=0, prepend=branches.imag[:1]))
    half_rate = float(loop.max_frequency()[0, 0])  # [rad/s], of one loop
    return np.where(steps > half_rate, np.nan, branches)


def _checked_factors(gains: ArrayLike) -> FloatArray:
    """Return factors on the loop gain, rising, ``(n,)``.

    `gains`: factors of the user; `InputError` unless they are a row of two or more from zero on.
    """
    factors = nonnegative("gains", gains)
    if factors.ndim != 1 or factors.size < 2:
        raise InputError(
            "gains must be a row of two or more factors on the loop gain; got the shape"
            f" {factors.shape}"
        )
    return np.unique(factors)


def _default_factors(locus: LocusPoles, samples: LoopSamples, radii: list[float]) -> FloatArray:
    """Return factors on the loop gain, ``(n,)``, rising from zero to beyond a change of stability.

    Of an unstable loop to beyond the second change. `locus`: poles over factors. `samples`: the
    loop with its margins. `radii`: radii of the panels [1/s], falling, in which the branches are
    to be smooth. The last factor is twice that change, from 3 to 1e4; without a change it is 10.
    """
    crossings = samples.margins.crossings.gain_factors  # with which poles cross the imaginary axis
    crossings = np.sort(crossings[np.isfinite(crossings) & (crossings > 0.0)])
    above = crossings[crossings > 1.0][: 1 if samples.margins.stable else 2]
    top = float(np.clip(2.0 * above.max(initial=5.0), 3.0, 1e4))
    factors = np.concatenate([np.geomspace(1e-6 * top, top, 400), np.linspace(0.0, top, 200)])
    factors = np.unique(np.concatenate([factors, [1.0], crossings[crossings < top]]))
    return locus.refined(factors, min_size=radii[-1], max_size=radii[0])


def _radii(samples: LoopSamples, poles: AnyArray) -> list[float]:
    """Return the radii [1/s] of one or two panels around s = 0, the outer radius first.

    The outer panel has all poles but the delay's; the inner one the poles of the rigid vehicle and
    the slow closed-loop poles; with bending modes, whose poles have panels of their own, up to the
    frequency of the gain margin instead. It is omitted if its radius is near the outer one.
    `samples`: the loop. `poles`: its closed-loop poles [1/s].
    """
    order = samples.loop.form.open_poles().shape[-1]  # number of poles without the delay
    sizes = np.sort(np.abs(poles))[:order]  # the poles of the delay are the largest
    if isinstance(samples.loop, SampledLoop):  # faster poles decay within a few samples
        half_rate = float(samples.loop.max_frequency()[0, 0])  # [rad/s], of one loop
        sizes = sizes[sizes <= _MAX_OVER_NYQUIST * half_rate]
    highest = np.array([samples.margins.gain_increase_frequency])  # NaN without this margin
    corners = [*corner_frequencies(samples.loop), *sizes]
    outer = 1.2 * float(np.nanmax([*corners, *highest]))
    rigid = np.abs(samples.airframe)  # poles of the rigid vehicle
    slow = [*rigid, *sizes[sizes < 0.25 * outer]]
    if samples.modes:
        slow = [*rigid, *highest[np.isfinite(highest)]]
    inner = 1.5 * float(max(slow, default=outer))
    return [outer, inner] if inner < 0.35 * outer else [outer]


def _pole_mark(pole: complex, highest: float) -> Mark:
    """Return the mark of a closed-loop pole, with a number for one of each pair.

    `highest`: half the sample rate [rad/s], where a pole, that of a real z < 0, has no conjugate;
    infinite in continuous time.
    """
    sign = "+" if np.isclose(pole.imag, highest, rtol=1e-12) else "±"
    text = f"{pole.real:.3g}" if pole.imag == 0.0 else f"{pole.real:.3g} {sign} {pole.imag:.3g}j"
    text = text if pole.imag >= 0.0 else ""
    name = "closed-loop poles (factor 1)"
    return Mark(pole.real, pole.imag, text, shape="D", name=name, colour=COLOURS[1])


def _axis_marks(samples: LoopSamples) -> list[Mark]:
    """Return the marks of a locus on the imaginary axis at the gain margins of a loop.

    `samples`: the loop with its margins. The factors on the loop gain there are the gain margins;
    an aero margin is by how much the gain may fall. A mark has its mirror image below.
    """
    marks = margin_marks(samples, lambda omega: (0.0, omega))[:2]  # without the phase margin
    aero_margin, gain_increase = samples.margins.aero_margin, samples.margins.gain_increase
    # in the order of the marks
    factors = (1.0 / aero_margin if aero_margin else np.inf, gain_increase)
    axis_marks = []
    for mark, factor in zip(marks, factors, strict=False):
        axis_marks.append(replace(mark, text=f"factor {factor:.3g}" if mark.text else ""))
        if mark.y > 0.0:
            axis_marks.append(replace(mark, y=-mark.y, text="", name=""))
    return axis_marks


def _draw_locus(axes: Axes, locus: LocusPoles, branches: AnyArray) -> list[Any]:
    """Return the drawn lines of poles, zeros and branches in axes.

    `locus`: locus of a loop. `branches`: its closed-loop poles [1/s] at n factors, ``(n, b)``.
    """
    axes.axhline(0.0, color="0.6", lw=0.8, zorder=0.5)
    axes.axvline(0.0, color="0.4", lw=1.0, zorder=0.5)
    lines = axes.plot(locus.poles.real, locus.poles.imag, "x", label="poles of the loop", **_END)
    lines += axes.plot(
        locus.zeros.real, locus.zeros.imag, "o", mfc="none", label="zeros of the loop", **_END
    )
    for branch in branches.T:
        lines += axes.plot(branch.real, branch.imag, color=INK, lw=1.6, zorder=3, label="_locus")
    return lines


def _frame_round(axes: Axes, radius: float, poles: AnyArray) -> None:
    """Set a square frame of axes around the origin, wider if poles inside lie to the right.

    `radius`: half of its height [1/s]. `poles`: open-loop poles [1/s].
    """
    rightmost = np.max(poles.real[np.abs(poles) < radius], initial=0.0)
    _frame(axes, (-1.2 * radius, max(0.6 * radius, 1.2 * float(rightmost))), (-radius, radius))
    axes.set_aspect("equal", adjustable="box")


def _frame_modes(axes: Axes, samples: LoopSamples) -> None:
    """Set the frame of axes to the upper half plane up to the fastest mode, as for factor 1.

    `samples`: the loop with its modes.
    """
    poles = np.array([(mode.pole, mode.closed_pole) for mode in samples.modes])
    width = 2.0 * float(np.nanmax(np.abs(poles.real)))
    height = _HEIGHT_OVER_MODE * float(np.nanmax(poles.imag))
    _frame(axes, (-width, 0.6 * width), (0.0, height))
    axes.set_title("modes, real axis stretched", fontsize="medium")


def _frame(axes: Axes, xlim: tuple[float, float], ylim: tuple[float, float]) -> None:
    """Set limits, labels and grid of the axes of a locus, with the right half plane shaded.

    `xlim`, `ylim`: ends of real and imaginary axis [1/s].
    """
    axes.axvspan(0.0, xlim[1], color=WARM, alpha=0.07, zorder=0.5)
    axes.set(xlim=xlim, ylim=ylim)
    axes.set(xlabel="real part of s [1/s]", ylabel="imaginary part of s [rad/s]")
    fine_grid(axes)


def _locus_curves(factors: FloatArray, branches: AnyArray, samples: LoopSamples) -> Curves:
    """Return the closed-loop poles [1/s] over factors on the loop gain, a curve for each branch.

    `factors`, `branches`: n factors, and b poles at each, ``(n, b)``. `samples`: the loop with its
    modes; a branch that starts at a mode has its name.
    """
    names = [f"pole {number}" for number in range(1, branches.shape[-1] + 1)]
    for mode in samples.modes:
        if factors[0] == 0.0 and np.isfinite(mode.pole):
            names[int(np.argmin(np.abs(branches[0] - mode.pole)))] = mode.name
    columns = []
    for name, branch in zip(names, branches.T, strict=True):
        columns.append(Column(f"{name} real part", branch.real, "1/s"))
        columns.append(Column(f"{name} imaginary part", branch.imag, "rad/s"))
    words = f"{samples.words}; {samples.verdict}"
    return Curves("root-locus", words, "factor on the loop gain [-]", factors, tuple(columns))
