"""The closed forms to fifty digits, and kernels with a compiler, a cache or threads or without."""

import os
import subprocess
import sys
import warnings
from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest

from tvclin.base.package_warnings import MachineWarning
from tvclin.boundary import closed_forms
from tvclin.kernels import choice
from tvclin.kernels.small_roots import small_roots
from tvclin.kernels.switches import switches

pytestmark = pytest.mark.usefixtures("as_users_have_it")

CASES = 20_000


@pytest.fixture
def cases():
    """Return p and K over the whole range, the ends of K included."""
    rng = np.random.default_rng(5)
    p = np.exp(rng.uniform(np.log(5e-4), np.log(20.0), CASES))
    K = np.where(rng.random(CASES) < 0.5, rng.random(CASES), 1.0 - 10.0 ** rng.uniform(-16, 0))
    K[:100], K[100:200] = 0.0, 1.0
    return p, K


def exact_12(p, K):
    """Solve s + c (1 - e^(-s)) = L to 50 digits."""
    with mp.workdps(50):
        p, K = mp.mpf(float(p)), mp.mpf(float(K))
        L = -mp.log(2 * mp.exp(-p) - mp.exp(-2 * p))
        if K == 1:
            return L / p
        c = K / (1 - K)
        s = L / (1 + c)
        for _ in range(60):
            s -= (s - c * mp.expm1(-s) - L) / (1 + c * mp.exp(-s))
        return -mp.expm1(-s) / (p * (1 - K))


@pytest.mark.thorough
def test_the_boundary_is_exact_to_1e_15(cases):
    p, K = (a[::97] for a in cases)
    result = closed_forms.solve_triangular(p, K)
    error = [float(abs(mp.mpf(y) / exact_12(*at) - 1)) for y, *at in zip(result, p, K, strict=True)]
    assert max(error) <= 1e-15


def test_the_boundary_of_a_very_long_wind_tends_to_its_limits():
    p = np.array([1e3, 1e6])
    # K = 1: y = L/p = 1 - ln 2/p;  K = 0: y = 1/p
    np.testing.assert_allclose(
        closed_forms.solve_triangular(p, np.ones(2)), 1.0 - np.log(2.0) / p, rtol=1e-15
    )
    np.testing.assert_allclose(closed_forms.solve_triangular(p, np.zeros(2)), 1.0 / p, rtol=1e-15)


def test_with_drift_the_printed_equation_is_met(cases):
    p, K = (a[:2000] for a in cases)
    rng = np.random.default_rng(6)
    beta, b1 = rng.uniform(0.1, 1.0, p.size), rng.uniform(-0.02, 0.1, p.size)
    b2 = b1 - rng.uniform(0.0, 0.09, p.size)
    result = closed_forms.solve_triangular_with_drift(2.0 * p, K, beta, b1, b2)
    error = []
    with mp.workdps(50):
        for y, *at in list(zip(result.limit, p, K, beta, b1, b2, strict=True))[::53]:
            p_, K_, beta_, b1_, b2_ = (mp.mpf(float(a)) for a in at)
            K1, kappa, rho = (beta_ + b2_) / (beta_ + b1_), (b1_ - b2_) / (beta_ + b1_), b1_ / beta_
            L = -mp.log(2 * mp.exp(-p_) - mp.exp(-2 * p_))

            def left(z, K_=K_, K1=K1, kappa=kappa, rho=rho, L=L):
                x = K_ * z
                curve = (mp.exp(-rho * x) - 1 + rho * x) / rho**2
                return -K1 * mp.expm1(x - L) - (1 - K_) * z - kappa * (x + curve)

            root = mp.findroot(left, mp.mpf(float(y)) * p_)
            error.append(float(abs(mp.mpf(float(y)) * p_ / root - 1)))
    assert len(error) > 30
    assert max(error) <= 1e-13


def test_a_case_does_not_depend_on_its_batch(cases):
    p, K = cases
    whole = closed_forms.solve_triangular(p, K)
    for first, last in ((0, 1), (3, 20), (77, 1000), (CASES - 5, CASES)):
        part = closed_forms.solve_triangular(p[first:last], K[first:last])
        np.testing.assert_array_equal(part, whole[first:last])


