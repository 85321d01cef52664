"""Where the program is, how it is called, and the exceptions that its exit codes become."""

from __future__ import annotations

import os
import shutil
import subprocess
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._results import Run, Sweep

NAME = "geodesic-ivp"
VARIABLE = "GEODESIC_IVP"


class ProgramNotFound(FileNotFoundError):
    """There is no program: not where the package was installed, not in GEODESIC_IVP, and not on the PATH."""


class GeodesicError(Exception):
    """The program ended with another exit code than 0.

    `message` is what it printed, with its advice, and `exit_code` is the code. `result` is what there is in spite of
    that: after a failed run a `Run` with the verdict `refused`, and after a sweep without any solution its `Sweep`.
    """

    def __init__(self, message: str, exit_code: int, result: Run | Sweep | None = None) -> None:
        super().__init__(message, exit_code, result)
        self.message = message
        self.exit_code = exit_code
        self.result = result

    def __str__(self) -> str:
        return self.message


class FileError(GeodesicError):
    """Exit code 1: a file cannot be read or written, or is not the program's to replace."""


class CaseError(GeodesicError):
    """Exit code 2: an invalid case or wrong options. The message shows line, column and what to do."""


class NoSolution(GeodesicError):
    """Exit code 3: no critical point. The message says where the residual is largest and what to try."""


class OutsideDomain(GeodesicError):
    """Exit code 4: the geodesic leaves the domain, or a number overflows. The message says where."""


class ExpectationNotMet(GeodesicError):
    """Exit code 5, of `command("check", case, "--run")`: a number is not what the case expects."""


class Interrupted(GeodesicError):
    """Exit code 130: the program was interrupted, by Ctrl-C or SIGTERM."""


_OF_CODE: dict[int, type[GeodesicError]] = {
    1: FileError,
    2: CaseError,
    3: NoSolution,
    4: OutsideDomain,
    5: ExpectationNotMet,
    130: Interrupted,
}


def program() -> Path:
    """The program that is called. It is looked for in this order:

    1. where the wheel of this package has put it, as its record of installed files says;
    2. what the environment variable GEODESIC_IVP names;
    3. the first `geodesic-ivp` on the PATH.
    """
    if installed := _installed():
        return installed
    if named := os.environ.get(VARIABLE):
        if Path(named).is_file():
            return Path(named)
        raise ProgramNotFound(f"{VARIABLE} names {named}, which is no file")
    if found := shutil.which(NAME):
        return Path(found)
    raise ProgramNotFound(
        f"{NAME} is not there: install it with pip or cargo, put it on the PATH, or name it in {VARIABLE}"
    )


@cache
def _installed() -> Path | None:
    """The program that was installed together with this very package, if it was."""
    try:
        distribution = metadata.distribution(NAME)
    except metadata.PackageNotFoundError:
        return None
    files = distribution.files or []
    packages = [file.locate() for file in files if file.parts[-2:] == ("geodesic_ivp", "__init__.py")]
    here = Path(__file__).with_name("__init__.py")
    # Where another copy of the package is installed, the program there is not of this copy. An editable installation
    # lists no files of the package at all, and its program is the right one.
    if packages and not any(os.path.exists(package) and os.path.samefile(package, here) for package in packages):
        return None
    programs = [Path(str(file.locate())) for file in files if file.name in (NAME, NAME + ".exe")]
    return next((path.resolve() for path in programs if path.is_file()), None)


def called(
    arguments: list[str], text: str | None = None, timeout: float | None = None
) -> subprocess.CompletedProcess[str]:
    """Calls the program. `text` is its standard input, of which there is none otherwise."""
    # Messages are read by the package, so they must have no colours.
    environment = {**os.environ, "NO_COLOR": "1"}
    line = [str(program()), *arguments]
    return subprocess.run(
        line, input=text or "", capture_output=True, encoding="utf-8", errors="replace", env=environment,
        timeout=timeout, check=False,
    )  # fmt: skip


def failure(done: subprocess.CompletedProcess[str], result: Run | Sweep | None = None) -> GeodesicError:
    """The exception for an exit code that is not 0."""
    code = done.returncode
    _, mark, message = f"\n{done.stderr}".partition("\nerror: ")
    message = message.strip() if mark else done.stderr.strip()
    if code < 0:
        message = f"the program was ended by signal {-code}\n{message}".strip()
    return _OF_CODE.get(code, GeodesicError)(message or "the program printed no message", code, result)


def command(*arguments: str | os.PathLike[str], text: str | None = None, timeout: float | None = None) -> str:
    """Calls the program with any of its commands, and returns what it prints: `command("init", "quartic")`.

    `text` is a case for the argument "-". Paths may be given as they are.
    """
    done = called([os.fspath(argument) for argument in arguments], text, timeout)
    if done.returncode != 0:
        raise failure(done)
    return done.stdout
