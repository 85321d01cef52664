"""Tests of the Python package with the program that it finds. Run them from the clone:

    GEODESIC_IVP=target/tests/geodesic-ivp PYTHONPATH=python python3 -m unittest discover -s python/tests
"""

import contextlib
import io
import math
import os
import pickle
import re
import subprocess
import sys
import tempfile
import unittest
import warnings
from decimal import Decimal
from pathlib import Path
from unittest import mock

import numpy as np

import geodesic_ivp
from geodesic_ivp import _program, _toml

ROOT = Path(__file__).resolve().parents[2]

PENDULUM = """
potential.formula = "1 - cos(x)"
particle = { law = "newtonian", mass = 1.0 }
initial = { x = 1.0, x_dot = 0.0 }
grid.t_f = 20.0
solver.accuracy = 1e-10
"""

AS_A_DICT = {
    "potential": {"formula": "1 - cos(x)"},
    "particle": {"law": "newtonian", "mass": 1.0},
    "initial": {"x": np.float64(1.0), "x_dot": 0.0},
    "grid.t_f": Decimal("20.0"),
    "solver": {"accuracy": 1e-10},
}

# With these keys the quartic oscillator is doubtful with SBP21, and trusted with SBP42.
DOUBTFUL = {"grid.gamma_f": 100.0, "grid.n_gamma": 2001}