def test_slices_make_up_the_cases(monkeypatch):
    monkeypatch.setattr(choice, "thread_count", lambda: 3)
    done = []
    choice.in_slices(lambda first, last: done.append((first, last)), 1000, 10.0)
    edges = [first for first, _ in sorted(done)] + [1000]
    assert sorted(done) == list(pairwise(edges))
    assert edges[0] == 0
    assert len(done) > 3  # so that nobody waits long for the slowest
    assert all(edge % 64 == 0 for edge in edges[:-1])
    done.clear()
    choice.in_slices(lambda first, last: done.append((first, last)), 1000, 0.001)
    assert done == [(0, 1000)]


def test_the_number_of_threads_can_be_bounded(monkeypatch):
    monkeypatch.setenv(choice.VARIABLE, "1")
    assert choice.thread_count() == 1
    monkeypatch.setenv(choice.VARIABLE, "100000")
    most = choice.thread_count()
    monkeypatch.setenv(choice.VARIABLE, "nonsense")
    assert choice.thread_count() == most


@pytest.fixture
def without_numba(monkeypatch):
    """Let there be no compiler, in a process that has done no work yet."""
    monkeypatch.setattr(choice, "available", lambda: False)
    monkeypatch.setattr(choice, "_plain_work", choice._PlainWork())


@pytest.mark.usefixtures("without_numba")
def test_without_a_compiler_plain_python_runs():
    with choice.pinned(True):
        assert choice.fastest(small_roots, 1.0) is small_roots
    with pytest.warns(UserWarning, match=r"takes about 81 s or more without numba.*pip .*fast"):
        assert choice.fastest(small_roots, 80.0) is small_roots


@pytest.mark.usefixtures("without_numba")
def test_many_short_calls_without_a_compiler_are_warned_of_once_when_they_come_to_five_seconds():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(499):
            choice.fastest(small_roots, 0.01)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        for _ in range(1000):
            choice.fastest(small_roots, 0.01)
    assert len(said) == 1
    assert said[0].category is MachineWarning


@pytest.mark.usefixtures("without_numba")
def test_calls_alike_without_a_compiler_are_warned_of_at_the_first():
    with pytest.warns(UserWarning, match="about 20 s"), choice.repeated(2000):
        choice.fastest(small_roots, 0.01)
    assert choice._plain_work.seconds == 0.01


@pytest.mark.parametrize(("value", "disabled"), [("1", True), ("0", False), ("", False)])
def test_numba_told_to_compile_nothing_is_as_if_it_were_not_installed(monkeypatch, value, disabled):
    """Numba hands functions back then, to which arrays of records are no objects."""
    pytest.importorskip("numba")
    monkeypatch.setattr(choice, "_plain_work", choice._PlainWork())
    monkeypatch.setenv("NUMBA_DISABLE_JIT", value)
    assert choice.available() is not disabled
    if disabled:
        with choice.pinned(True):
            assert choice.fastest(small_roots, 1.0) is small_roots
        with pytest.warns(UserWarning, match=r"without numba.* with it: unset NUMBA_DISABLE_JIT"):
            assert choice.fastest(small_roots, 80.0) is small_roots


