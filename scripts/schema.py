#!/usr/bin/env python3
"""Checks the JSON schema of a case with a validator of its own: the schema is one of draft 7, all built-in cases are
valid by it, and cases with mistakes that a schema can see are not.

It needs Python >= 3.11 and jsonschema, and a program:

    scripts/schema.py target/release/geodesic-ivp

The exit code is 1 if a case is judged wrongly. Each mistake is also one for the program, which is asked, too.
"""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

from jsonschema import Draft7Validator

CASES = Path(__file__).resolve().parent.parent / "cases"

# Built-in cases, and what is put into them: keys with their values.
MALFORMED = [
    ("quartic", {"grid.n_gama": 64}),
    ("quartic", {"unknown": 1}),
    ("quartic", {"grid.n_gamma": "64"}),
    ("quartic", {"grid.n_gamma": 3.5}),
    ("quartic", {"grid.windows": 0}),
    ("quartic", {"grid.t_f": [1.0]}),
    ("quartic", {"grid.gamma_f": 1.0, "grid.t_f": 2.0}),
    ("quartic", {"grid": 3}),
    ("quartic", {"title": 3}),
    ("quartic", {"scheme.sbp": "SBP43"}),
    ("quartic", {"scheme.sbp": "GLL65"}),
    ("quartic", {"scheme.form": "Weak"}),
    ("quartic", {"scheme.regularised": "false"}),
    ("quartic", {"solver.digits": 71}),
    ("quartic", {"solver.digits": 15}),
    ("quartic", {"solver.accuracy": 1.0}),
    ("quartic", {"solver.accuracy": 1e-8}),
    ("quartic", {"solver.system": "doubld"}),
    ("quartic", {"solver.floor": {"x": True}}),
    ("quartic", {"expect.status": "done"}),
    ("quartic", {"expect.x": 1.0}),
    ("quartic", {"initial.velocity": 0.1, "initial.x_dot": 0.1}),
    ("quartic", {"initial.x": True}),
    ("quartic", {"potential.free": {}, "potential.quartic": {"kappa": 0.5}}),
    ("quartic", {"potential": {"quartic": {}}}),
    ("quartic", {"potential": {"quartic": {"kappa": "1/2"}}}),
    ("quartic", {"potential": {"polynomial": {"coefficients": 1.0}}}),
    ("quartic", {"potential": {"formula": {}}}),
    ("quartic", {"potential": {"formula": 3.0}}),
    ("quartic", {"potential": {"free": {"alpha": 1.0}}}),
    ("quartic", {"particle.mass": -1.0}),
    ("quartic", {"particle.law": "newton"}),
    ("quartic", {"metric": {"preset": "kerr"}}),
    ("quartic", {"tables": {"v": {"x": [0, 1]}}}),
    ("quartic", {"tables": {"v": {"x": [0, 1], "y": [0, 1], "spline": "linear"}}}),
    ("kerr-inclined", {"metric.preset": "kerrr"}),
    ("kerr-inclined", {"metric.coordinates": ["t", "r"]}),
    ("kerr-inclined", {"parameters": {"m": [1]}}),
    ("kerr-inclined", {"metric.force": "r"}),
    ("kerr-inclined", {"initial.norm": False}),
    ("kerr-inclined", {"initial.solve": {"t_dot": "up"}}),
    ("kerr-inclined", {"events": {"turn": {"direction": "up"}}}),
    ("kerr-inclined", {"events": {"turn": {"when": "r_dot", "direction": "left"}}}),
    ("kerr-inclined", {"events": {"2nd": {"when": "r_dot"}}}),
    ("kerr-inclined", {"invariants": {"a b": "r"}}),
    ("kerr-inclined", {"plot": {"x": "r", "z": "r"}}),
    ("outer-planets", {"body": {"name": "sun"}}),
    ("outer-planets", {"body": [{"name": "sun", "mass": 1.0, "position": [0.0, 0.0]}]}),
    ("outer-planets", {"force": {"x": "1"}}),
    ("outer-planets", {"pair.formula": 3}),
]


def put(case, key, value):
    """Sets a dotted key; a table takes the place of what was there."""
    *tables, last = key.split(".")
    for table in tables:
        case = case.setdefault(table, {})
    case[last] = value


def toml(value):
    """A value as TOML; tables are inline."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value) if isinstance(value, (str, bool)) else repr(value)


def main():
    program = sys.argv[1]
    schema = json.loads(subprocess.run([program, "schema"], capture_output=True, check=True, text=True).stdout)
    Draft7Validator.check_schema(schema)
    validator, wrong = Draft7Validator(schema), 0

    files = sorted(CASES.rglob("*.toml"))
    for path in files:
        effective = subprocess.run([program, "check", path], capture_output=True, check=True, text=True).stdout
        for text in [path.read_text(), effective]:
            for error in validator.iter_errors(tomllib.loads(text)):
                wrong += 1
                print(f"{path.name} is valid, and the schema says: {error.json_path}: {error.message[:200]}")

    texts = {path.stem: path.read_text() for path in files}
    for name, changes in MALFORMED:
        case = tomllib.loads(texts[name])
        for key, value in changes.items():
            put(case, key, value)
        if validator.is_valid(case):
            wrong += 1
            print(f"{name} with {changes} is valid by the schema")
        text = "".join(f"{json.dumps(key)} = {toml(value)}\n" for key, value in case.items())
        answer = subprocess.run([program, "check", "-", "--quiet"], input=text, capture_output=True, text=True)
        if answer.returncode != 2:
            wrong += 1
            print(f"{name} with {changes} ends with {answer.returncode} in the program: {answer.stderr}")
    print(f"{len(files)} cases, as they are and with every default, and {len(MALFORMED)} malformed ones: {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
