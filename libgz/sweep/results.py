"""Results: the rows of a study's runs in a folder, written as they arrive; none is lost or written twice."""

from __future__ import annotations

import contextlib
import csv
import fcntl
import io
import json
import math
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, TextIO

from libgz.base.budget import Budget, BudgetError
from libgz.base.errors import GazeboError, LibraryError, ParameterError
from libgz.base.extras import install
from libgz.base.files import exists, is_file, open_file, read_limited, write_whole
from libgz.sweep.pages import read_pages
from libgz.sweep.study import MOST_RUNS, Study

__all__ = ["FORMATS", "CsvResults", "ParquetResults", "Results", "open_results", "read_results"]

FORMATS = ("csv", "parquet")
ABOUT, LOCK, TABLE, JOURNAL = "study.json", ".lock", "results.csv", "journal.jsonl"
PART_ROWS, PART_PERIOD = 10_000, 300.0  # a part of Parquet has so many rows, or is so old [s]
MOST_PART_ROWS = 10 * PART_ROWS  # that are read
LONGEST_LINE = 16 << 20  # characters
TOO_LONG = f"a line has more than {LONGEST_LINE} characters"
WHOLE = ("run", "seed", "attempts")
TEXTS = ("controller", "state", "message", "host", "libgz", "python")
COMPRESSION = "SNAPPY"  # of parts; it makes nothing more than some 20 times smaller
NUMBER = 8  # bytes
ENTRY, PAGE = 16, 1000  # bytes, of an entry of a dictionary beside its letters, and of what a page takes to be read


def columns_of(study: Study) -> list[str]:
    """The columns of a study's results."""
    measures = [one.name for one in study.measures]
    return [
        *("run", *study.parameters, "controller", "seed", "state", *measures),
        *("sim_time", "wall_time", "attempts", "message", "host", "libgz", "python"),
    ]


class Results:
    """Base of both formats: the folder, its lock, and which runs are recorded.

    Args:
        folder: of the results; it is made if it is missing.
        study: the study.
        digest: of the study.

    Raises:
        ParameterError: the folder has results of another study, in another format, or damaged ones.
        GazeboError: another process writes to it, or it cannot be written.
    """

    format: str

    def __init__(self, folder: Path, study: Study, digest: str) -> None:
        self.folder, self.columns = folder, columns_of(study)
        self.recorded: set[int] = set()
        self.failed = 0  # of them
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = (folder / LOCK).open("w")
        except OSError as error:
            raise GazeboError(f"cannot write {error.filename}: {error.strerror}") from None
        try:
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise GazeboError(f"{folder}: another process writes these results") from None
            self._check(digest, study)
            self._open(study)
        except BaseException:
            self._lock.close()
            raise

    def _check(self, digest: str, study: Study) -> None:
        about = self.folder / ABOUT
        if about.is_file():
            known = _about(self.folder)
            if known["digest"] != digest:
                raise ParameterError(
                    f"{self.folder} has the results of another study, or of this one before it, its world or its "
                    "Python files were changed; name another folder with --results, or remove this one"
                )
            if known["format"] != self.format:
                raise ParameterError(f"{self.folder} has results as {known['format']}, not as {self.format}")
            return
        known = {"digest": digest, "format": self.format, "runs": len(study), "parameters": study.parameters}
        known |= {"random": list(study.random), "measures": [one.name for one in study.measures]}
        write_whole(about, (json.dumps(known, indent=2) + "\n").encode())

    def add(self, row: Mapping[str, Any]) -> None:
        """Record a run; one that is recorded already is left out."""
        if row["run"] in self.recorded:
            return
        self._write({name: row.get(name) for name in self.columns})
        self._note(row)

    def _open(self, study: Study) -> None:
        """Note what is recorded, and open the file that rows are added to."""
        raise NotImplementedError

    def _note(self, row: Mapping[str, Any]) -> None:
        self.recorded.add(int(row["run"]))
        self.failed += row["state"] != "ok"

    def _write(self, row: dict[str, Any]) -> None:
        raise NotImplementedError

    def close(self) -> None:
        """End writing."""
        self._lock.close()


class CsvResults(Results):
    """One file, a line for each run."""

    format = "csv"

    def _open(self, study: Study) -> None:
        path = self.folder / TABLE
        if path.is_file():
            _cut(path)
            for row in _csv_rows(path):
                self._note(row)
        self._file = path.open("ab", buffering=0)
        if not path.stat().st_size:
            self._put(self.columns)

    def _put(self, values: Sequence[Any]) -> None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerow(values)
        self._file.write(text.getvalue().encode())  # in one call: a kill leaves a whole line, or the start of one

    def _write(self, row: dict[str, Any]) -> None:
        self._put([_text(row[name]) for name in self.columns])

    def close(self) -> None:
        """End writing."""
        os.fsync(self._file.fileno())
        self._file.close()
        super().close()


