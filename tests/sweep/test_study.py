"""Studies: which runs there are, and what is wrong in a file."""

import io
import json
import os
import tomllib

import pyarrow
import pytest
from pyarrow import parquet

from libgz.base.budget import Budget
from libgz.base.errors import GazeboError, ParameterError
from libgz.sweep import results
from libgz.sweep.pages import Page, read_pages
from libgz.sweep.report import plot_measures
from libgz.sweep.results import open_results, read_results
from libgz.sweep.run import check
from libgz.sweep.study import Study


def test_runs_are_given_by_their_numbers(folder):
    study = Study.load(folder / "push.toml")
    runs = list(study.runs())
    assert len(study) == len(runs) == 8
    assert [run.seed for run in runs] == [0, 1] * 4
    assert [run.settings for run in runs] == [{"speed": 0.2}] * 2 + [{"speed": 0.4}] * 2 + [{"speed": 0.2}] * 2 + [
        {"speed": 0.4}
    ] * 2
    assert [run.changes["crate/mass"] for run in runs] == [1.0] * 4 + [8.0] * 4
    assert len({run.changes["crate/xyz[0]"] for run in runs}) == 1  # one repeat, for all
    assert 0.5 <= runs[0].changes["crate/xyz[0]"] <= 0.8


def test_a_million_runs_are_not_listed(folder):
    table = tomllib.loads((folder / "push.toml").read_text())
    study = Study.of({**table, "repeats": 1_000_000}, folder)
    assert len(study) == 8_000_000
    assert study.run(7_999_999) == study.run(7_999_999)
    assert study.run(0).parameters["crate/xyz[0]"] != study.run(4).parameters["crate/xyz[0]"]


def test_cases_of_a_list(folder):
    table = tomllib.loads((folder / "push.toml").read_text())
    table["parameters"] = {}
    study = Study.of(
        {
            **table,
            "seeds": [7],
            "list": [{"crate/mass": 1, "crate/xyz": [2, 0, 0]}, {"crate/mass": 2, "crate/xyz": [3, 0, 0]}],
        },
        folder,
    )
    assert [(run.parameters["crate/mass"], run.seed) for run in study.runs()] == [(1, 7), (2, 7)]


def test_the_digest_follows_the_files(folder):
    before = Study.load(folder / "push.toml").digest()
    assert Study.load(folder / "push.toml").digest() == before
    (folder / "drive.py").write_text((folder / "drive.py").read_text() + "\n# changed\n")
    assert Study.load(folder / "push.toml").digest() != before


