"""What a run and a sweep have left, in a folder."""

from __future__ import annotations

import json
import shutil
import weakref
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._tables import read_table

if TYPE_CHECKING:
    import pandas

    from ._tables import Table


class DoubtfulWarning(UserWarning):
    """A result is doubtful. The program ends with exit code 0 then, and nobody reads what it prints."""


class _Result:
    """A folder of results. Tables are read when they are asked for, and then kept."""

    def __init__(self, folder: Path, report: str, temporary: Path | None = None) -> None:
        self.folder = folder
        """Where the files are. Without `out` the folder is removed when nothing refers to the result any more."""
        self.report = report
        """What the program printed: the verdict and the numbers that stand behind it, for people."""
        self._tables: dict[str, Table] = {}
        if temporary:
            weakref.finalize(self, shutil.rmtree, temporary, ignore_errors=True)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The content of `summary.json`; docs/results.md says what its keys mean."""
        text = (self.folder / "summary.json").read_text(encoding="utf-8")
        summary: dict[str, Any] = json.loads(text)
        return summary

    @property
    def tables(self) -> list[str]:
        """The names of the tables that are there."""
        return sorted({path.stem for path in self.folder.glob("*.csv")} | self._tables.keys())

    def table(self, name: str) -> Table:
        """A table by the name of its file without `.csv`, as a record array."""
        if name not in self._tables:
            if name not in self.tables:
                raise LookupError(f"there is no {name}.csv: the tables are {', '.join(self.tables) or 'none'}")
            self._tables[name] = read_table(self.folder / f"{name}.csv")
        return self._tables[name]

    def __str__(self) -> str:
        return self.report

    def __getstate__(self) -> dict[str, Any]:
        """What another process gets: all that has to be read, as the folder may be gone when it looks."""
        for name in self.tables:
            self.table(name)
        return {"summary": self.summary, "folder": self.folder, "report": self.report, "_tables": self._tables}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)


class Run(_Result):
    """One solved case. `print(run)` shows what the program printed."""

    @property
    def verdict(self) -> str:
        """`proved`, `trusted`, `doubtful` or `refused`; docs/trust.md says what they mean."""
        return str(self.summary["verdict"])

    @property
    def is_good(self) -> bool:
        """True if the verdict is `proved` or `trusted`."""
        return self.verdict in ("proved", "trusted")

    @property
    def reasons(self) -> list[str]:
        """Why a result is doubtful, the most important reason first, each with its remedy."""
        reasons = self.summary.get("verdict_reasons", [])
        return [f"{reason['reason']}: {reason['remedy']}" for reason in reasons]

    @property
    def trajectory(self) -> Table:
        """The world-line at the nodes: gamma, every coordinate, and every dq/dgamma."""
        return self.table("trajectory")

    @property
    def residuals(self) -> Table:
        """Charges and residuals of the geodesic equations at the nodes."""
        return self.table("residuals")

    @property
    def samples(self) -> Table:
        """The world-line at the values that `sample_t` or `sample_gamma` asked for."""
        return self.table("samples")

    @property
    def events(self) -> Table:
        """The events of a scene, in the order of gamma."""
        return self.table("events")

    def to_pandas(self, name: str = "trajectory") -> pandas.DataFrame:
        """A table as a DataFrame, where pandas is installed."""
        return _frame(self.table(name))

    def __repr__(self) -> str:
        return f"<Run of {self.summary.get('title') or 'a case'}: {self.verdict}, in {self.folder}>"


class Sweep(_Result):
    """Many runs of one case: a table with a row for each."""

    @property
    def runs(self) -> Table:
        """A row for each run: what varied, the verdict, the end, and how far it can be trusted."""
        return self.table("runs")

    @property
    def events(self) -> Table:
        """The events of all rows."""
        return self.table("runs-events")

    @property
    def samples(self) -> Table:
        """The samples of all rows, at the values that `sample_t` or `sample_gamma` asked for."""
        return self.table("runs-samples")

    def to_pandas(self, name: str = "runs") -> pandas.DataFrame:
        """A table as a DataFrame, where pandas is installed."""
        return _frame(self.table(name))

    def __repr__(self) -> str:
        rows, solved = self.summary["rows"], self.summary["solved"]
        return f"<Sweep of {self.summary.get('title') or 'a case'}: {solved} of {rows} rows solved, in {self.folder}>"


def _frame(table: Table) -> pandas.DataFrame:
    import pandas

    return pandas.DataFrame({name: table[name] for name in table.dtype.names or ()})
