"""Equations of motion as an expert writes them for heyoka and SciPy, by hand where a case is well known.

A Taylor method pays for every product of two series, and not for sums or numbers. Charges are therefore numbers, and
what is ignorable is a quadrature behind the other variables, with a start of 0. Around a black hole r and cos θ are
integrated in the second order, because the squares of their rates in Mino's time are polynomials. Kepler's problem is
integrated in polar coordinates. Any other metric has q' = g^ab (p_b − A_b) and p' = ∂L/∂q at fixed q', which needs no
derivative of an inverse. Newton's law is q'' = −∂V; t is γ then, and nobody integrates the action s. """

import math
import operator
import sys
from ast import Div, Pow
from decimal import Decimal

import heyoka as hy
import numpy as np
from expectations import DIGITS, NAMES, OPERATIONS, Formulas, Hamiltonian, Newtonian, read
from mpmath import mp

NUMERIC = {name: getattr(math, name) for name in NAMES} | {"ln": math.log, "log": math.log}
POWERS = {}  # written_out replaces them by these products.
ROOTS = {}  # the arguments of square roots


def power(base, exponent):
    """The series of a general power divides by its base, which may be 0: small powers will be products."""
    if isinstance(base, hy.expression) and exponent in range(3, 33):
        products = [1.0, written_out(base)]
        for n in range(2, int(exponent) + 1):
            products.append(products[n // 2] * products[n // 2] * products[n % 2])
            POWERS[base ** float(n)] = products[n]
    return operator.pow(base, exponent)


def written_out(expression):
    """The same with products, after it was differentiated: a product has longer derivatives."""
    return hy.subs(expression, POWERS)


def root(u):
    u = hy.expression(0.0) + u
    ROOTS[hy.sqrt(u)] = u
    return hy.sqrt(u)


def quotient(u, v):
    """The series of u v^(-1/2) and that of its derivative are short."""
    is_root = isinstance(v, hy.expression) and v in ROOTS
    return u * ROOTS[v] ** -0.5 if is_root else operator.truediv(u, v)


SYMBOLIC = {name: getattr(hy, name) for name in NAMES} | {"ln": hy.log, "sqrt": root}
ARITHMETIC = (SYMBOLIC, float, OPERATIONS | {Pow: power, Div: quotient})


def hole(m, a, q, p, k):
    """Around a black hole: the system, a start, and functions of a state: its coordinates and K, which was k. Off the
    equator a state is r, Σr', z = cos θ, Σz', t and φ; in its plane, where there is no θ, it is r, r', t and φ."""
    (energy, spin), flat = (p[0], -p[-1]), len(q) == 3
    shift, b = spin - a * energy, a * a * (k - energy**2)
    delta = lambda r: r * r - 2.0 * m * r + a * a

    def k_of(r, u, z, v):
        ss, radial = 1.0 - z * z, (energy * (r * r + a * a) - a * spin) ** 2 - u * u
        return (radial / delta(r) - (v * v + (spin - a * energy * ss) ** 2) / ss) / (r * r + (a * z) ** 2)

    r, u, z, v, t, phi = hy.make_vars("r", "u", "z", "v", "t", "phi")
    r0, u0 = q[1], -delta(q[1]) * p[1]
    if flat:
        i = 1.0 / r
        ii, y = i * i, (2.0 * m * energy - a * spin * i) / delta(r)
        pull = (spin**2 + b) * i - 3.0 * m * shift**2 * ii - m * k
        t_dot = energy + 2.0 * m * (energy * i + y if a else energy / (r - 2.0 * m))
        system = [(r, u), (u, ii * pull), (t, t_dot), (phi, spin * ii + a * (i * y))]
        of_state = lambda s: k_of(s[0], s[1] * s[0] ** 2, 0.0, 0.0)
        return system, [r0, u0 / r0**2], lambda s: [s[2], s[0], s[3]], of_state
    z0, s0 = math.cos(q[2]), math.sin(q[2])
    carter = p[2] ** 2 + z0**2 * ((spin / s0) ** 2 + b)
    rr, zz, c = r * r, z * z, carter + shift**2
    sigma, x = rr + a * a * zz, (2.0 * m * energy * r - a * spin) / delta(r)
    cubic = m * c - (2.0 * a * energy * shift + a * a * k + c) * r + 3.0 * m * k * rr + 2.0 * (energy**2 - k) * (rr * r)
    bends = z * (2.0 * b * zz - (carter + spin**2 + b))
    system = [(r, u / sigma), (u, cubic / sigma), (z, v / sigma), (v, bends / sigma)]
    system += [(t, energy + 2.0 * m * (r * (energy + x)) / sigma), (phi, (spin / (1.0 - zz) + a * x) / sigma)]
    place = lambda s: [s[4], s[0], math.acos(max(-1.0, min(s[2], 1.0))), s[5]]
    return system, [r0, u0, z0, s0 * p[2]], place, lambda s: k_of(*s[:4])


def kepler(q, q_dot):
    """The same of Kepler's problem in the plane, where a state is r, r' and the angle from the start."""
    r, u, phi = hy.make_vars("r", "u", "phi")
    (x, y), (x_dot, y_dot), i = q, q_dot, 1.0 / r
    r0, angle, spin, ii = math.hypot(x, y), math.atan2(y, x), x * y_dot - y * x_dot, i * i
    system = [(r, u), (u, ii * (spin**2 * i - 1.0)), (phi, spin * ii)]
    place = lambda s: [None, s[0] * math.cos(angle + s[2]), s[0] * math.sin(angle + s[2]), None]
    return system, [r0, (x * x_dot + y * y_dot) / r0], place, lambda s: s[1] ** 2 + (spin / s[0]) ** 2 - 2.0 / s[0]


def generic(q, metric, one_form, place, dots, momenta, is_newtonian):
    """The same of any metric. Momenta of coordinates with a constant g_aa are replaced by rates."""
    n, g = len(q), lambda a, b: metric.get((min(a, b), max(a, b)), hy.expression(0.0))
    partner = {a: b for pair in metric if pair[0] != pair[1] for a, b in (pair, pair[::-1])}
    if len(partner) != 2 * sum(a != b for a, b in metric):
        sys.exit("more than two coordinates are coupled")
    depends = {name for entry in [*metric.values(), *one_form] for name in hy.get_variables(entry)}
    active, ignorable = ([a for a in range(n) if (str(q[a]) in depends) == wanted] for wanted in (True, False))
    even = [a for a in active if a not in partner and not hy.get_variables(g(a, a)) + hy.get_variables(one_form[a])]
    p = [hy.make_vars(f"p_{q[a]}") if a in active else hy.expression(momenta[a]) for a in range(n)]
    kinetic = [g(a, a) * p[a] if a in even else p[a] - one_form[a] for a in range(n)]
    rates = [p[a] if a in even else kinetic[a] / g(a, a) if a not in partner else None for a in range(n)]
    for a, b in partner.items():
        rates[a] = (g(b, b) * kinetic[a] - g(a, b) * kinetic[b]) / (g(a, a) * g(b, b) - g(a, b) * g(a, b))

    def force(c):
        own = [(0.5 if a == b else 1.0) * hy.diff(e, q[c]) * rates[a] * rates[b] for (a, b), e in metric.items()]
        force = hy.sum(own + [hy.diff(form, q[c]) * rate for form, rate in zip(one_form, rates)])
        return force / g(c, c) if c in even else force

    variables = [q[a] for a in active] + [p[a] for a in active]
    norm = hy.cfunc([hy.sum([rate * momentum for rate, momentum in zip(rates, kinetic)])], variables)
    start = [place[a] for a in active] + [dots[a] if a in even else momenta[a] for a in active]
    system = [(q[a], rates[a]) for a in active] + [(p[a], force(a)) for a in active]
    system += [(q[a], rates[a]) for a in ignorable if not is_newtonian]
    order = {str(x): k for k, (x, _) in enumerate(system)}
    system, k_of = [(x, written_out(rate)) for x, rate in system], lambda s: norm(np.array(s[: len(start)]))[0]
    return system, start, lambda s: [s[order[str(x)]] if str(x) in order else None for x in q], k_of


HOLES = {"schwarzschild": 0.0, "kerr": "a", "kerr-equatorial": "a"}
KEPLER = "-1/sqrt(x^2 + y^2)"


class Scene:
    """The equations of a case, by hand if they are known: `system` has the rates of variables, and `start` those that
    are not quadratures. `place` gives the coordinates of a state, from `origin`, with None for those that are not
    integrated, and `delta_k` what K changed by."""

    def __init__(self, case):
        mp.dps = DIGITS
        table, is_newtonian = read(case), case.get("particle", {}).get("law") == "newtonian"
        if table.force or table.conformal or table.one_form and table.law != "metric":
            sys.exit("not understood: forces, conformal factors, and a one-form beside a potential")
        start = Newtonian(case) if is_newtonian else Hamiltonian(case)
        if is_newtonian and any(str(mass) not in ("1", "1.0") for mass in table.masses.values()):
            sys.exit("not understood: masses under Newton's law")
        self.exact, self.number, self.coordinates = start, start.formulas.number, table.coordinates
        q, n, y = [hy.make_vars(name) for name in self.coordinates], len(self.coordinates), start.state
        place, dots, momenta = ([float(u) for u in part] for part in (y[:n], start.velocity(y), y[n:]))
        if is_newtonian:
            # The lift: 2 V t'^2 + 2 t' s' - x'^2.
            table.components |= {"t t": f"2*({table.potential})", "t s": 1}
            dots = [1.0, *momenta, 0.0]
            momenta = [0.0, *(-v for v in momenta), 1.0]
        formulas, index = Formulas(table, self.coordinates, ARITHMETIC), self.coordinates.index
        names = formulas.names(q)
        expression = lambda text: hy.expression(0.0) + formulas.formula(text)[0](names)
        preset = case.get("metric", {}).get("preset")
        if preset in HOLES and case["metric"].keys() <= {"preset", "definitions"}:
            spin = formulas.parameters.get(HOLES[preset], 0.0)
            parts = hole(formulas.parameters["m"], spin, place, momenta, float(start.k))
        elif is_newtonian and table.potential == KEPLER:
            parts = kepler(place[1:3], dots[1:3])
        else:
            metric = {tuple(sorted(map(index, pair.split()))): expression(e) for pair, e in table.components.items()}
            one_form = [expression(table.one_form.get(name, 0)) for name in self.coordinates]
            parts = generic(q, metric, one_form, place, dots, momenta, is_newtonian)
        self.system, self.start, self.place, k_of = parts
        origin = self.place([*self.start, *[0.0] * (len(self.system) - len(self.start))])
        self.origin = [Decimal(repr(start) if not own else 0) for own, start in zip(origin, place)]
        self.delta_k = lambda state: k_of(state) - k_of(self.start)

    def python(self):
        """The right-hand sides in plain Python, which heyoka prints; the last one is shared."""
        texts, names = [str(rate) for _, rate in self.system], dict(NUMERIC)
        rates = ", ".join(text.replace(texts[-1], "shared") if "(" in texts[-1] else text for text in texts)
        variables = ", ".join(str(name) for name, _ in self.system)
        exec(f"def f(_, y):\n {variables} = y\n shared = {texts[-1]}\n return {rates}", names)
        return names["f"]
