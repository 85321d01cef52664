"""Initial value problems of mechanics and geometry, solved by the program `geodesic-ivp`.

    import geodesic_ivp

    run = geodesic_ivp.run("quartic", set={"solver.accuracy": 1e-10}, sample_t="0:1:0.1")
    print(run)                                  # the verdict first
    run.samples.t, run.samples.x                # columns of a NumPy record array

The program is called as on a command line, and what it writes is read. `program()` says which one that is.
"""

from ._program import (
    CaseError,
    ExpectationNotMet,
    FileError,
    GeodesicError,
    Interrupted,
    NoSolution,
    OutsideDomain,
    ProgramNotFound,
    command,
    program,
)
from ._results import DoubtfulWarning, Run, Sweep
from ._solve import run, vary
from ._tables import read_table

__all__ = [
    "CaseError",
    "DoubtfulWarning",
    "ExpectationNotMet",
    "FileError",
    "GeodesicError",
    "Interrupted",
    "NoSolution",
    "OutsideDomain",
    "ProgramNotFound",
    "Run",
    "Sweep",
    "command",
    "program",
    "read_table",
    "run",
    "vary",
]