class ParquetResults(Results):
    """Files ``part-*.parquet``, which are one table together; what is not in a part yet is in a journal."""

    format = "parquet"

    def _open(self, study: Study) -> None:
        self._types = _parquet_types(study)
        budget = Budget()
        for part in sorted(self.folder.glob("part-*.parquet")):
            for row in _part_rows(part, budget, ["run", "state"]):
                self._note(row)
        self._waiting: list[dict[str, Any]] = []
        path = self.folder / JOURNAL
        if path.is_file():
            _cut(path)
            for row in _journal_rows(path):
                if row["run"] not in self.recorded:  # else the process ended between part and journal
                    self._waiting.append(row)
                    self._note(row)
        self._file = path.open("ab", buffering=0)
        self._since = time.monotonic()

    def _write(self, row: dict[str, Any]) -> None:
        self._file.write((json.dumps(row) + "\n").encode())
        self._waiting.append(row)
        if len(self._waiting) >= PART_ROWS or time.monotonic() > self._since + PART_PERIOD:
            self._flush()

    def _flush(self) -> None:
        """Write what waits as a part, whole or not at all, then empty the journal."""
        self._since = time.monotonic()
        if not self._waiting:
            return
        import pyarrow  # type: ignore[import-untyped]

        rows = sorted(self._waiting, key=lambda row: row["run"])
        columns = {name: [_as(kind, row.get(name)) for row in rows] for name, kind in self._types.items()}
        schema = pyarrow.schema([(name, getattr(pyarrow, kind)()) for name, kind in self._types.items()])
        out = io.BytesIO()
        _parquet().write_table(pyarrow.table(columns, schema=schema), out, compression=COMPRESSION)
        number = len(list(self.folder.glob("part-*.parquet")))
        write_whole(self.folder / f"part-{number:06}.parquet", out.getvalue())
        self._file.truncate(0)
        self._waiting.clear()

    def close(self) -> None:
        """Write what waits, and end."""
        self._flush()
        self._file.close()
        super().close()


def _parquet_types(study: Study) -> dict[str, str]:
    """Column -> its type in Parquet."""
    runs = [study.run(number) for number in {0, len(study) - 1}]
    types = {}
    samples: dict[str, list[Any]] = {name: [run.parameters[name] for run in runs] for name in study.parameters}
    for name in study.parameters:
        samples[name] += [*study.grid.get(name, ()), *(case[name] for case in study.cases if name in case)]
        if name in study.random and study.random[name].kind == "choice":
            samples[name] += study.random[name].values
    for name in columns_of(study):
        if name in samples:
            types[name] = _kind(samples[name])
        else:
            types[name] = "int64" if name in WHOLE else "string" if name in TEXTS else "float64"
    return types


def _kind(values: Sequence[Any]) -> str:
    if all(isinstance(value, bool) for value in values):
        return "bool_"
    if all(type(value) is int for value in values):
        return "int64"
    return "float64" if all(type(value) in (int, float) for value in values) else "string"


def _as(kind: str, value: Any) -> Any:
    if value is None:
        return None
    return float(value) if kind == "float64" else _text(value) if kind == "string" else value


def _parquet() -> Any:
    try:
        import pyarrow.parquet  # type: ignore[import-untyped]
    except ImportError as error:
        raise LibraryError(f"Parquet needs the extra `cluster`: {install('cluster')} ({error})") from None
    return pyarrow.parquet


def _text(value: Any) -> str:
    """A value for a CSV file: the shortest text that gives the same number."""
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    return value.replace("\n", " | ") if isinstance(value, str) else json.dumps(value)


def _check_links(folder: Path) -> None:
    """Check that results are written to a folder's own files: one of somebody else may have links to a user's files.

    Raises:
        GazeboError: one is a link, or a pipe or device, which would be waited for.
    """
    for path in (folder / ABOUT, folder / LOCK, folder / TABLE, folder / JOURNAL, *folder.glob("part-*.parquet")):
        if path.is_symlink():
            raise GazeboError(f"{path} is a symbolic link, which results are not written to; name another folder")
        if exists(path) and not is_file(path):
            raise GazeboError(f"{path} is no file, and results are not written to it; name another folder")