class InAFolder(unittest.TestCase):
    """Tests in an empty folder, so that a case of the same name beside them cannot be taken."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.addCleanup(os.chdir, os.getcwd())
        # The variable may have a path that is relative to the folder before.
        if named := os.environ.get(_program.VARIABLE):
            absolute = mock.patch.dict(os.environ, {_program.VARIABLE: os.path.abspath(named)})
            absolute.start()
            self.addCleanup(absolute.stop)
        os.chdir(self.folder)


class Runs(InAFolder):
    def test_a_case_is_a_name_a_path_a_text_or_a_dict(self):
        Path("swing.toml").write_text(PENDULUM)
        runs = [geodesic_ivp.run(case) for case in ["swing.toml", Path("swing.toml"), PENDULUM, AS_A_DICT]]
        for run in runs:
            self.assertTrue(run.verdict == "proved" and run.is_good)
            self.assertAlmostEqual(run.summary["final"]["x"], 0.9958006771244, delta=1e-12)
            np.testing.assert_array_equal(run.trajectory, runs[0].trajectory)
        self.assertEqual(geodesic_ivp.run("quartic").summary["title"], "Quartic oscillator")
        # A path is a file, whatever the built-in cases are called, and a str may be both.
        with self.assertRaises(geodesic_ivp.FileError):
            geodesic_ivp.run(Path("quartic"))
        Path("a=b.toml").write_text(PENDULUM)
        self.assertEqual(geodesic_ivp.run("a=b.toml").summary["final"]["t"], 20.0)
        with self.assertRaisesRegex(geodesic_ivp.FileError, "-"):
            geodesic_ivp.run("-")

    def test_keys_are_changed_by_values_of_python(self):
        run = geodesic_ivp.run("quartic", set={"grid.n_gamma": 64, "scheme.sbp": "SBP42"})
        self.assertEqual((run.summary["n_gamma"], run.summary["sbp"], len(run.trajectory)), (64, "SBP42", 64))
        run = geodesic_ivp.run("quartic", set={"potential": {"linear": {"alpha": 0.25}}, "grid.t_f": 4.0})
        self.assertAlmostEqual(run.summary["t_final"], 4.0, delta=1e-12)
        doubled = {"potential": {"formula": "a*(1 - cos(x))"}, "parameters": {"a": 2}}
        run = geodesic_ivp.run(PENDULUM, set={**doubled, "initial.x": 0.5})
        self.assertAlmostEqual(run.summary["energy"], 2 * (1 - math.cos(0.5)), delta=1e-12)

    def test_tables_are_record_arrays_with_the_numbers_of_the_files(self):
        run = geodesic_ivp.run("quartic-windows", out="kept")
        self.assertIsInstance(run.trajectory, np.recarray)
        self.assertEqual(run.trajectory.dtype.names, ("gamma", "t", "x", "t_dot", "x_dot", "window"))
        self.assertEqual(run.trajectory.dtype["window"], np.int64)
        self.assertEqual(run.trajectory.window[-1], run.summary["windows"])
        last = Path("kept/trajectory.csv").read_text().split("\n")[-2].split(",")
        self.assertEqual([float(cell) for cell in last], [float(number) for number in run.trajectory[-1]])
        self.assertEqual(run.trajectory.x[-1], run.summary["x_final"])
        self.assertEqual(len(run.residuals), len(run.trajectory))
        self.assertEqual(abs(run.residuals["delta_q_t"]).max(), run.summary["max_abs_delta_q_t_interior"])
        self.assertEqual(run.tables, ["residuals", "trajectory"])
        with self.assertRaisesRegex(LookupError, "no samples.csv: the tables are residuals, trajectory"):
            print(run.samples)

    def test_samples_are_where_they_are_asked_for(self):
        for times in ["0:20:0.5", [0.5 * k for k in range(41)], np.linspace(0, 20, 41)]:
            samples = geodesic_ivp.run(PENDULUM, sample_t=times).samples
            np.testing.assert_allclose(samples.t, np.linspace(0, 20, 41), rtol=0, atol=1e-12)
            self.assertAlmostEqual(samples.x[-1], 0.9958006771244, delta=1e-12)
        # So many do not fit into an argument of a program, and are in a file.
        many = np.linspace(0, 20, 30001)
        run = geodesic_ivp.run(PENDULUM, sample_gamma=many, samples_only=True)
        np.testing.assert_array_equal(run.samples.gamma, many)
        self.assertEqual(run.tables, ["samples"])
        self.assertEqual(len(geodesic_ivp.run(PENDULUM, sample_t=3.5).samples), 1)

    def test_events_have_names_and_an_empty_cell_is_nan(self):
        run = geodesic_ivp.run("kepler")
        self.assertEqual(list(run.events.event), ["apoapsis", "periapsis"])
        self.assertAlmostEqual(run.events.t[0], math.pi, delta=1e-12)
        Path("events.csv").write_text('event,gamma,error_gamma\n"a, b",1.0,\n7,2.5,1e-3\n')
        table = geodesic_ivp.read_table("events.csv")
        self.assertEqual(list(table.event), ["a, b", "7"])
        np.testing.assert_array_equal(table.error_gamma, [math.nan, 1e-3])
        Path("events.csv").write_text("event,gamma\n")
        self.assertEqual(geodesic_ivp.read_table("events.csv").shape, (0,))
        Path("other.csv").write_text("gamma,x\n")
        self.assertEqual(geodesic_ivp.read_table("other.csv").dtype["x"], np.float64)

    def test_the_report_is_what_the_program_prints(self):
        run = geodesic_ivp.run("quartic")
        self.assertTrue(str(run).startswith("Quartic oscillator: trusted, good to 3 digits\n  end "))
        self.assertIn("Quartic oscillator: trusted", repr(run))

    def test_a_folder_lives_as_long_as_its_run_or_is_kept(self):
        run = geodesic_ivp.run("quartic", plot=True)
        folder = run.folder
        self.assertTrue((folder / "world_line.svg").is_file())
        del run
        self.assertFalse(folder.exists())
        Path("mine").mkdir()
        Path("mine/trajectory.csv").write_text("mine")
        with self.assertRaisesRegex(geodesic_ivp.FileError, "trajectory.csv"):
            geodesic_ivp.run("quartic", out="mine")
        self.assertEqual(Path("mine/trajectory.csv").read_text(), "mine")
        geodesic_ivp.run("quartic", out="kept")
        self.assertTrue(Path("kept/summary.json").is_file())

    def test_a_run_goes_on_from_another_with_the_digits_of_one(self):
        half = {"grid.gamma_f": 50.0, "grid.windows": 50}
        whole = {"grid.gamma_f": 100.0, "grid.windows": 50}
        first = geodesic_ivp.run("henon-heiles", set=half)
        second = geodesic_ivp.run("henon-heiles", set=whole, continue_from=first)
        both = geodesic_ivp.run("henon-heiles", set={**whole, "grid.windows": 100})
        self.assertEqual(second.summary["final"], both.summary["final"])
        self.assertNotEqual(first.summary["final"], both.summary["final"])

    def test_a_doubtful_result_warns_and_says_why(self):
        with self.assertWarnsRegex(geodesic_ivp.DoubtfulWarning, "doubtful: .+") as caught:
            run = geodesic_ivp.run("quartic", set=DOUBTFUL)
        self.assertEqual(caught.filename, __file__)
        self.assertTrue(run.verdict == "doubtful" and not run.is_good and run.reasons)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertEqual(geodesic_ivp.run("quartic").reasons, [])

    def test_a_proof_and_other_options_are_handed_on(self):
        run = geodesic_ivp.run(PENDULUM, prove=True)
        self.assertEqual((run.verdict, run.summary["proof"]["status"]), ("proved", "proved"))
        run = geodesic_ivp.run(PENDULUM, prove=False)
        self.assertEqual((run.verdict, "proof" in run.summary), ("trusted", False))
        run = geodesic_ivp.run("quartic", options=["--every", "10"])
        self.assertEqual(len(run.trajectory), 5)
        with self.assertRaisesRegex(ValueError, "`options`"):
            geodesic_ivp.run("quartic", options=["--help"])

    def test_results_go_to_other_processes(self):
        run = geodesic_ivp.run("quartic")
        copy = pickle.loads(pickle.dumps(run))
        folder, x = run.folder, run.trajectory.x.tolist()
        del run
        self.assertFalse(folder.exists())
        self.assertEqual((copy.verdict, copy.trajectory.x.tolist()), ("trusted", x))
        self.assertEqual(copy.tables, ["residuals", "trajectory"])

    def test_pandas_gets_the_same_columns(self):
        try:
            import pandas
        except ImportError:
            self.skipTest("pandas is not installed")
        run = geodesic_ivp.run("kepler")
        self.assertIsInstance(run.to_pandas(), pandas.DataFrame)
        self.assertEqual(list(run.to_pandas().columns), list(run.trajectory.dtype.names))
        self.assertEqual(list(run.to_pandas("events")["event"]), ["apoapsis", "periapsis"])


class Failures(InAFolder):
    def test_an_invalid_case_shows_the_place_and_the_hint(self):
        for check in [True, False]:
            with self.assertRaises(geodesic_ivp.CaseError) as caught:
                geodesic_ivp.run("quartic", set={"grid.n_gama": 3}, check=check)
            self.assertEqual((caught.exception.exit_code, caught.exception.result), (2, None))
            self.assertRegex(str(caught.exception), r"(?s)^unknown field `n_gama`.*:22:1.*did you mean `n_gamma`\?$")
        with self.assertRaises(geodesic_ivp.CaseError):
            geodesic_ivp.run("quartic", options=["--no-such-option"])

    def test_a_failed_run_is_an_exception_with_what_is_known(self):
        with self.assertRaisesRegex(geodesic_ivp.OutsideDomain, "leaves the domain at gamma = 1.570796") as caught:
            geodesic_ivp.run("horizon")
        self.assertEqual(caught.exception.exit_code, 4)
        self.assertEqual(caught.exception.result.verdict, "refused")
        self.assertAlmostEqual(caught.exception.result.summary["gamma"], math.pi / 2, delta=1e-5)
        self.assertEqual(geodesic_ivp.run("horizon", check=False).summary["status"], "outside-domain")
        with self.assertRaises(geodesic_ivp.NoSolution) as caught:
            geodesic_ivp.run("quartic-unregularised")
        self.assertEqual(caught.exception.exit_code, 3)
        copy = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual((copy.exit_code, copy.result.verdict), (3, "refused"))

    def test_an_old_summary_is_not_taken_for_a_new_one(self):
        geodesic_ivp.run("quartic", out="kept")
        with self.assertRaises(geodesic_ivp.CaseError):
            geodesic_ivp.run("quartic", out="kept", set={"grid.n_gamma": -1})

    def test_what_is_no_value_of_a_case_is_refused_before_the_program_runs(self):
        for wrong in [{"grid": None}, {1: 2.0}, {"potential.formula": b"x"}]:
            with self.assertRaises(TypeError):
                geodesic_ivp.run(wrong)

    def test_colours_are_not_in_a_message(self):
        with mock.patch.dict(os.environ, {"CLICOLOR_FORCE": "1", "FORCE_COLOR": "1"}):
            with self.assertRaises(geodesic_ivp.FileError) as caught:
                geodesic_ivp.run("no-such-case")
        self.assertTrue(str(caught.exception).startswith("cannot read the case file no-such-case"))

    @unittest.skipIf(os.name == "nt", "there are no signals")
    def test_a_program_that_is_killed_is_an_exception(self):
        Path("killed").write_text("#!/bin/sh\nkill -9 $$\n")
        Path("killed").chmod(0o755)
        with mock.patch.object(_program, "_installed", lambda: None):
            with mock.patch.dict(os.environ, {"GEODESIC_IVP": os.path.abspath("killed")}):
                with self.assertRaisesRegex(geodesic_ivp.GeodesicError, "ended by signal 9") as caught:
                    geodesic_ivp.run("quartic")
        self.assertEqual(caught.exception.exit_code, -9)

    def test_a_run_is_ended_after_a_time(self):
        long = {"grid.t_f": 1e9, "solver.tolerance": 1e-10}
        case = {key: value for key, value in AS_A_DICT.items() if key != "solver"}
        with self.assertRaises(subprocess.TimeoutExpired):
            geodesic_ivp.run(case, set=long, samples_only=True, sample_t=1.0, timeout=0.3)


class Sweeps(InAFolder):
    def test_a_sweep_is_a_table_with_a_row_for_each_run(self):
        sweep = geodesic_ivp.vary(PENDULUM, {"initial.x": [0.2, 0.6, 1.0]})
        self.assertEqual(list(sweep.runs["initial.x"]), [0.2, 0.6, 1.0])
        self.assertEqual(list(sweep.runs.row), [1, 2, 3])
        self.assertEqual((sweep.runs.verdict == "trusted").sum(), 3)
        self.assertAlmostEqual(sweep.runs.x[2], 0.9958006771244, delta=1e-12)
        for values in ["0.2:1.0:3", np.linspace(0.2, 1.0, 3), (x for x in [0.2, 0.6, 1.0])]:
            np.testing.assert_allclose(geodesic_ivp.vary(PENDULUM, {"initial.x": values}).runs.x, sweep.runs.x, 1e-12)
        self.assertTrue(str(sweep).startswith("stdin: 3 trusted"))
        self.assertIn("3 of 3 rows solved", repr(sweep))

    def test_keys_may_be_words_and_formulas_and_every_combination_is_run(self):
        formulas = ["x^2/2", "log(1 + x^2)"]
        sweep = geodesic_ivp.vary(PENDULUM, {"potential.formula": formulas, "initial.x": [0.1, 0.2]}, out="kept")
        self.assertEqual(len(sweep.runs), 4)
        self.assertAlmostEqual(sweep.runs.x[0], 0.1 * math.cos(20.0), delta=1e-11)
        sweep = geodesic_ivp.vary("quartic", {"scheme.sbp": ["SBP21", "SBP42"]}, set={"grid.n_gamma": 64})
        self.assertEqual(list(sweep.runs["scheme.sbp"]), ["SBP21", "SBP42"])

    def test_rows_that_fail_are_rows_and_no_solution_at_all_is_an_exception(self):
        keys = {"grid.gamma_f": [1.0, 2.0]}
        sweep = geodesic_ivp.vary("horizon", keys)
        self.assertEqual(list(sweep.runs.exit_code), [0, 4])
        self.assertEqual(list(sweep.runs.status), ["converged", "outside-domain"])
        self.assertTrue(math.isnan(sweep.runs.x[1]) and "leaves the domain" in sweep.runs.message[1])
        with self.assertRaises(geodesic_ivp.NoSolution) as caught:
            geodesic_ivp.vary("horizon", {"grid.gamma_f": [2.0, 3.0]})
        self.assertEqual(len(caught.exception.result.runs), 2)
        self.assertEqual(geodesic_ivp.vary("horizon", {"grid.gamma_f": 2.0}, check=False).summary["solved"], 0)

    def test_doubtful_rows_warn_and_events_of_all_are_in_one_table(self):
        with self.assertWarnsRegex(geodesic_ivp.DoubtfulWarning, "1 of the solved rows are doubtful"):
            geodesic_ivp.vary("quartic", {"scheme.sbp": ["SBP21", "SBP42"]}, set=DOUBTFUL)
        sweep = geodesic_ivp.vary("kepler", {"grid.gamma_f": [6.0, 7.0]})
        self.assertEqual(set(sweep.events.event), {"apoapsis", "periapsis"})
        self.assertEqual(set(sweep.events.row), {1, 2})

    def test_samples_of_all_rows_are_in_one_table(self):
        times = np.linspace(0.0, 1.0, 2000)
        for out in [None, "kept", "kept"]:
            sweep = geodesic_ivp.vary(PENDULUM, {"initial.x": [0.2, 0.6]}, sample_t=times, out=out)
            np.testing.assert_array_equal(sweep.samples.row, np.repeat([1, 2], len(times)))
            np.testing.assert_allclose(sweep.samples.t, np.tile(times, 2), atol=1e-15)
        single = geodesic_ivp.run(PENDULUM, set={"initial.x": 0.6}, sample_t=times, prove=False)
        np.testing.assert_array_equal(sweep.samples.x[len(times):], single.samples.x)


class Program(InAFolder):
    def test_commands_print(self):
        self.assertIn("quartic", geodesic_ivp.command("init", "--list"))
        text = geodesic_ivp.command("init", "harmonic")
        geodesic_ivp.command("check", "-", "--run", text=text)
        wrong = text.replace("[expect]", "[expect]\nmax_abs_delta_k = 1e-300", 1)
        self.assertNotEqual(text, wrong)
        with self.assertRaises(geodesic_ivp.GeodesicError):
            geodesic_ivp.command("check", "-", "--run", text=wrong)

    def test_it_is_looked_for_in_the_order_that_is_documented(self):
        here = geodesic_ivp.program().resolve()
        suffix = here.suffix
        path = self.folder / "path" / f"geodesic-ivp{suffix}"
        named = self.folder / f"another-name{suffix}"
        path.parent.mkdir()
        for place in [path, named]:
            place.write_bytes(here.read_bytes())
            place.chmod(0o755)
        environment = {"PATH": str(path.parent), "GEODESIC_IVP": str(named)}
        with mock.patch.dict(os.environ, environment):
            with mock.patch.object(_program, "_installed", lambda: here):
                self.assertEqual(geodesic_ivp.program(), here)
            with mock.patch.object(_program, "_installed", lambda: None):
                self.assertEqual(geodesic_ivp.program(), named)
                os.environ["GEODESIC_IVP"] = str(self.folder / "gone")
                with self.assertRaisesRegex(geodesic_ivp.ProgramNotFound, "gone, which is no file"):
                    geodesic_ivp.program()
                del os.environ["GEODESIC_IVP"]
                self.assertEqual(geodesic_ivp.program(), path)
                os.environ["PATH"] = str(self.folder)
                with self.assertRaisesRegex(geodesic_ivp.ProgramNotFound, "install it"):
                    geodesic_ivp.run("quartic")

    def test_the_program_of_a_wheel_is_that_of_its_own_package_alone(self):
        # What pip leaves of a wheel, beside the package that is tested and around a copy of it.
        site, package = self.folder / "site", Path(geodesic_ivp.__file__).parent
        copy, script, record = site / "geodesic_ivp", site / "bin" / "geodesic-ivp", site / "geodesic_ivp-9.dist-info"
        for folder in [copy, script.parent, record]:
            folder.mkdir(parents=True)
        for file in package.glob("*.py"):
            (copy / file.name).write_bytes(file.read_bytes())
        script.write_text("the program of the wheel")
        (record / "METADATA").write_text("Metadata-Version: 2.1\nName: geodesic-ivp\nVersion: 9\n")
        (record / "RECORD").write_text("geodesic_ivp/__init__.py,,\nbin/geodesic-ivp,,\n")
        line = "from geodesic_ivp import _program; print(_program._installed())"

        def found(*paths):
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths))}
            done = subprocess.run([sys.executable, "-c", line], env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            return done.stdout.strip()

        self.assertEqual(found(site), str(script.resolve()))
        self.assertEqual(found(package.parent, site) == str(script.resolve()), False)
        # An editable installation has a program and no files of the package.
        (record / "RECORD").write_text("bin/geodesic-ivp,,\n")
        copy.rename(self.folder / "elsewhere")
        (self.folder / "source").mkdir()
        (self.folder / "elsewhere").rename(self.folder / "source" / "geodesic_ivp")
        self.assertEqual(found(self.folder / "source", site), str(script.resolve()))

    def test_the_module_is_the_program(self):
        package = Path(geodesic_ivp.__file__).parents[1]
        environment = {**os.environ, "PYTHONPATH": str(package)}
        line = [sys.executable, "-m", "geodesic_ivp", "check", "nothing"]
        done = subprocess.run(line, env=environment, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr[:6]), (1, "error:"))


class Texts(InAFolder):
    def test_values_are_written_as_toml(self):
        pairs = {
            "b": (True, "true"),
            "i": (np.int64(3), "3"),
            "f": (1e-10, "1e-10"),
            "inf": (-math.inf, "-inf"),
            "d": (Decimal("0.1000"), "0.1000"),
            "s": ('a "b"\\\n', '"a \\"b\\"\\\\\\n"'),
            "delete": ("\x7f", '"\\u007f"'),
            "a": (np.array([1.5, 2.0]), "[1.5, 2.0]"),
            "t": ({"x y": (1, "z"), "p.q": {}}, '{ "x y" = [1, "z"], p.q = {} }'),
        }
        for thing, text in pairs.values():
            self.assertEqual(_toml.value(thing), text)
        try:
            import tomllib
        except ImportError:
            self.skipTest("tomllib is of Python 3.11 and later")
        read = tomllib.loads(_toml.document({key: thing for key, (thing, _) in pairs.items()}))
        self.assertEqual(read["s"], pairs["s"][0])
        self.assertEqual(read["delete"], "\x7f")
        self.assertEqual(read["t"], {"x y": [1, "z"], "p": {"q": {}}})

    def test_the_page_runs_as_it_is_read(self):
        page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        rows = re.findall(r"^\| `(\w+)` \| (\d+) \|$", page, re.MULTILINE)
        of_code = _program._OF_CODE.items()
        self.assertEqual([(name, int(code)) for name, code in rows], [(kind.__name__, code) for code, kind in of_code])
        blocks = re.findall(r"^```(\S+)(?: (\S+))?\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
        self.assertGreaterEqual([kind for kind, _, _ in blocks].count("python"), 3)
        names, printed = {}, ""
        for kind, name, text in blocks:
            if kind == "toml":
                Path(name).write_text(text)
            elif kind == "python":
                with contextlib.redirect_stdout(io.StringIO()) as output, warnings.catch_warnings():
                    warnings.simplefilter("error")
                    exec(compile(text, f"docs/python.md: {text.splitlines()[0]}", "exec"), names)
                printed = output.getvalue()
            elif kind == "text":
                # Digits are those of a machine; words are not, nor are lines broken by the length of a path.
                masked = [re.sub(r"[\d.]+(e-?\d+)?", "#", part).split() for part in (text, printed)]
                self.assertEqual(masked[0], masked[1])

    def test_lines_fit_into_120_columns(self):
        files = [*ROOT.glob("python/**/*.py"), *ROOT.glob("examples/python/*.py"), ROOT / "scripts" / "wheel.py"]
        self.assertGreater(len(files), 8)
        for file in files:
            for line in file.read_text(encoding="utf-8").splitlines():
                self.assertTrue(len(line) <= 120 or "://" in line, f"{file}: {line}")


if __name__ == "__main__":
    unittest.main()
