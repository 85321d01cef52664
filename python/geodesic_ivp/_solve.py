"""`run` and `vary`: a case goes into the program, and its results come back."""

from __future__ import annotations

import os
import shutil
import tempfile
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, Union

from . import _toml
from ._program import called, failure
from ._results import DoubtfulWarning, Run, Sweep

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# A path, the name of a built-in case, the text of a case, or a case as a dict.
Case = Union[str, "os.PathLike[str]", Mapping[str, Any]]

_Kind = TypeVar("_Kind", Run, Sweep)

# Longer lists of samples go through a file: an argument of a program has at most 32 kB on Windows, 128 kB on Linux.
_LONGEST_LIST = 8000


def run(
    case: Case,
    *,
    set: Mapping[str, Any] | None = None,
    sample_t: str | ArrayLike | None = None,
    sample_gamma: str | ArrayLike | None = None,
    samples_only: bool = False,
    continue_from: Run | str | os.PathLike[str] | None = None,
    prove: bool | None = None,
    plot: bool = False,
    out: str | os.PathLike[str] | None = None,
    options: Sequence[str] = (),
    check: bool = True,
    timeout: float | None = None,
) -> Run:
    """Solves a case.

    case            A path, the name of a built-in case, the text of a case (TOML, known by an = or a line break), or a
                    dict. A str that names a file is that file.
    set             Keys to change, dotted: `{"grid.t_f": 4.0, "potential.formula": "x^2"}`.
    sample_t        Also give values at these times: numbers in order, or "START:STOP:STEP", or "@FILE.csv:COLUMN".
    sample_gamma    The same at values of gamma.
    samples_only    Give no other table, and keep one window in memory.
    continue_from   An earlier run, or its folder, whose end is the start of this one.
    prove           Prove where the motion ends. None: with `solver.accuracy`, if that takes little.
    plot            Draw pictures (SVG) into the folder of the run.
    out             The folder of the results. Without it they are in a temporary one, which goes with the `Run`.
    options         Any other options of `geodesic-ivp run`, as `["--no-error"]`, that do not change what it prints.
    check           A failed run is an exception; with False it is a `Run` with the verdict `refused`.
    timeout         Seconds after which the program is ended, and `subprocess.TimeoutExpired` raised.

    A doubtful result is returned with a `DoubtfulWarning`. An invalid case is a `CaseError` whatever `check` is.
    """
    with _Call(case, set, out) as call:
        call.add_samples(sample_t, sample_gamma)
        if continue_from is not None:
            before = continue_from.folder if isinstance(continue_from, Run) else continue_from
            call.add("--from", os.path.abspath(before))
        proof = [("--prove", bool(prove)), ("--no-prove", prove is False)]
        flags = [("--samples-only", samples_only), *proof, ("--plot", plot)]
        call.add(*(flag for flag, is_given in flags if is_given), *options)
        return call.result(Run, check, timeout)


def vary(
    case: Case,
    keys: Mapping[str, str | ArrayLike | Iterable[Any]],
    *,
    set: Mapping[str, Any] | None = None,
    sample_t: str | ArrayLike | None = None,
    sample_gamma: str | ArrayLike | None = None,
    prove: bool = False,
    plot: bool = False,
    out: str | os.PathLike[str] | None = None,
    options: Sequence[str] = (),
    check: bool = True,
    timeout: float | None = None,
) -> Sweep:
    """Solves a case for many values of its keys, on all cores: `vary("quartic", {"initial.x": [0.5, 1.0]}).runs`.

    keys            Values for each key: numbers or strings, or "START:STOP:COUNT". Several keys make every combination,
                    and the last varies fastest.
    sample_t        Also give values of every row at these times, as far as it reaches.
    out             The folder of the results. With it, the same call goes on where one was interrupted.
    check           With no solution in any row there is an exception; with False a `Sweep` all the same.

    A row that fails is a row, and its column `message` says why. If rows are doubtful there is a `DoubtfulWarning`.
    The others are as in `run`.
    """
    with _Call(case, set, out) as call:
        for key, values in keys.items():
            call.add("--vary", f"{key}={_list(values)}")
        call.add_samples(sample_t, sample_gamma)
        flags = [("--prove", prove), ("--plot", plot)]
        call.add(*(flag for flag, is_given in flags if is_given), *options)
        return call.result(Sweep, check, timeout)