def _cut(path: Path) -> None:
    """Cut off the start of a line that was being written when its process ended."""
    with _damage_named(path), path.open("r+b") as file:
        end = file.seek(0, os.SEEK_END)
        start = max(end - LONGEST_LINE, 0)
        file.seek(start)
        whole = file.read().rfind(b"\n") + 1
        if start and not whole:
            raise ValueError(TOO_LONG)
        file.truncate(start + whole)


def _lines(file: TextIO) -> Iterator[str]:
    """The lines of a file.

    Raises:
        ValueError: one is longer than a sweep writes any.
    """
    while line := file.readline(LONGEST_LINE):
        if len(line) == LONGEST_LINE:
            raise ValueError(TOO_LONG)
        yield line


@contextlib.contextmanager
def _damage_named(path: Path) -> Iterator[None]:
    """Say of a file that a sweep did not write so what it is, and where."""
    try:
        yield
    except OSError as error:
        raise GazeboError(f"cannot read {path}: {error.strerror or error}") from None
    except BudgetError as error:
        raise ParameterError(f"cannot read {path}: {error}") from None
    except (ValueError, TypeError, LookupError, RecursionError, csv.Error) as error:
        raise ParameterError(f"{path} is damaged: {type(error).__name__}: {error}") from None


def _about(folder: Path) -> dict[str, Any]:
    """What the folder says of its study.

    Raises:
        ParameterError: it says nothing that a sweep wrote.
    """
    path = folder / ABOUT
    with _damage_named(path):
        known: dict[str, Any] = json.loads(read_limited(path))
        names = {"digest": str, "format": str, "runs": int, "parameters": list, "random": list, "measures": list}
        for name, kind in names.items():
            if not isinstance(known[name], kind):
                raise TypeError(f"{name} is {known[name]!r}")
        if not 0 <= known["runs"] <= MOST_RUNS:
            raise ValueError(f"it has {known['runs']} runs")
        if not all(isinstance(name, str) for key in ("parameters", "random", "measures") for name in known[key]):
            raise TypeError("a name is no text")
        if known["format"] not in FORMATS:
            raise ValueError(f"its format is {known['format']!r}")
    return known


def _csv_rows(path: Path) -> Iterator[dict[str, Any]]:
    with _damage_named(path), path.open(newline="") as file:
        for row in csv.DictReader(_lines(file)):
            yield {**row, "run": int(row["run"]), "state": row["state"], "python": row["python"]}


def _part_rows(path: Path, budget: Budget, columns: list[str] | None = None) -> list[dict[str, Any]]:
    """The rows of a part. The budget is of texts: the file may have one that is long, for all rows."""
    with _damage_named(path), open_file(path) as file:
        about = _parquet().read_metadata(file)
        names = _check_part(about)
        _check_pages(about, file)
        part = _parquet().ParquetFile(file, read_dictionary=names)
        if not all(map(_is_kind, part.schema_arrow.types)):
            raise ValueError("it has columns of types that parts do not have")
        table = part.read(columns=columns)
        for column in table.columns:
            for chunk in column.chunks:
                budget.take(_size_of_texts(chunk))
        rows: list[dict[str, Any]] = table.to_pylist()
        if not all(isinstance(row["run"], int) and isinstance(row["state"], str) for row in rows):
            raise ValueError("runs without numbers")
    return rows


def _check_part(about: Any) -> list[str]:
    """The names of the columns that hold texts, of a file with this metadata.

    Raises:
        ValueError: it is none that a sweep wrote, and reading it may take far more memory than its size.
        BudgetError: it is too large decompressed.
    """
    groups = [about.row_group(number) for number in range(about.num_row_groups)]
    rows = max(about.num_rows, sum(group.num_rows for group in groups))
    if rows > MOST_PART_ROWS:
        raise ValueError("it has more rows than a part")
    columns = [about.schema.column(number) for number in range(about.num_columns)]
    chunks = [group.column(number) for group in groups for number in range(group.num_columns)]
    known = (COMPRESSION, "UNCOMPRESSED")
    if any(chunk.compression not in known or "DELTA_BYTE_ARRAY" in chunk.encodings for chunk in chunks):
        raise ValueError("it has a compression that parts do not have")
    Budget().take(rows * len(columns) * NUMBER + sum(max(chunk.total_uncompressed_size, 0) for chunk in chunks))
    return [column.path for column in columns if column.physical_type == "BYTE_ARRAY"]