WRONG = [
    ("duration = 1.0", "duration = 0", "duration is 0; it must be a number above 0"),
    ("duration = 1.0", "", "duration is missing"),
    ("duration = 1.0", "duraton = 1.0", "did you mean 'duration'"),
    ("seeds = 2", "seeds = [1, 1]", "seeds is"),
    ("seeds = 2", "repeats = 0", "repeats is 0"),
    ('"crate/mass" = [1.0, 8.0]', '"crate/mass" = {unifrm = [1, 2]}', "crate/mass: there is no distribution 'unifrm'"),
    ('"crate/mass" = [1.0, 8.0]', '"seed" = [1]', "parameter 'seed' is not allowed"),
    ("drive.py:Drive", "drve.py:Drive", "there is no file"),
    ("drive.py:Drive", "drive.py", "names no function"),
    ('reduce = "max"', 'reduce = "maximum"', "reduce is 'maximum'; allowed are last, first"),
    ('distance = "robot1/pos[0]"', 'distance = "robot1"', "is no signal; write KEY/FIELD"),
    ('distance = "robot1/pos[0]"', 'run = "robot1/pos[0]"', "has the name of another column"),
    ("seeds = 2", 'solver = "fast"', "allowed are world, quick"),
    ("seeds = 2", "start = 2.0", "it must be before the end"),
    ("seeds = 2", "= 2", "Invalid statement"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_errors_of_a_file(folder, old, new, message):
    path = folder / "push.toml"
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ParameterError, match=r"push\.toml: ") as error:
        Study.load(path)
    assert message in str(error.value)


UNKNOWN = [
    ('"crate/mass"', '"crate/mas"', "nothing in the world reads <mas>; did you mean 'mass'"),
    ('"crate/mass"', '"crat/mass"', "did you mean 'crate'"),
    ("robot1/pos[0]", "robot2/pos[0]", "did you mean 'robot1'"),
    ("robot1/pos[0]", "robot1/pos", "choose one number, such as [0], or reduce it"),
    ("drive.py:Drive", "drive.py:Drve", "did you mean 'Drive'"),
]


@pytest.mark.parametrize(("old", "new", "message"), UNKNOWN)
def test_names_are_checked_before_the_first_run(folder, old, new, message):
    path = folder / "push.toml"
    path.write_text(path.read_text().replace(old, new))
    study = Study.load(path)
    with pytest.raises(GazeboError) as error:
        check(study)
    assert message in str(error.value)


NUL = '"a\\u0000"'
HOSTILE = [  # a line of the study, what it becomes
    ("seeds = 2", "list = " + "[" * 100_000),
    ("seeds = 2", "seed = " + "1" * 5000),
    ("seeds = 2", "seed = 0x" + "f" * 5000),
    ("seeds = 2", "seeds = 1_000_000_000_000"),
    ("seeds = 2", "repeats = 9_000_000_000_000_000_000"),
    ("duration = 1.0", "duration = 1" + "0" * 400),
    ("seeds = 2", "limits = {time = 1" + "0" * 400 + "}"),
    ('"push.world"', '"' + "x" * 5000 + '"'),
    ('"push.world"', NUL),
    ("drive.py:Drive", "x" * 5000 + ".py:Drive"),
    ("[0.5, 0.8]", "[0, 1" + "0" * 400 + "]"),
    ("[0.5, 0.8]", "[-1.7e308, 1.7e308]"),
    ("uniform = [0.5, 0.8]", "integers = [0, 9_223_372_036_854_775_807]"),
    ("[1.0, 8.0]", "{choice = []}"),
]


@pytest.mark.parametrize(("old", "new"), HOSTILE, ids=[new[:40] for _, new in HOSTILE])
def test_no_text_ends_in_more_than_one_sentence(folder, old, new):
    path = folder / "push.toml"
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(GazeboError):
        Study.load(path).digest()  # the digest reads the world that it names


def test_too_many_runs_are_refused(folder):
    table = tomllib.loads((folder / "push.toml").read_text())
    table["parameters"] |= {f"crate/x{i}": list(range(10)) for i in range(100)}
    with pytest.raises(ParameterError, match="more than 1000000000 runs"):
        Study.of(table, folder)


def results_of(folder):
    study = Study.load(folder / "push.toml")
    return open_results(folder / "results", study, study.digest(), "csv")


DAMAGED = [
    ("study.json", b"["),
    ("study.json", b"[" * 100_000),
    ("study.json", b"{}"),
    ("study.json", b"\xff"),
    ("study.json", b'{"digest": "", "format": "csv", "runs": 1, "parameters": [[]], "random": [], "measures": []}'),
    ("results.csv", b"run,state,python\nx,ok,3\n"),
    ("results.csv", b"run,python\n1,3\n"),
    ("results.csv", b"\xff\n1\n"),
    ("results.csv", b'run,state,python\n"' + b"x" * 200_000 + b'",ok,3\n'),
]


@pytest.mark.parametrize(("name", "content"), DAMAGED)
def test_damaged_results_are_named(folder, name, content):
    results_of(folder).close()
    (folder / "results" / name).write_bytes(content)
    for use in (lambda: read_results(folder / "results"), lambda: results_of(folder)):
        with pytest.raises(ParameterError, match=f"{name} is damaged"):
            use()


@pytest.mark.parametrize("format", ["csv", "parquet"])
def test_a_line_that_does_not_end_is_not_held(folder, monkeypatch, format):
    study = Study.load(folder / "push.toml")
    open_results(folder / "results", study, "x", format).close()
    file = folder / "results" / {"csv": "results.csv", "parquet": "journal.jsonl"}[format]
    monkeypatch.setattr(results, "LONGEST_LINE", 1000)
    with file.open("ab") as table:
        table.truncate(1 << 40)  # without blocks of the disk
    for use in (lambda: read_results(folder / "results"), lambda: open_results(folder / "results", study, "x", None)):
        with pytest.raises(ParameterError, match=f"{file.name} is damaged: ValueError: a line has more than"):
            use()


def test_a_part_of_more_rows_than_a_sweep_writes_is_not_held(folder, monkeypatch):
    study = Study.load(folder / "push.toml")
    kept = open_results(folder / "results", study, "x", "parquet")
    for run in range(3):
        kept.add({"run": run, "state": "ok", "controller": "c", "python": "3"})
    kept.close()
    assert len(read_results(folder / "results")[1]) == 3
    monkeypatch.setattr(results, "MOST_PART_ROWS", 2)
    with pytest.raises(ParameterError, match="ValueError: it has more rows than a part"):
        read_results(folder / "results")


def test_a_part_whose_texts_are_far_longer_than_the_file_is_refused(folder, monkeypatch):
    part = folder / "results" / "part-000000.parquet"
    study = Study.load(folder / "push.toml")
    kept = open_results(folder / "results", study, "x", "parquet")
    for run in range(3):
        kept.add({"run": run, "state": "ok", "controller": "c" * 1_000_000, "python": "3"})
    kept.close()
    assert part.stat().st_size < 200_000
    assert len(read_results(folder / "results")[1]) == 3
    monkeypatch.setenv("LIBGZ_DECOMPRESSED", "2")
    with pytest.raises(ParameterError, match=r"part-000000.parquet: it takes more than 2 MiB decompressed"):
        read_results(folder / "results")
    write_part(part, {"run": [0] * 4, "state": ["x" * 1_000_000] * 4})
    for use in (lambda: read_results(folder / "results"), lambda: open_results(folder / "results", study, "x", None)):
        with pytest.raises(ParameterError, match=r"part-000000.parquet: it takes more than 2 MiB decompressed"):
            use()


def test_a_part_with_more_numbers_than_may_be_held_is_refused(folder, monkeypatch):
    open_results(folder / "results", Study.load(folder / "push.toml"), "x", "parquet").close()
    numbers = {f"n{column}": [1.5] * 10_000 for column in range(20)}  # of which the file has one
    write_part(folder / "results" / "part-000000.parquet", {"run": range(10_000), "state": ["ok"] * 10_000, **numbers})
    monkeypatch.setenv("LIBGZ_DECOMPRESSED", "1")
    with pytest.raises(ParameterError, match=r"part-000000.parquet: it takes more than 1 MiB decompressed"):
        read_results(folder / "results")


@pytest.mark.parametrize(
    ("columns", "options"),
    [
        ({"run": [[1] * 9]}, {}),
        ({"run": [1] * 9, "state": [{"text": "x" * 100_000}] * 9}, {}),
        ({"run": [1] * 9, "state": pyarrow.array([b"x" * 100_000] * 9, pyarrow.binary(100_000))}, {}),
        ({"run": [1] * 9, "state": pyarrow.array(['"x"'] * 9).cast(pyarrow.json_())}, {}),
        ({"run": [1], "state": ["ok"]}, {"compression": "zstd"}),
        (
            {"run": [1], "state": ["ok"]},
            {"use_dictionary": False, "column_encoding": {"run": "PLAIN", "state": "DELTA_BYTE_ARRAY"}},
        ),
    ],
)
def test_a_part_whose_form_no_sweep_writes_is_refused(folder, columns, options):
    open_results(folder / "results", Study.load(folder / "push.toml"), "x", "parquet").close()
    write_part(folder / "results" / "part-000000.parquet", columns, **options)
    with pytest.raises(ParameterError, match=r"is damaged: ValueError: it has .* that parts do not have"):
        read_results(folder / "results")


@pytest.mark.parametrize("kind", ["dictionary", "data"])
def test_a_page_that_states_more_than_its_column_is_refused(folder, monkeypatch, kind):
    """Pyarrow allocates what the header of a page says, whatever the footer of the file says."""
    open_results(folder / "results", Study.load(folder / "push.toml"), "x", "parquet").close()
    study = Study.load(folder / "push.toml")
    part = folder / "results" / "part-000000.parquet"
    options = {"use_dictionary": kind == "dictionary", "compression": "none", "write_statistics": False}
    write_part(part, {"run": [0], "state": ["x" * 20_000]}, **options)
    monkeypatch.setenv("LIBGZ_DECOMPRESSED", "1")
    assert len(results._part_rows(part, Budget(), ["run", "state"])) == 1
    chunk = parquet.read_metadata(part).row_group(0).column(1)
    start = chunk.dictionary_page_offset if kind == "dictionary" else chunk.data_page_offset
    (page, *_) = read_pages(io.BytesIO(part.read_bytes()), start, chunk.total_compressed_size)
    assert page.dictionary == (kind == "dictionary")
    assert page.values == 1
    assert 20_000 < page.size < 20_100
    data = part.read_bytes()
    at = data.index(varint(page.size), start)
    part.write_bytes(data[:at] + varint((1 << 20) - 1) + data[at + len(varint(page.size)) :])  # of as many bytes
    for use in (lambda: read_results(folder / "results"), lambda: open_results(folder / "results", study, "x", None)):
        with pytest.raises(ParameterError, match=r"part-000000.parquet: it takes more than 1 MiB decompressed"):
            use()


def varint(number):
    """A positive whole number as Thrift's compact protocol writes it."""
    number, found = number << 1, b""
    while number > 127:
        number, found = number >> 7, found + bytes((number & 127 | 128,))
    return found + bytes((number,))


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (b"", "cut off"),
        (b"\x15", "cut off"),
        (b"\x15" + b"\xff" * 20, "damaged"),
        (b"\x1f\x00", "damaged"),
        (b"\x18\xff\xff\xff\xff\xff\xff\xff\xff\x7f", "damaged"),
        (b"\x1c" * 100, "too deeply"),
        (b"\x19" * 100, "too deeply"),
        (b"\x19\xfc\xff\xff\xff\xff\x7f", "cut off"),
        (b"\x25\x01\x00", "damaged"),  # of -1 bytes
        (b"\x35\x80\x01\x00", "longer than its column"),
    ],
)
def test_a_damaged_header_of_a_page_is_refused(header, message):
    with pytest.raises(ValueError, match=message):
        list(read_pages(io.BytesIO(header), 0, 10))


