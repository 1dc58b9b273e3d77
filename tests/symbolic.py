"""How the derivations compare expressions, solve linear equations and transform histories."""

import random

import sympy as sp

s, t = sp.symbols("s t")


def equal(left, right, draws=3):
    """Return whether both sides agree to 40 digits at random rational values of all symbols."""
    left, right = sp.sympify(left), sp.sympify(right)
    chance = random.Random(1968)
    symbols = sorted(left.free_symbols | right.free_symbols, key=str)
    for _ in range(draws):
        point = {x: sp.Rational(chance.randint(20, 99), chance.randint(20, 99)) for x in symbols}
        a, b = (sp.N(side.subs(point), 50) for side in (left, right))
        if abs(a - b) > sp.Float("1e-40") * (abs(a) + abs(b)):
            return False
    return True


def solved(equation, unknown):
    """Return the root of an expression that is linear in the unknown."""
    return -equation.subs(unknown, 0) / sp.diff(equation, unknown)


def linear(expression, nominal, signals):
    """Return the linear part in the deviations, which keep the names of their signals."""
    return sum(sp.diff(expression, x).subs(nominal) * x for x in signals)


def exponentials(expression):
    """Return {(rate, power): coefficient} of a sum of terms c t^k e^(rate t)."""
    computed = {}
    for term in sp.Add.make_args(sp.expand(sp.sympify(expression).rewrite(sp.exp))):
        constant, moving = term.as_independent(t)
        rate = sum(sp.diff(f.exp, t) for f in sp.Mul.make_args(moving) if isinstance(f, sp.exp))
        rest = sp.simplify(moving * sp.exp(-rate * t))
        power = sp.degree(rest, t) if rest.has(t) else 0
        key = (sp.expand(rate), power)
        computed[key] = computed.get(key, 0) + constant * (rest / t**power)
    return computed


def transform(pieces):
    """Return the Laplace transform of sum f(t - start) u(t - start), of {start: f}."""
    return sum(
        sp.exp(-start * s) * c * sp.factorial(k) / (s - rate) ** (k + 1)
        for start, f in pieces.items()
        for (rate, k), c in exponentials(f).items()
    )


def from_then_on(f, start):
    """Return f(t + start): what {start: ...} needs for f(t) u(t - start)."""
    return sp.sympify(f).subs(t, t + start)
