"""Tables of results: structured arrays whose columns pandas reads, too."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Between the name of a group and the state, and between the state and the variable.
_OF, _BY = ".", "/"
#: Most rows of a table in a notebook.
MOST_ROWS = 20


def _members(names: Sequence[str], group: str) -> list[str]:
    found = [name for name in names if name.startswith((group + _OF, group + _BY))]
    if not found:
        raise KeyError(f"there is no column {group!r}: they are {', '.join(names)}")
    return found


def _shape(members: Sequence[str]) -> tuple[int, ...]:
    """The shape of a group: states, variables, or states by variables."""
    if not (_OF in members[0] and _BY in members[0]):
        return (len(members),)
    columns = len({name.rpartition(_BY)[2] for name in members})
    return len(members) // columns, columns


class Row(np.void):  # type: ignore[misc]
    """A row of a `Table`."""

    def __getitem__(self, key: Any) -> Any:
        names = self.dtype.names or ()
        if isinstance(key, str) and key not in names:
            members = _members(names, key)
            return np.array([self[name] for name in members]).reshape(_shape(members))
        return super().__getitem__(key)


class Table(np.ndarray[Any, Any]):
    """A structured array with a column for each number, as `pandas.DataFrame` reads it.

    ``table["t"]`` is a column. Columns of all states, such as ``y.x`` and ``y.v``, are also one
    array, ``table["y"]``, with the states on its last axis. Rows are the same:
    ``table[0]["y"]`` is a state.
    """

    def __getitem__(self, key: Any) -> Any:
        names = self.dtype.names or ()
        if not isinstance(key, str):
            return super().__getitem__(key)
        if key in names:
            return np.asarray(super().__getitem__(key))
        members = _members(names, key)
        columns = [np.asarray(super(Table, self).__getitem__(name)) for name in members]
        return np.stack(columns, axis=-1).reshape(*self.shape, *_shape(members))

    def to_pandas(self) -> Any:
        """The table as a `pandas.DataFrame`.

        Returns
        -------
        pandas.DataFrame
        """
        return pandas().DataFrame(self)

    def to_xarray(self) -> Any:
        """The table as an `xarray.Dataset` along the dimension ``row``.

        Returns
        -------
        xarray.Dataset
            Columns of all states are one variable, with the coordinate ``state``. Those of
            derivatives have ``by``, the variables.
        """
        names = self.dtype.names or ()
        variables: dict[str, Any] = {}
        coordinates: dict[str, Any] = {}
        for name in names:
            group = name.partition(_OF)[0].partition(_BY)[0]
            if group in variables:
                continue
            if group == name:
                variables[name] = ("row", self[name])
                continue
            members = _members(names, group)
            dimensions = ["row"]
            if _OF in members[0]:
                states = (one.partition(_OF)[2].partition(_BY)[0] for one in members)
                coordinates["state"] = list(dict.fromkeys(states))
                dimensions.append("state")
            if _BY in members[0]:
                coordinates["by"] = list(dict.fromkeys(one.rpartition(_BY)[2] for one in members))
                dimensions.append("by")
            variables[group] = (dimensions, self[group])
        return xarray().Dataset(variables, coordinates)

    def _repr_html_(self) -> str:
        return as_html({name: self[name] for name in self.dtype.names or ()})


@lru_cache(maxsize=256)
def _dtype(fields: tuple[tuple[str, Any], ...]) -> np.dtype[np.void]:
    return np.dtype((Row, list(fields)))


def structured(
    columns: Mapping[str, Any], axes: Sequence[str] = (), by: Sequence[str] = ()
) -> Table:
    """Makes a table from columns of texts, numbers, or rows of numbers.

    Texts are a list, or a pair: the distinct ones, and for each entry its index among them. `axes`
    are the names of the states, `by` those of the variables of derivatives.
    """
    first = next(iter(columns.values()))
    count = len(first[1] if isinstance(first, tuple) else first)
    types: list[tuple[str, Any]] = []
    flat: list[Any] = []
    for name, values in columns.items():
        words = values[0] if isinstance(values, tuple) else values
        if isinstance(words, list):
            types.append((name, f"U{max(map(len, words), default=0) or 1}"))
            # A single text fills the whole column.
            is_one = isinstance(values, tuple) and len(words) == 1
            is_indexed = isinstance(values, tuple) and count and not is_one
            flat += [words[0] if is_one else np.array(words)[values[1]] if is_indexed else words]
        elif values.ndim == 1:
            types.append((name, values.dtype.str))
            flat.append(values)
        else:
            kind = values.dtype.str
            if name == "dt":
                types += [(name + _BY + one, kind) for one in by]
            elif values.ndim == 2:
                types += [(name + _OF + one, kind) for one in axes]
            else:
                types += [(f"{name}{_OF}{one}{_BY}{other}", kind) for one in axes for other in by]
            flat.extend(values.reshape(count, -1).T if count else ())
    found = np.zeros(count, dtype=_dtype(tuple(types)))
    if count:
        for (name, _), values in zip(types, flat):
            found[name] = values
    return found.view(Table)


def pandas() -> Any:
    """The module pandas."""
    try:
        import pandas  # type: ignore[import-untyped,import-not-found,unused-ignore]
    except ImportError as error:
        raise ImportError("tables need pandas: pip install 'stickslip[pandas]'") from error
    return pandas


def xarray() -> Any:
    """The module xarray."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError("data sets need xarray: pip install 'stickslip[xarray]'") from error
    return xarray


def short(value: Any) -> str:
    """A value in a few letters."""
    if isinstance(value, np.ndarray):
        if value.size > 4 or value.dtype.names:
            return f"<{' × '.join(map(str, value.shape))}>"
        return np.array2string(value, precision=6, separator=", ")
    if isinstance(value, (list, tuple)):
        if len(value) > 4 or any(isinstance(one, np.ndarray) for one in value):
            return f"<{len(value)}>"
    if isinstance(value, dict):
        return f"<{', '.join(map(str, value))}>"
    return f"{value:.6g}" if isinstance(value, (float, np.floating)) else str(value)


def as_html(columns: Mapping[str, Sequence[Any] | NDArray[Any]]) -> str:
    """A table for notebooks, with its first rows."""
    count = max(map(len, columns.values()), default=0)

    def cell(kind: str, text: str) -> str:
        return f"<{kind}>{html.escape(text)}</{kind}>"

    heads = "".join(cell("th", name) for name in columns)
    lines = ["<table>", f"<thead><tr>{heads}</tr></thead>"]
    for k in range(min(count, MOST_ROWS)):
        row = "".join(cell("td", short(values[k])) for values in columns.values())
        lines.append(f"<tr>{row}</tr>")
    lines.append("</table>")
    if count > MOST_ROWS:
        lines.append(f"<p>{count} rows</p>")
    return "\n".join(lines)