def test_other_fields_of_a_page_are_skipped():
    fields = b"\x11\x12\x13\x07\x17" + bytes(8) + b"\x18\x02ab" + b"\x19\x25\x02\x04" + b"\x1b\x01\x55\x02\x04"
    fields += b"\x05" + varint(20) + varint(9)  # field 20, by its whole number
    file = io.BytesIO(b"\x25" + varint(7) + b"\x15" + varint(0) + b"\x4c\x15" + varint(3) + fields + b"\x00\x00")
    assert list(read_pages(file, 0, len(file.getvalue()))) == [Page(7, 3, True)]


def write_part(path, columns, **options):
    parquet.write_table(pyarrow.table(columns), path, **options)


def test_a_part_that_is_a_pipe_is_not_waited_for(folder):
    study = Study.load(folder / "push.toml")
    open_results(folder / "results", study, "x", "parquet").close()
    os.mkfifo(folder / "results" / "part-000000.parquet")
    with pytest.raises(GazeboError, match=r"part-000000.parquet is no file, which results must be"):
        read_results(folder / "results")


def results_at(folder, rows, format="csv", **known):
    """Results, made by hand: `rows` are lines of a table, or dictionaries of a journal."""
    (folder / "results").mkdir(exist_ok=True)
    known = {"digest": "x", "format": format, "runs": 3, "parameters": [], "random": [], "measures": ["m"]} | known
    (folder / "results" / "study.json").write_text(json.dumps(known))
    lines = [row if isinstance(row, str) else json.dumps(row) for row in rows]
    name = {"csv": "results.csv", "parquet": "journal.jsonl"}[format]
    (folder / "results" / name).write_text("".join(f"{line}\n" for line in lines))
    return folder / "results"


