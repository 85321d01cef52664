"""Tables of the program as record arrays."""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    Table = np.recarray[Any, np.dtype[np.record]]

# What is text in these tables even where no cell shows it, as in a column of messages that are all empty.
_TEXT = {
    "events.csv": {"event"},
    "runs-events.csv": {"event"},
    "runs.csv": {"status", "verdict", "ended_by", "proof_status", "message"},
}
_WHOLE = {"window", "row", "exit_code"}


def read_table(path: str | os.PathLike[str]) -> Table:
    """Reads a CSV of the program: `table["x"]` and `table.x` are the column x.

    Columns are doubles; window, row and exit_code are integers, and a column in which any cell is no number is text. An
    empty cell is nan. More digits than a double has are rounded away: read the file itself for those.
    """
    path = Path(path)
    with path.open(newline="", encoding="utf-8") as file:
        header = next(csv.reader(file))
    numbers = np.dtype([(name, np.int64 if name in _WHOLE else np.float64) for name in header])
    text = _TEXT.get(path.name, set())
    if text.isdisjoint(header):
        try:
            return _quickly(path, numbers)
        except ValueError:
            # There are cells that are empty, or no numbers.
            pass
    return _by_columns(path, text)


def _quickly(path: Path, numbers: np.dtype[np.void]) -> Table:
    """A table of nothing but numbers, in half the time and without a string for every cell."""
    with path.open(encoding="utf-8") as file:
        next(file)
        if not file.readline():
            return np.empty(0, numbers).view(np.recarray)
    rows = np.loadtxt(path, numbers, delimiter=",", skiprows=1, ndmin=1, comments=None, encoding="utf-8")
    return rows.view(np.recarray)


def _by_columns(path: Path, text: set[str]) -> Table:
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    columns = [_column(name, [row[place] for row in rows], name in text) for place, name in enumerate(header)]
    table = np.empty(len(rows), [(name, column.dtype) for name, column in zip(header, columns)])
    for name, column in zip(header, columns):
        table[name] = column
    return table.view(np.recarray)


def _column(name: str, cells: list[str], is_text: bool) -> np.ndarray[Any, np.dtype[Any]]:
    if not is_text:
        try:
            if name in _WHOLE:
                return np.array([int(cell) for cell in cells], np.int64)
            return np.array([float(cell or "nan") for cell in cells], np.float64)
        except ValueError:
            pass
    return np.array(cells, np.str_)
