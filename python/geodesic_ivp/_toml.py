"""Values of Python as values of TOML, the language of cases. Python can read TOML from 3.11 on, and write none."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import Any

# Keys may be dotted, as in {"grid.t_f": 20.0}.
_BARE = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")


def value(thing: Any) -> str:
    """One value, on one line. Arrays and numbers of NumPy are what `tolist` makes of them."""
    if hasattr(thing, "tolist"):
        thing = thing.tolist()
    if isinstance(thing, bool):
        return "true" if thing else "false"
    if isinstance(thing, (int, float)):
        # The shortest decimal that reads back to the same double. TOML has inf and nan, too.
        return repr(thing)
    if isinstance(thing, Decimal):
        return str(thing).lower().replace("infinity", "inf")
    if isinstance(thing, str):
        # Strings of JSON are strings of TOML, but for one character that TOML wants escaped.
        return json.dumps(thing, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(thing, Mapping):
        return "{ " + ", ".join(_pairs(thing)) + " }" if thing else "{}"
    if isinstance(thing, Sequence) and not isinstance(thing, (bytes, bytearray)):
        return "[" + ", ".join(value(part) for part in thing) + "]"
    raise TypeError(f"a case has no value of the type {type(thing).__name__}: {thing!r}")


def document(case: Mapping[str, Any]) -> str:
    """The text of a case, with a line for each of its keys."""
    return "".join(line + "\n" for line in _pairs(case))


def _pairs(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(key)} = {value(thing)}" for key, thing in table.items()]


def _key(key: Any) -> str:
    if not isinstance(key, str):
        raise TypeError(f"a key of a case is a string, and {key!r} is none")
    return key if _BARE.fullmatch(key) else value(key)
