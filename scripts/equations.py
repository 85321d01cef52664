"""Equations of motion as an expert writes them for heyoka and SciPy, by hand where a case is well known.

A Taylor method pays for every product of two series, and not for sums or numbers. Charges are therefore numbers, and
what is ignorable is a quadrature behind the other variables, with a start of 0. Around a black hole r and cos θ are
integrated in the second order, because the squares of their rates in Mino's time are polynomials. Kepler's problem is
integrated in polar coordinates. Any other metric has q' = g^ab (p_b − A_b) and p' = ∂L/∂q at fixed q', which needs no
derivative of an inverse. Newton's law is q'' = −∂V; t is γ then, and nobody integrates the action s. """

import ast
import math
import operator
import re
import sys
from decimal import Decimal

import heyoka as hy
import numpy as np
from scene_expectations import DEFAULTS, PRESETS

FUNCTIONS = "sin cos tan sinh cosh tanh asin acos atan exp sqrt".split()
SYMBOLIC = {name: getattr(hy, name) for name in FUNCTIONS} | {"ln": hy.log}
NUMERIC = {name: getattr(math, name) for name in FUNCTIONS} | {"ln": math.log, "log": math.log}
POWERS = {}  # written_out replaces them by these products.


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


OPERATIONS = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv},
    **{ast.Pow: power, ast.USub: operator.neg, ast.UAdd: operator.pos},
}


def evaluate(text, names, functions):
    """The expression of a case file with the values of its names; the grammar is Python's with ^ in place of **."""
    python = re.sub(r"(?<![\w.])[A-Za-z_]\w*", r"\g<0>_", text).replace("^", "**")

    def walk(node):
        match node:
            case ast.Constant(value=value):
                return float(value)
            case ast.Name(id=name):
                return names[name[:-1]]
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return functions[name[:-1]](walk(argument))
            case ast.UnaryOp(op=op, operand=u):
                return OPERATIONS[type(op)](walk(u))
            case ast.BinOp(left=u, op=ast.Div(), right=ast.Call(func=ast.Name(id="sqrt_"), args=[argument])):
                return walk(u) * walk(argument) ** -0.5  # Its series and that of its derivative are short.
            case ast.BinOp(left=u, op=op, right=v):
                return OPERATIONS[type(op)](walk(u), walk(v))
        raise ValueError(f"not understood: {text}")

    return walk(ast.parse(f"({python})", mode="eval").body)


def is_scene(case):
    """Whether a case is one of several coordinates, of another metric or of another law."""
    potential, particle = case.get("potential", {}), case.get("particle", {})
    several = {"coordinates", "one_form", "force", "conformal"}
    return "metric" in case or bool(several & potential.keys()) or bool({"masses", "law"} & particle.keys())


def polynomial(spec):
    """The formula of a potential that has a name."""
    ((kind, values),) = spec.items()
    coefficients = {"free": [], "linear": [0, values.get("alpha")], "quartic": [0] * 4 + [values.get("kappa")]}
    terms = enumerate(coefficients.get(kind, values.get("coefficients")))
    return " + ".join(["0", *(f"({c!r}) * x^{k}" if k > 1 else f"({c!r})" + " * x" * k for k, c in terms if c)])


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