def _list(values: Any) -> str:
    """Values as the program takes them: a str is handed on, and anything else is a list of values of TOML."""
    if isinstance(values, str):
        return values
    if hasattr(values, "tolist"):
        values = values.tolist()
    if not isinstance(values, Iterable):
        values = [values]
    return ",".join(_word(part) for part in values)


def _word(value: Any) -> str:
    """A value of TOML. A plain word needs no quotes there, and has none in the column of the table then."""
    is_plain = isinstance(value, str) and value.isidentifier() and value not in ("true", "false", "inf", "nan")
    return value if is_plain else _toml.value(value)


class _Call:
    """One call of `run`, with a folder of its own for its results and for what it is given as files."""

    def __init__(self, case: Case, set: Mapping[str, Any] | None, out: str | os.PathLike[str] | None) -> None:
        argument, self._text = _argument(case)
        settings = [part for key, value in (set or {}).items() for part in ("--set", f"{key}={_toml.value(value)}")]
        self._temporary = Path(tempfile.mkdtemp(prefix="geodesic-ivp-"))
        self._folder = self._temporary / "results" if out is None else Path(out).absolute()
        self._is_kept = out is not None
        self._arguments = ["run", argument, "--out", str(self._folder), *settings]
        self._has_result = False

    def __enter__(self) -> _Call:
        return self

    def __exit__(self, *_: object) -> None:
        if self._is_kept or not self._has_result:
            shutil.rmtree(self._temporary, ignore_errors=True)

    def add(self, *arguments: str) -> None:
        self._arguments.extend(arguments)

    def add_samples(self, times: Any, gammas: Any) -> None:
        for option, values in [("--sample-t", times), ("--sample-gamma", gammas)]:
            if values is not None:
                self.add(f"{option}={self.samples(values, option)}")

    def samples(self, values: Any, option: str) -> str:
        """The places of samples, in a file if there are many."""
        text = _list(values)
        if isinstance(values, str) or len(text) < _LONGEST_LIST:
            return text
        path = self._temporary / f"{option.strip('-')}.csv"
        path.write_text("value\n" + text.replace(",", "\n") + "\n", encoding="utf-8")
        return f"@{path}:value"

    def result(self, kind: type[_Kind], check: bool, timeout: float | None) -> _Kind:
        """Calls the program, and looks at what it has left."""
        summary = self._folder / "summary.json"
        done = called(self._arguments, self._text, timeout)
        # These are the codes of a computation that came to its end; after any other a summary is that of a run before.
        if done.returncode not in (0, 3, 4):
            raise failure(done)
        if not summary.is_file():
            raise ValueError(f"no results are in {self._folder}: of `options`, some let the program write elsewhere")
        self._has_result = True
        result = kind(self._folder, done.stdout, None if self._is_kept else self._temporary)
        if done.returncode != 0 and check:
            raise failure(done, result)
        if doubt := _doubt(result):
            warnings.warn(doubt, DoubtfulWarning, stacklevel=3)
        return result


def _doubt(result: Run | Sweep) -> str | None:
    """What there is to be warned of."""
    if isinstance(result, Sweep):
        doubtful = result.summary["doubtful"]
        return f"{doubtful} of the solved rows are doubtful: their column message says why" if doubtful else None
    return f"the result is doubtful: {'; '.join(result.reasons)}" if result.verdict == "doubtful" else None


def _argument(case: Case) -> tuple[str, str | None]:
    """A case as an argument of the program, and as its standard input."""
    if isinstance(case, Mapping):
        return "-", _toml.document(case)
    if not isinstance(case, str):
        return os.path.abspath(case), None
    is_text = "\n" in case or "=" in case
    if is_text and not os.path.isfile(case):
        return "-", case
    # A name that begins with a dash would be an option, or standard input.
    return os.path.abspath(case) if case.startswith("-") else case, None