HEAD = "run,controller,state,m,python"


@pytest.mark.parametrize("numbers", [(1, 1), (0, 3), (-1,)])
def test_results_of_runs_that_the_study_does_not_have_or_again_are_damaged(tmp_path, numbers):
    found = results_at(tmp_path, [HEAD, *(f"{number},c,ok,1.5,3" for number in numbers)])
    with pytest.raises(ParameterError, match=r"results.csv is damaged: ValueError: (the study has no|it has) run"):
        read_results(found)
    rows = [{"run": number, "controller": "c", "state": "ok", "m": 1.5} for number in numbers]
    found = results_at(tmp_path, rows, "parquet")
    with pytest.raises(ParameterError, match=r"journal.jsonl is damaged: ValueError: (the study has no|it has) run"):
        read_results(found)


def test_a_sweep_is_not_continued_from_results_of_a_run_again(folder):
    study = Study.load(folder / "push.toml")
    results_of(folder).close()
    (folder / "results" / "results.csv").write_text(f"{HEAD}\n1,c,ok,1.5,3\n1,c,ok,1.5,3\n")
    with pytest.raises(ParameterError, match=r"results.csv is damaged: ValueError: it has run 1 again"):
        open_results(folder / "results", study, study.digest(), None)


def test_columns_that_are_not_plotted_take_no_memory(tmp_path):
    """A row of a few letters would have as many values as the table has columns."""
    columns = ",".join(f"c{number}" for number in range(100_000))
    found = results_at(tmp_path, [f"{HEAD},{columns}", *(f"{run},c,ok,1.5,3" for run in range(2))])
    assert all(set(row) == {"run", "controller", "state", "m"} for row in read_results(found)[1])
    rows = [{"run": run, "controller": "c", "state": "ok", "m": 1.5, "n": [[]] * 9} for run in range(2)]
    found = results_at(tmp_path, rows, "parquet")
    assert all(set(row) == {"run", "controller", "state", "m"} for row in read_results(found)[1])