def test_a_law_flies_where_numba_compiles_nothing():
    """A flight in the least wind that kills it and one that does not, judged by (4b)."""
    code = (
        "import numpy as np, tvclin as tv\n"
        "from tvclin.kernels.choice import pinned\n"
        "plant = tv.Plant.from_vehicle(tv.load_vehicle('configuration-i'), 'fixed-path')\n"
        "wind = tv.TriangularWind(peak=0.09, duration=7.5)\n"
        "limit = tv.boundary_limit(plant, wind).deflection * np.array([-0.97, -1.03])\n"
        "law = tv.TrimLaw(plant)\n"
        "with pinned(True):\n"
        "    flown = tv.fly_many(plant, law, wind, deflection_limit=limit, sample_rate=100)\n"
        "print(*flown.status)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )
    assert done.stdout.split() == ["lost", "survived"]


def test_what_runs_does_not_depend_on_what_was_called_before(monkeypatch):
    monkeypatch.setattr(choice, "available", lambda: True)
    for _ in range(1000):
        assert choice.fastest(small_roots, 0.01) is small_roots


def test_calls_alike_are_worth_together_what_one_is_not(monkeypatch):
    monkeypatch.setattr(choice, "available", lambda: True)
    monkeypatch.setattr(choice, "machine_code", lambda _: "compiled")
    with choice.repeated(1000):
        assert choice.fastest(small_roots, 0.01) == "compiled"
        assert choice.fastest(small_roots, 1e-6) is small_roots
    assert choice.fastest(small_roots, 0.01) is small_roots


@pytest.fixture
def imported(monkeypatch):
    """Return a set that is empty in a process without numba; names what loads machine code."""
    names = set()

    def machine_code(function):
        names.add("numba")
        return "compiled"

    monkeypatch.setattr(choice, "available", lambda: True)
    monkeypatch.setattr(choice, "machine_code", machine_code)
    monkeypatch.setattr(choice, "_is_imported", lambda: bool(names))
    return names


def test_a_command_loads_machine_code_once_all_its_calls_are_worth_it(monkeypatch, imported):
    monkeypatch.setattr(choice, "_is_cached", lambda function: True)
    plain = [small_roots, small_roots, small_roots]
    for _ in range(2):  # in each process
        imported.clear()
        with choice.in_a_command():
            assert [choice.fastest(small_roots, 0.13) for _ in range(4)] == [*plain, "compiled"]
            assert choice.fastest(small_roots, 0.001) == "compiled"  # it is loaded
            assert choice.fastest(switches, 0.001) is switches
            assert choice.fastest(switches, 0.03) == "compiled"  # numba is imported
    assert choice.fastest(small_roots, 0.13) == "compiled"
    with choice.in_a_command():  # of a process in which numba is imported
        assert choice.fastest(small_roots, 0.03) == "compiled"


def test_a_command_loads_machine_code_for_short_calls_that_together_are_worth_it(
    monkeypatch, imported
):
    monkeypatch.setattr(choice, "_is_cached", lambda function: True)
    with choice.in_a_command():
        calls = [choice.fastest(small_roots, 0.009) for _ in range(4)]
        assert calls == [small_roots] * 4  # too little work for the import
        choice.announce(1.0)
        assert choice.fastest(small_roots, 0.009) == "compiled"
        assert [choice.fastest(switches, 0.009) for _ in range(3)] == [switches] * 2 + ["compiled"]
    choice.announce(1.0)  # of no command
    assert choice.fastest(switches, 0.009) is switches


def test_commands_compile_a_kernel_once_their_calls_come_to_two_seconds(
    monkeypatch, tmp_path, imported
):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(choice, "_cached", set())

    def command():
        imported.clear()
        with choice.in_a_command():
            return [choice.fastest(small_roots, 0.45) for _ in range(2)]

    plain = [small_roots, small_roots]
    with choice.compiling_nothing():  # work that must not wait counts nothing
        assert [command() for _ in range(3)] == [plain] * 3
    assert [command() for _ in range(3)] == [plain, plain, ["compiled", "compiled"]]
    assert choice.fastest(small_roots, 0.45) is small_roots  # no command, and nothing cached
    (sums,) = tmp_path.rglob("*.seconds")
    sums.write_text("damaged")
    assert command() == plain
    imported.clear()
    with choice.in_a_command():  # too little work of the command for the import
        assert choice.fastest(small_roots, 0.3) is small_roots
    assert float(sums.read_text()) == 0.9


def test_little_work_does_not_load_the_compiler():
    code = (
        "import sys, numpy as np\n"
        "from tvclin.boundary.closed_forms import triangular_limit\n"
        "triangular_limit(np.ones(100), 0.5)\n"
        "sys.exit('numba' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.thorough
def test_where_no_cache_can_be_written_kernels_work_all_the_same(tmp_path):
    pytest.importorskip("numba")
    code = (
        "import numba.core.caching as caching\n"
        "caching.CacheImpl._locator_classes = []\n"
        "import numpy as np\n"
        "from tvclin.numerics import polynomials\n"
        "from tvclin.kernels.choice import pinned\n"
        "with pinned(True): print(polynomials.roots(np.array([1.0, -6.0, 11.0, -6.0])).sum())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert abs(float(done.stdout) - 6.0) <= 1e-14