def _check_pages(about: Any, file: BinaryIO) -> None:
    """Check what the headers of a part's pages state, which its metadata need not agree with.

    Raises:
        ValueError: no sweep wrote them.
        BudgetError: there is too much decompressed.
    """
    budget = Budget()
    if not about.created_by.startswith("parquet-cpp"):  # of some other writers, pages are read beyond their columns
        raise ValueError(f"it was written by {about.created_by!r}")
    for number in range(about.num_row_groups):
        group = about.row_group(number)
        for chunk in map(group.column, range(group.num_columns)):
            starts = (chunk.data_page_offset, chunk.dictionary_page_offset if chunk.has_dictionary_page else None)
            start = min(place for place in starts if place is not None)
            if start < 0 or chunk.total_compressed_size < 0:
                raise ValueError("a column is nowhere in it")
            for page in read_pages(file, start, chunk.total_compressed_size):
                budget.take(PAGE + page.size + (ENTRY * page.values if page.dictionary else 0))
                if page.values > MOST_PART_ROWS:
                    raise ValueError("it has more rows than a part")


def _is_kind(kind: Any) -> bool:
    """Whether columns have a type: others may expand a short file as texts do, whose dictionary is read."""
    import pyarrow

    numbers = (pyarrow.bool_(), pyarrow.int64(), pyarrow.float64())
    return pyarrow.types.is_dictionary(kind) or kind in numbers


def _size_of_texts(values: Any) -> int:
    """How many bytes the texts have, each as often as it occurs; 0 of numbers."""
    import pyarrow
    import pyarrow.compute as compute  # type: ignore[import-untyped]

    if not pyarrow.types.is_dictionary(values.type):
        return 0
    return int(compute.sum(compute.take(compute.binary_length(values.dictionary), values.indices)).as_py() or 0)


def _journal_rows(path: Path) -> Iterator[dict[str, Any]]:
    with _damage_named(path), path.open() as file:
        for line in _lines(file):
            if line.endswith("\n"):  # else its process ended while it was written
                row = json.loads(line)
                yield {**row, "run": int(row["run"]), "state": row["state"]}


def open_results(folder: Path, study: Study, digest: str, wanted: str | None) -> Results:
    """The results of a study in a folder: new ones, or those that are there, to be continued.

    Args:
        folder: the folder.
        study: the study.
        digest: of it.
        wanted: one of `FORMATS`; None for that of the folder, or csv.

    Raises:
        ParameterError: the folder has other results.
        LibraryError: pyarrow is not installed.
        GazeboError: another process writes to it, it cannot be written, or has links in place of its files.
    """
    _check_links(folder)
    if wanted is None:
        wanted = _about(folder)["format"] if (folder / ABOUT).is_file() else "csv"
    if wanted == "csv":
        return CsvResults(folder, study, digest)
    _parquet()
    return ParquetResults(folder, study, digest)


def read_results(folder: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """What the folder says of its study, and all rows in order of their runs; numbers as numbers.

    Raises:
        ParameterError: there are no results, or a file of them is damaged.
        LibraryError: pyarrow is not installed.
    """
    about = folder / ABOUT
    if not about.is_file():
        raise ParameterError(f"{str(folder)!r} has no results of a sweep: there is no {ABOUT} in it")
    known = _about(folder)
    rows: list[dict[str, Any]]
    if known["format"] == "csv":
        numbers = {*known["measures"], "sim_time", "wall_time", "run", "seed", "attempts"}
        table = folder / TABLE
        rows = [
            {name: _parsed(text, name in numbers) for name, text in row.items()}
            for row in (_csv_rows(table) if table.is_file() else ())
            if row["python"]
        ]
    else:
        parts, budget = sorted(folder.glob("part-*.parquet")), Budget()
        rows = [row for part in parts for row in _part_rows(part, budget)]
        known_runs = {row["run"] for row in rows}
        journal = folder / JOURNAL
        rows += [row for row in (_journal_rows(journal) if journal.is_file() else ()) if row["run"] not in known_runs]
    needed = {*known["parameters"], *known["measures"], "controller"}
    for row in rows:
        row.update({name: float(str(value)) for name, value in row.items() if _is_long(value)})
        if missing := needed - row.keys():
            raise ParameterError(f"{folder} is damaged: run {row['run']} has no {min(missing)!r}")
    return known, sorted(rows, key=lambda row: row["run"])


def _is_long(value: Any) -> bool:
    """Whether it is a whole number beyond 64 bits, which nothing computes with."""
    return isinstance(value, int) and not -(1 << 63) <= value < 1 << 63


def _parsed(text: str, number: bool) -> Any:
    try:
        return int(text)
    except (ValueError, TypeError):
        pass
    try:
        return float(text)
    except (ValueError, TypeError):
        return math.nan if number else text