def hamiltonian_hole(m, a, q, p, k):
    """The same in Hamilton's equations, as any solver of them has them: K is folded in, as ∂H is to be taken where H is
    K/2. A state is r, θ, p_r, p_θ, t and φ, without θ and p_θ in the equatorial plane."""
    (energy, spin), flat = (p[0], -p[-1]), len(q) == 3
    r, theta, u, v, t, phi = hy.make_vars("r", "theta", "p_r", "p_theta", "t", "phi")
    rr, delta = r * r, r * r - 2.0 * m * r + a * a
    sine, cosine = (hy.expression(1.0), hy.expression(0.0)) if flat else (hy.sin(theta), hy.cos(theta))
    ss, i, f = sine * sine, 1.0 / delta, energy * (rr + a * a) - a * spin
    over = 1.0 / (rr + a * a * (cosine * cosine))
    fi = f * i
    r_force = k * r - (2.0 * energy * r * fi - (r - m) * (fi * fi + u * u))
    theta_force = cosine * (a * a * energy**2 * sine - spin**2 / (ss * sine) - k * a * a * sine)
    t_dot = ((rr + a * a) * fi - a * (a * energy * ss - spin)) * over
    phi_dot = (a * fi - (a * energy - spin / ss)) * over
    radial = [(r, -delta * u * over), (u, r_force * over)]
    if flat:
        return [*radial, (t, t_dot), (phi, phi_dot)], [q[1], p[1]], lambda s: [s[2], s[0], s[3]], None
    system = [radial[0], (theta, -v * over), radial[1], (v, theta_force * over), (t, t_dot), (phi, phi_dot)]
    return system, [q[1], q[2], p[1], p[2]], lambda s: [s[4], s[0], s[1], s[5]], None


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
    """The equations of a case, by hand if they are known and `by_hand` is true, and where it is "hamiltonian" in
    positions and momenta, or positions and velocities, of the case's own coordinates: `system` has the rates of variables,
    and `start` those that are not quadratures. `place` gives the coordinates of a state, from `origin`, with None for
    those that are not integrated, and `delta_k` what K changed by."""

    def __init__(self, case, by_hand=True):
        self.numbers, table, particle = {"pi": math.pi}, case.get("metric"), case.get("particle", {})
        law, table = particle.get("law", "metric" if table else "relativistic"), table or case["potential"]
        unknown = {"force", "conformal"} if law == "metric" else {"one_form", "force", "conformal"}
        if unknown := unknown & table.keys() | {"masses"} & particle.keys():
            sys.exit(f"not understood in a scene: {', '.join(sorted(unknown))}")
        table = table if law == "metric" or "formula" in table else {"formula": polynomial(table)}
        table = table | (table["formula"] if isinstance(table.get("formula"), dict) else {})
        for name, value in (DEFAULTS.get(table.get("preset"), {}) | table.get("parameters", {})).items():
            self.numbers[name] = self.number(value)
        initial, formula = case["initial"], table.get("expression", table.get("formula"))
        coordinates, definitions, components = PRESETS.get(table.get("preset"), (["x"], {}, {}))
        coordinates = table.get("coordinates", coordinates)
        definitions, components = definitions | table.get("definitions", {}), components | table.get("components", {})
        if law != "metric":
            components = {f"{name} {name}": -1 for name in coordinates}
        if law == "newtonian":
            components |= {"t t": f"2*({formula})", "t s": 1}
            coordinates, initial = ["t", *coordinates, "s"], initial | {"t_dot": 1, "p_t": 0, "p_s": 1}
        elif law == "relativistic":
            components["t t"] = f"{particle.get('c', 1)}^2 + 2/{particle.get('mass', 1)}*({formula})"
            coordinates, x_dot = ["t", *coordinates], self.number(initial["t_dot"]) * initial.get("velocity", 0)
            initial = {"x_dot": x_dot} | initial
        self.several = is_scene(case)
        self.coordinates, q, n = coordinates, [hy.make_vars(name) for name in coordinates], len(coordinates)
        names = dict(zip(coordinates, q))
        while waiting := {name: text for name, text in definitions.items() if name not in names}:
            for name, text in waiting.items():
                if not set(re.findall(r"[A-Za-z_]\w*", text)) & waiting.keys():
                    names[name] = self.expression(text, names)
        metric = {}
        for pair, text in components.items():
            metric[tuple(sorted(coordinates.index(name) for name in pair.split()))] = self.expression(text, names)
        one_form = [self.expression(table.get("one_form", {}).get(name, 0), names) for name in coordinates]
        place = [self.number(initial.get(name, 0)) for name in coordinates]
        at_start = lambda expression: float(hy.cfunc([expression], q)(np.array(place))[0])
        entries, forms = np.zeros((n, n)), [at_start(form) for form in one_form]
        for (a, b), entry in metric.items():
            entries[a, b] = entries[b, a] = at_start(entry)
        initial = self.with_norm(initial, entries)
        dots = [self.number(initial.get(f"{name}_dot", 0)) for name in coordinates]
        momenta = [float(row @ dots) + form for row, form in zip(entries, forms)]
        momenta = [self.number(initial.get(f"p_{name}", p)) for name, p in zip(coordinates, momenta)]
        if by_hand and table.get("preset") in HOLES and table.keys() <= {"preset", "parameters"}:
            k, spin = float(momenta @ np.linalg.inv(entries) @ momenta), self.numbers.get(HOLES[table["preset"]], 0.0)
            equations = hamiltonian_hole if by_hand == "hamiltonian" else hole
            parts = equations(self.numbers["m"], spin, place, momenta, k)
        elif by_hand is True and law == "newtonian" and formula == KEPLER:
            parts = kepler(place[1:3], dots[1:3])
        else:
            rates = np.linalg.solve(entries, momenta - np.array(forms)).tolist()
            parts = generic(q, metric, one_form, place, rates, momenta, law == "newtonian")
        self.system, self.start, self.place, k_of = parts
        origin = self.place([*self.start, *[0.0] * (len(self.system) - len(self.start))])
        self.origin = [Decimal(repr(start) if not own else 0) for own, start in zip(origin, place)]
        self.delta_k = lambda state: k_of(state) - k_of(self.start)

    def number(self, value):
        return evaluate(str(value), self.numbers, NUMERIC)

    def expression(self, text, names):
        return hy.expression(0.0) + evaluate(str(text), self.numbers | names, SYMBOLIC)

    def with_norm(self, initial, entries):
        """The initial data with the rate that follows from K."""
        missing = [name for name in self.coordinates if not {f"{name}_dot", f"p_{name}"} & initial.keys()]
        if not missing:
            return initial
        if len(missing) > 1 or any(f"p_{name}" in initial for name in self.coordinates) or "norm" not in initial:
            sys.exit("not understood in a scene: norm and solve beside momenta")
        norm, a = {"timelike": 1, "null": 0}.get(initial["norm"], initial["norm"]), self.coordinates.index(missing[0])
        dots = np.array([self.number(initial.get(f"{name}_dot", 0)) for name in self.coordinates])
        own, half, rest = entries[a, a], entries[a] @ dots, dots @ entries @ dots - self.number(norm)
        toward = -own if initial["solve"][f"{missing[0]}_dot"] == "-" else own
        root = math.copysign(math.sqrt(half**2 - own * rest), toward) - half
        return initial | {f"{missing[0]}_dot": root / own if own else -rest / (2.0 * half)}

    def python(self):
        """The right-hand sides in plain Python, which heyoka prints; the last one is shared."""
        texts, names = [str(rate) for _, rate in self.system], dict(NUMERIC)
        rates = ", ".join(text.replace(texts[-1], "shared") if "(" in texts[-1] else text for text in texts)
        variables = ", ".join(str(name) for name, _ in self.system)
        exec(f"def f(_, y):\n {variables} = y\n shared = {texts[-1]}\n return {rates}", names)
        return names["f"]
