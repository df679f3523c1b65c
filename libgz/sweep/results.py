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
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, TextIO

from libgz.base.budget import Budget, BudgetError
from libgz.base.errors import GazeboError, LibraryError, ParameterError
from libgz.base.extras import install
from libgz.base.files import exists, is_file, open_file, read_limited, write_whole
from libgz.sweep.pages import read_pages
from libgz.sweep.study import MOST_MEASURES, MOST_RUNS, Study

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
NUMBER, VALUE = 8, 32  # bytes, of a number in a file, and of a value that is held
LONGEST_FOOTER = 16 << 20  # bytes, of a part
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
        self.folder, self.columns, self.runs = folder, columns_of(study), len(study)
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
        self.recorded.add(row["run"])
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
            for row in _once(path, _csv_rows(path, ["run", "state"]), self.runs, self.recorded):
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
        for part in sorted(self.folder.glob("part-*.parquet")):
            for row in _once(part, _part_rows(part, Budget(), ["run", "state"]), self.runs, self.recorded):
                self._note(row)
        self._waiting: list[dict[str, Any]] = []
        path = self.folder / JOURNAL
        if path.is_file():
            _cut(path)
            for row in _once(path, self._left(path), self.runs, self.recorded):
                self._waiting.append(row)
                self._note(row)
        self._file = path.open("ab", buffering=0)
        self._since = time.monotonic()

    def _left(self, path: Path) -> Iterator[dict[str, Any]]:
        """The rows of a journal that are in no part; others are if the process ended between part and journal."""
        parts = frozenset(self.recorded)
        return (row for row in _journal_rows(path, self.columns) if row["run"] not in parts)

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
    """Check that results are a folder's own files: one of somebody else may have links to a user's files.

    Raises:
        GazeboError: one is a link, or a pipe or device, which would be waited for.
    """
    for path in (folder / ABOUT, folder / LOCK, folder / TABLE, folder / JOURNAL, *folder.glob("part-*.parquet")):
        if path.is_symlink():
            raise GazeboError(f"{path} is a symbolic link, which results cannot be; name another folder")
        if exists(path) and not is_file(path):
            raise GazeboError(f"{path} is no file, which results must be; name another folder")


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
        if len(known["measures"]) > MOST_MEASURES:
            raise ValueError(f"it has more than {MOST_MEASURES} measures")
        if not all(isinstance(name, str) for key in ("parameters", "random", "measures") for name in known[key]):
            raise TypeError("a name is no text")
        if known["format"] not in FORMATS:
            raise ValueError(f"its format is {known['format']!r}")
    return known


def _once(path: Path, rows: Iterable[dict[str, Any]], runs: int, known: Container[int]) -> Iterator[dict[str, Any]]:
    """The rows of a file; `known` has the runs of those before.

    Raises:
        ParameterError: one is of no run of the study, or of one that is known.
    """
    for row in rows:
        with _damage_named(path):
            if not 0 <= row["run"] < runs:
                raise ValueError(f"the study has no run {row['run']}")
            if row["run"] in known:
                raise ValueError(f"it has run {row['run']} again")
        yield row


def _csv_rows(path: Path, names: Sequence[str]) -> Iterator[dict[str, Any]]:
    """The rows of a table, with the columns of these names that it has, whatever else it has."""
    with _damage_named(path), path.open(newline="") as file:
        left = LONGEST_LINE  # of a row, which may have line breaks in quotes

        def lines() -> Iterator[str]:
            nonlocal left
            for line in _lines(file):
                left -= len(line)
                if left <= 0:
                    raise ValueError(TOO_LONG)
                yield line

        table = csv.reader(lines())
        head = {name: place for place, name in enumerate(next(table, ()))}
        places = [(name, head[name]) for name in names if name in head]
        whole = head["python"] if head else 0  # the last column
        for row in table:
            left = LONGEST_LINE
            if len(row) > whole and row[whole]:
                found = {name: row[place] for name, place in places}
                yield {**found, "run": int(row[head["run"]]), "state": row[head["state"]]}