@pytest.mark.parametrize("format", ["csv", "parquet"])
def test_more_results_than_may_be_held_are_refused(tmp_path, monkeypatch, format):
    rows = [f"{run},c,ok,1.5,3" for run in range(9000)]
    rows = (
        [HEAD, *rows]
        if format == "csv"
        else [{"run": n, "controller": "c", "state": "ok", "m": 1} for n in range(9000)]
    )
    found = results_at(tmp_path, rows, format, runs=9000)
    assert len(read_results(found)[1]) == 9000
    monkeypatch.setenv("LIBGZ_DECOMPRESSED", "1")
    with pytest.raises(ParameterError, match="takes more than 1 MiB decompressed"):
        read_results(found)


def test_the_numbers_of_all_parts_share_one_budget(tmp_path, monkeypatch):
    found = results_at(tmp_path, [], "parquet", runs=9000)
    for part in range(3):
        runs = range(3000 * part, 3000 * (part + 1))
        columns = {"run": runs, "state": ["ok"] * 3000, "controller": ["c"] * 3000, "m": [1.5] * 3000}
        write_part(found / f"part-{part:06}.parquet", columns)
    assert len(read_results(found)[1]) == 9000
    monkeypatch.setenv("LIBGZ_DECOMPRESSED", "1")
    with pytest.raises(ParameterError, match=r"part-000002.parquet: it takes more than 1 MiB decompressed"):
        read_results(found)


