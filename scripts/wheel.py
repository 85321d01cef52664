#!/usr/bin/env python3
"""Packs a wheel around a program that is built already, and tests it in a fresh virtual environment.

    scripts/wheel.py [--program target/tests/geodesic-ivp] [--platform TAG] [--out target/wheels] [--no-tests]
                     [--python PYTHON] [--with PACKAGE]... [--examples]

It needs Python 3.11. The wheel is what maturin makes of pyproject.toml, but for the list of crates: a package of Python
that suits every version, and the program as a script. TAG is that of this machine, which no index takes for Linux. A
static program for Linux suits `manylinux_2_17_x86_64.musllinux_1_1_x86_64`.

The environment is made by PYTHON, which may be of another version, and NumPy comes from the package index. `--with
numpy==1.22.4` takes another version of it, and `--with pandas` tests that, too. `--examples` also runs examples/python,
with pandas and matplotlib. It is no part of `.ci/run`, which needs nothing but Rust.
"""

import argparse
import base64
import hashlib
import os
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def read(name):
    return tomllib.loads((ROOT / name).read_text(encoding="utf-8"))


def metadata(crate, project):
    """The headers that an index and pip read, and the README below them."""
    lines = ["Metadata-Version: 2.4", f"Name: {project['name']}", f"Version: {crate['version']}"]
    lines += [f"Summary: {crate['description']}", f"Keywords: {','.join(crate['keywords'])}"]
    lines += [f"Author: {author['name']}" for author in project["authors"]]
    lines += [f"License-Expression: {project['license']}"]
    lines += [f"License-File: {name}" for name in project["license-files"]]
    lines += [f"Classifier: {classifier}" for classifier in project["classifiers"]]
    lines += [f"Requires-Python: {project['requires-python']}"]
    lines += [f"Requires-Dist: {package}" for package in project["dependencies"]]
    lines += ["Description-Content-Type: text/markdown; charset=UTF-8; variant=GFM", ""]
    return "\n".join(lines) + "\n" + (ROOT / crate["readme"]).read_text(encoding="utf-8")


def packed(program, platform, out):
    """Writes the wheel, and returns its path."""
    crate, project = read("Cargo.toml")["package"], read("pyproject.toml")["project"]
    name = f"{project['name'].replace('-', '_')}-{crate['version']}"
    tags = [f"py3-none-{tag}" for tag in platform.split(".")]
    about = ["Wheel-Version: 1.0", "Generator: scripts/wheel.py", "Root-Is-Purelib: false"]
    package = ROOT / "python" / "geodesic_ivp"
    sources = sorted(path for path in package.iterdir() if path.suffix == ".py" or path.name == "py.typed")
    files = {f"geodesic_ivp/{path.name}": path.read_bytes() for path in sources}
    files[f"{name}.data/scripts/{program.name}"] = program.read_bytes()
    for licence in project["license-files"]:
        files[f"{name}.dist-info/licenses/{licence}"] = (ROOT / licence).read_bytes()
    files[f"{name}.dist-info/METADATA"] = metadata(crate, project).encode()
    files[f"{name}.dist-info/WHEEL"] = "\n".join(about + [f"Tag: {tag}" for tag in tags] + [""]).encode()

    def row(path, content):
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        return f"{path},sha256={digest},{len(content)}\n"

    record = f"{name}.dist-info/RECORD"
    files[record] = "".join(row(*file) for file in files.items()).encode() + f"{record},,\n".encode()
    out.mkdir(parents=True, exist_ok=True)
    wheel = out / f"{name}-py3-none-{platform}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            # The same content makes the same wheel, whenever it is packed. A script has to be executable.
            entry = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o100755 if ".data/scripts/" in path else 0o100644) << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return wheel


def tested(wheel, arguments):
    """Installs the wheel into a fresh environment, and runs the tests of the package and its examples there."""
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "GEODESIC_IVP")}
    environment |= {"MPLBACKEND": "Agg", "PYTHONWARNINGS": "default"}
    with tempfile.TemporaryDirectory() as folder:

        def call(*line):
            done = subprocess.run([str(part) for part in line], env=environment, cwd=folder)
            if done.returncode != 0:
                sys.exit(f"failed: {' '.join(map(str, line))}")

        home = Path(folder, "environment")
        call(arguments.python, "-m", "venv", home)
        python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        extra = ["pandas", "matplotlib"] if arguments.examples else []
        call(python, "-m", "pip", "install", "--quiet", wheel.resolve(), *arguments.packages, *extra)
        # The program must be the one of the wheel, and not another that happens to be on the PATH.
        check = "import geodesic_ivp, sys; sys.exit(not geodesic_ivp.program().is_relative_to(sys.argv[1]))"
        call(python, "-c", check, home.resolve())
        call(python, "-m", "unittest", "discover", "-s", ROOT / "python" / "tests")
        if arguments.examples:
            for example in sorted((ROOT / "examples" / "python").glob("*.py")):
                call(python, example)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    suffix = ".exe" if os.name == "nt" else ""
    built = ROOT / "target" / "tests" / f"geodesic-ivp{suffix}"
    local = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    parser.add_argument("--program", type=Path, default=built, help="what is packed (default: that of the tests)")
    parser.add_argument("--platform", metavar="TAG", default=local, help=f"where it runs (default: {local})")
    parser.add_argument("--out", type=Path, default=ROOT / "target" / "wheels", help="default: target/wheels")
    parser.add_argument("--no-tests", action="store_true", help="only pack, as for another machine")
    parser.add_argument("--python", default=sys.executable, help="what makes the environment (default: this Python)")
    parser.add_argument("--with", dest="packages", metavar="PACKAGE", action="append", default=[])
    parser.add_argument("--examples", action="store_true", help="run examples/python, too")
    arguments = parser.parse_args()
    if not arguments.program.is_file():
        parser.error(f"{arguments.program} is not there: cargo build --profile tests builds it")
    version = read("Cargo.toml")["package"]["version"]
    if not arguments.no_tests:
        told = subprocess.run([arguments.program.resolve(), "--version"], check=True, capture_output=True, text=True)
        if told.stdout.strip() != f"geodesic-ivp {version}":
            parser.error(f"{arguments.program} is {told.stdout.strip()}, and Cargo.toml has {version}")
    wheel = packed(arguments.program, arguments.platform, arguments.out)
    print(f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB", flush=True)
    if not arguments.no_tests:
        tested(wheel, arguments)


if __name__ == "__main__":
    main()