def _part_rows(path: Path, budget: Budget, columns: Sequence[str]) -> list[dict[str, Any]]:
    """The rows of a part. The budget is of all that is held: of a file, a long text or a number may be for all rows."""
    with _damage_named(path), open_file(path) as file:
        _check_footer(file)
        about = _parquet().read_metadata(file)
        names = _check_part(about)
        _check_pages(about, file)
        part = _parquet().ParquetFile(file, read_dictionary=names)
        if not all(map(_is_kind, part.schema_arrow.types)):
            raise ValueError("it has columns of types that parts do not have")
        table = part.read(columns=list(columns))
        budget.take(VALUE * table.num_rows * table.num_columns)
        for column in table.columns:
            for chunk in column.chunks:
                budget.take(_size_of_texts(chunk))
        rows: list[dict[str, Any]] = table.to_pylist()
        if not all(isinstance(row["run"], int) and isinstance(row["state"], str) for row in rows):
            raise ValueError("runs without numbers")
    return rows


def _check_footer(file: BinaryIO) -> None:
    """Check how long the metadata of a part are: in memory they are many times as large.

    Raises:
        ValueError: no sweep wrote them.
    """
    end = file.seek(0, os.SEEK_END)
    file.seek(max(end - 8, 0))  # their length, and four letters
    if int.from_bytes(file.read(4), "little") > LONGEST_FOOTER:
        raise ValueError("its metadata are too long")
    file.seek(0)


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


def _journal_rows(path: Path, names: Sequence[str]) -> Iterator[dict[str, Any]]:
    """The rows of a journal, with the columns of these names that it has, whatever else it has."""
    with _damage_named(path), path.open() as file:
        for line in _lines(file):
            if line.endswith("\n"):  # else its process ended while it was written
                row = json.loads(line)
                found = {name: _held(row[name]) for name in names if name in row}
                yield {**found, "run": int(row["run"]), "state": _held(row["state"])}


def _held(value: Any) -> Any:
    """A value of a journal, as parts have it: lists and tables are texts."""
    return value if value is None or isinstance(value, bool | int | float | str) else _text(value)


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


def _files(folder: Path, format: str, names: Sequence[str]) -> Iterator[tuple[Path, Iterable[dict[str, Any]]]]:
    """The files of results, and the rows of each with columns of these names; all are held, within a budget."""
    budget = Budget()
    if format == "csv":
        if (path := folder / TABLE).is_file():
            yield path, _counted(path, _csv_rows(path, names), budget)
        return
    runs: set[int] = set()
    for path in sorted(folder.glob("part-*.parquet")):
        rows = _part_rows(path, budget, names)
        runs.update(row["run"] for row in rows)
        yield path, rows
    if (path := folder / JOURNAL).is_file():
        left = (row for row in _journal_rows(path, names) if row["run"] not in runs)
        yield path, _counted(path, left, budget)


def _counted(path: Path, rows: Iterable[dict[str, Any]], budget: Budget) -> Iterator[dict[str, Any]]:
    for row in rows:
        with _damage_named(path):
            budget.take(sum(VALUE + (len(value) if isinstance(value, str) else 0) for value in row.values()))
        yield row


def read_results(folder: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """What the folder says of its study, and of each run its number, state, parameters, controller and measures.

    Rows are in order of their runs; numbers are numbers.

    Raises:
        ParameterError: there are no results, a file of them is damaged, or they are too many.
        LibraryError: pyarrow is not installed.
        GazeboError: there are links in place of its files.
    """
    about = folder / ABOUT
    if not about.is_file():
        raise ParameterError(f"{str(folder)!r} has no results of a sweep: there is no {ABOUT} in it")
    _check_links(folder)
    known = _about(folder)
    needed = {*known["parameters"], *known["measures"], "controller"}
    rows: dict[int, dict[str, Any]] = {}
    for path, some in _files(folder, known["format"], [*{"run", "state"} | needed]):
        for row in _once(path, some, known["runs"], rows):
            if missing := needed - row.keys():
                raise ParameterError(f"{folder} is damaged: run {row['run']} has no {min(missing)!r}")
            row.update({name: _parsed(row[name]) for name in known["parameters"]} if known["format"] == "csv" else {})
            row.update({name: _measured(row[name]) for name in known["measures"]})
            row.update({name: float(str(value)) for name, value in row.items() if _is_long(value)})
            rows[row["run"]] = row
    return known, [rows[run] for run in sorted(rows)]


def _is_long(value: Any) -> bool:
    """Whether it is a whole number beyond 64 bits, which nothing computes with."""
    return isinstance(value, int) and not -(1 << 63) <= value < 1 << 63


def _parsed(text: str) -> Any:
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(text)
    return text


def _measured(value: Any) -> float:
    """What was measured; not a number if it is none."""
    try:
        return float(value)
    except (ValueError, TypeError, OverflowError):
        return math.nan