def test_a_row_of_many_lines_is_not_held(tmp_path, monkeypatch):
    found = results_at(tmp_path, [HEAD, '"a', *['a","b'] * 1000])
    monkeypatch.setattr(results, "LONGEST_LINE", 1000)
    with pytest.raises(ParameterError, match=r"results.csv is damaged: ValueError: a line has more than"):
        read_results(found)


def test_long_metadata_of_a_part_are_not_read(tmp_path):
    found = results_at(tmp_path, [], "parquet")
    (found / "part-000000.parquet").write_bytes(b"PAR1" + (17 << 20).to_bytes(4, "little") + b"PAR1")
    with pytest.raises(ParameterError, match="ValueError: its metadata are too long"):
        read_results(found)


@pytest.mark.parametrize("measured", [[1], {}, None, "x", True, 10**400])
def test_what_is_no_number_is_not_plotted(tmp_path, measured):
    found = results_at(tmp_path, [{"run": 0, "controller": "c", "state": "ok", "m": measured}], "parquet")
    assert [path.name for path in plot_measures(*read_results(found), found)] == ["m.png"]


@pytest.mark.parametrize("name", ["study.json", "results.csv"])
def test_results_that_are_links_are_not_read(tmp_path, name):
    found = results_at(tmp_path, [HEAD, "1,c,ok,1.5,3"])
    (found / name).rename(tmp_path / "own")
    (found / name).symlink_to(tmp_path / "own")
    with pytest.raises(GazeboError, match=f"{name} is a symbolic link, which results cannot be"):
        read_results(found)


def test_plots_are_written_through_no_link_and_into_no_pipe(tmp_path):
    """A folder of results may be somebody else's."""
    found, own = results_at(tmp_path, [HEAD, "1,c,ok,1.5,3"]), tmp_path / "own"
    own.write_text("precious")
    (found / "m.png").symlink_to(own)
    about, rows = read_results(found)
    with pytest.raises(GazeboError, match=r"cannot write .*m.png: Too many levels of symbolic links"):
        list(plot_measures(about, rows, found))
    assert own.read_text() == "precious"
    (found / "m.png").unlink()
    os.mkfifo(found / "m.png")
    with pytest.raises(GazeboError, match=r"cannot write .*m.png: No such device"):
        list(plot_measures(about, rows, found))


def test_letters_without_a_shape_are_not_warned_of(tmp_path, recwarn):
    name = "".join(map(chr, range(0xE000, 0xE020)))
    found = results_at(tmp_path, [f"run,controller,state,{name},python", "1,c,ok,1.5,3"], measures=[name])
    assert len(list(plot_measures(*read_results(found), found))) == 1
    assert not recwarn.list


def test_results_and_studies_of_many_measures_are_refused(folder):
    found = results_at(folder, [], measures=[f"m{number}" for number in range(1001)])
    with pytest.raises(ParameterError, match="it has more than 1000 measures"):
        read_results(found)
    table = tomllib.loads((folder / "push.toml").read_text())
    table["measures"] = {f"m{number}": "robot1/pos[0]" for number in range(1001)}
    with pytest.raises(ParameterError, match="it has 1001 measures; at most 1000 are allowed"):
        Study.of(table, folder)


def test_a_key_of_many_names_is_refused(folder):
    (folder / "deep.toml").write_text(".".join("a" * 3000) + " = 1\n")
    with pytest.raises(ParameterError, match=r"deep.toml: it is nested too deeply"):
        Study.load(folder / "deep.toml")


def test_rows_without_a_column_are_named(folder):
    results_of(folder).close()
    (folder / "results" / "results.csv").write_bytes(b"run,state,python\n1,ok,3\n")
    with pytest.raises(ParameterError, match="results is damaged: run 1 has no "):
        read_results(folder / "results")


def test_names_in_figures_are_no_formulas(tmp_path):
    rows = [{"state": "ok", "controller": "none", "p$^^$": i, "q$^^$": i % 2, "m$^^$": i} for i in range(4)]
    about = {"parameters": ["p$^^$", "q$^^$"], "random": [], "measures": ["m$^^$"]}
    (path,) = plot_measures(about, rows, tmp_path)
    assert path.is_file()
