"""Plots of what a study measured: a figure for each measure."""

from __future__ import annotations

import itertools
import math
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from libgz.base.errors import GazeboError, ParameterError
from libgz.base.files import new_file

__all__ = ["plot_measures"]

Row = Mapping[str, Any]
MOST_LINES, MOST_PANELS = 8, 4  # in one figure
MOST_BINS = 50
# Different texts along an axis, and characters of one, beyond which they are numbered, or of a name.
MOST_TEXTS, LONGEST = 50, 200
LARGEST = 1e100  # of a number that is plotted
MANY = 12  # different numbers, beyond which they are plotted as single points
_UNSAFE = re.compile(r"[^\w.-]+")


def plot_measures(about: Mapping[str, Any], rows: Sequence[Row], folder: Path) -> Iterator[Path]:
    """Write a figure for each measure, over the parameter with the most values; the files' paths.

    Lines are means over seeds and repeats, bands a standard deviation to each side; a line for each value of the second
    parameter, a panel for each of the third. Without parameters the figure is a histogram.

    Args:
        about: what the results' folder says of the study.
        rows: of the results.
        folder: where the figures go.

    Raises:
        ParameterError: no run succeeded.
        GazeboError: a figure cannot be written.
    """
    good = [{name: _plain(value) for name, value in row.items()} for row in rows if row["state"] == "ok"]
    if not good:
        raise ParameterError(f"none of the {len(rows)} recorded runs succeeded, so there is nothing to plot")
    names = [*about["parameters"], "controller"]
    counts = {name: len({_key(row[name]) for row in good}) for name in names}
    varied = [name for name in names if counts[name] > 1]
    chosen = [
        name for name in varied if name not in about["random"]
    ]  # what is sampled at random is spread, if it can be
    varied = sorted(chosen or varied[:1], key=lambda name: (not _numeric(good, name), -counts[name]))
    for measure, stem in zip(about["measures"], _stems(about["measures"]), strict=True):
        path = folder / f"{stem}.png"
        # Names of the study are text, not formulas; letters that the font does not have are no news, and may be many.
        with rc_context({"text.parse_math": False}), warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Glyph ")
            figure = _figure(good, measure, varied, len(rows) - len(good))
            try:
                folder.mkdir(parents=True, exist_ok=True)
                with open(path, "wb", opener=new_file) as file:
                    figure.savefig(file, dpi=120, format="png")
            except OSError as error:
                raise GazeboError(f"cannot write {path}: {error.strerror}") from None
        yield path


def _stems(measures: Iterable[str]) -> list[str]:
    """A name of a file for each measure, without its suffix: as similar as it can be, and no two the same."""
    found: dict[str, str] = {}  # by what is the same where upper and lower case are
    for measure in measures:
        stem = _UNSAFE.sub("-", measure).encode()[:LONGEST].decode(errors="ignore")
        numbered = (f"{stem}-{number}" for number in itertools.count(2))
        name = next(name for name in itertools.chain([stem], numbered) if name.casefold() not in found)
        found[name.casefold()] = name
    return list(found.values())


def _plain(value: Any) -> Any:
    """A value that can be plotted: a number beyond all that is measured is none."""
    if isinstance(value, int | float) and not -LARGEST <= value <= LARGEST:
        return math.nan
    return value


def _figure(rows: Sequence[Row], measure: str, varied: Sequence[str], failed: int) -> Figure:
    """The figure of a measure of runs that succeeded, besides `failed` others."""
    panels = _panels(rows, varied[2] if len(varied) > 2 else None)
    figure = Figure((1.5 + 5.0 * len(panels), 4.5), layout="constrained")
    for axes, (title, some) in zip(_row(figure, len(panels)), panels, strict=True):
        _plot(axes, some, measure, varied)
        axes.set_title(title)
    figure.suptitle(f"{measure[:LONGEST]}: {len(rows)} runs" + (f", {failed} more failed" if failed else ""))
    return figure


def _panels(rows: Sequence[Row], name: str | None) -> list[tuple[str, list[Row]]]:
    """(title, rows) for each value of a third parameter, if there is one, and it has few."""
    groups: dict[Any, list[Row]] = {}
    for row in rows:
        groups.setdefault(_key(row[name]) if name is not None else "", []).append(row)
    if not 1 < len(groups) <= MOST_PANELS:
        return [("", list(rows))]
    return [(f"{name} = {value}"[:LONGEST], group) for value, group in sorted(groups.items(), key=_order)]


def _order(item: tuple[Any, Any]) -> tuple[str, Any]:
    return str(type(item[0])), item[0]


def _row(figure: Figure, count: int) -> list[Any]:
    return list(figure.subplots(1, count, sharey=True, squeeze=False)[0])


def _key(value: Any) -> Any:
    return value if isinstance(value, int | float | str | bool) else str(value)


def _numeric(rows: Sequence[Row], name: str) -> bool:
    return all(isinstance(row[name], int | float) and not isinstance(row[name], bool) for row in rows)


def _plot(axes: Any, rows: Sequence[Row], measure: str, varied: Sequence[str]) -> None:
    axes.grid(alpha=0.3)
    if not varied:
        values = [row[measure] for row in rows if math.isfinite(row[measure])]
        axes.hist(values, bins=min(max(math.isqrt(len(values)), 5), MOST_BINS))
        axes.set(xlabel=measure[:LONGEST], ylabel="runs")
        return
    along, *others = varied
    label = along
    texts = [] if _numeric(rows, along) else sorted({str(_key(row[along])) for row in rows})
    if len(texts) > MOST_TEXTS or any(len(text) > LONGEST for text in texts):
        numbers = {text: number for number, text in enumerate(texts)}
        rows = [{**row, along: numbers[str(_key(row[along]))]} for row in rows]
        label = f"{along}, the number of its value"
    groups: dict[Any, list[Row]] = {}
    by = others[0] if others and len({_key(row[others[0]]) for row in rows}) <= MOST_LINES else None
    for row in rows:
        groups.setdefault(_key(row[by]) if by is not None else None, []).append(row)
    for value, group in sorted(groups.items(), key=_order):
        _line(axes, group, along, measure, None if by is None else f"{by} = {value}"[:LONGEST])
    axes.set(xlabel=label[:LONGEST], ylabel=measure[:LONGEST])
    if by is not None:
        axes.legend()


def _line(axes: Any, rows: Sequence[Row], along: str, measure: str, label: str | None) -> None:
    numeric = _numeric(rows, along)
    places: dict[Any, list[float]] = {}
    for row in rows:
        places.setdefault(_key(row[along]) if numeric else str(_key(row[along])), []).append(float(row[measure]))
    keys = sorted(places)
    if len(keys) > MANY and max(map(len, places.values())) == 1:
        axes.plot(keys, [places[key][0] for key in keys], ".", label=label)
        return
    mean, spread = (np.array([function(places[key]) for key in keys]) for function in (np.mean, np.std))
    (line,) = axes.plot(keys, mean, "o-" if numeric else "o", label=label)
    if numeric:
        axes.fill_between(keys, mean - spread, mean + spread, color=line.get_color(), alpha=0.2, linewidth=0)
    else:
        axes.errorbar(keys, mean, spread, color=line.get_color(), fmt="none", capsize=4)
