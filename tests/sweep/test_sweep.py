"""Sweeps as users run them: results, controllers, limits, retries, interruptions, clusters, plots."""

import contextlib
import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from commands import run_libgz

from libgz.base.errors import GazeboError, ParameterError
from libgz.sweep import driver
from libgz.sweep.report import plot_measures
from libgz.sweep.results import read_results

LIBGZ = [sys.executable, "-m", "libgz", "sweep"]
TIMED = {"wall_time", "attempts", "host"}


def sweep(folder, *options, study="push.toml"):
    command = [*LIBGZ, study, *options]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)


def change(folder, *pairs):
    path = folder / "push.toml"
    text = path.read_text()
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)


def rows_of(folder, results="push.results"):
    return read_results(folder / results)[1]


def measured(rows):
    return [{name: value for name, value in row.items() if name not in TIMED} for row in rows]


@pytest.mark.trial
def test_a_sweep_continues_where_its_file_was_truncated(folder):
    change(folder, ("duration = 1.0", "duration = 0.2"), ('"controller/speed" = [0.2, 0.4]\n', ""))
    done = sweep(folder, "-j", "1")
    assert (done.returncode, done.stdout) == (0, "4 runs in push.results\n"), done.stderr
    rows = rows_of(folder)
    assert {row["state"] for row in rows} == {"ok"}
    assert {row["calls"] for row in rows} == {2}
    file = folder / "push.results" / "results.csv"
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join(lines[:3]) + lines[3][:9])
    assert sweep(folder, "-j", "2").returncode == 0
    again = rows_of(folder)
    assert again[:2] == rows[:2]
    assert measured(again) == measured(rows)


@pytest.mark.trial
def test_a_grid_into_csv_and_plots(folder):
    done = sweep(folder, "-j", "2")
    assert (done.returncode, done.stdout) == (0, "8 runs in push.results\n"), done.stderr
    with (folder / "push.results" / "results.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [*table[0]][:9] == [
        *("run", "crate/mass", "controller/speed", "crate/xyz[0]", "controller", "seed", "state", "distance", "highest")
    ]
    rows = rows_of(folder)
    assert [row["run"] for row in rows] == list(range(8))
    assert {row["state"] for row in rows} == {"ok"}
    assert {row["calls"] for row in rows} == {10}
    assert len({(row["libgz"], row["python"]) for row in table}) == 1
    distance = {row["controller/speed"]: row["distance"] for row in rows}
    assert 0.1 < distance[0.2] < 0.21
    assert 1.5 < distance[0.4] / distance[0.2] < 2.3
    again = sweep(folder)
    assert again.stdout == "8 runs in push.results\n"
    assert rows_of(folder) == rows  # nothing was run again
    report = sweep(folder, "push.results", study="report")
    names = [f"push.results/{name}.png" for name in ("distance", "highest", "calls")]
    assert report.stdout.split() == names, report.stderr
    assert all((folder / name).read_bytes().startswith(b"\x89PNG") for name in names)


def listening(pid):
    """Ports of TCP, and names of sockets, at which a process and its children listen."""
    processes, found = [pid], set()
    for process in processes:
        for task in Path(f"/proc/{process}/task").glob("*/children"):
            processes += map(int, task.read_text().split())
        with contextlib.suppress(OSError):
            links = {str(link.readlink()) for link in Path(f"/proc/{process}/fd").iterdir()}
            for table in ("tcp", "tcp6", "udp", "udp6", "unix"):
                for line in Path(f"/proc/{process}/net/{table}").read_text().splitlines()[1:]:
                    words = line.split()
                    inode = words[6] if table == "unix" else words[9]
                    if f"socket:[{inode}]" in links:
                        found.add(line)
    return found


@pytest.mark.parametrize("option", ["-j", "--local"])
def test_a_sweep_of_this_machine_opens_no_socket_and_ends_by_sigterm_in_one_line(folder, option):
    change(folder, ("drive.py:Drive", "drive.py:hang"), ('"controller/speed" = [0.2, 0.4]\n', ""))
    change(folder, ('calls = "drive.py:calls"', ""))
    command = [*LIBGZ, "push.toml", option, "2"]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        while not (folder / "push.results" / "results.csv").exists():
            assert process.poll() is None
            time.sleep(0.05)
        time.sleep(0.5)
        assert listening(process.pid) == set()
    finally:
        process.send_signal(signal.SIGTERM)
        out, errors = process.communicate(timeout=30)
    assert (process.returncode, out) == (143, "")
    assert errors == "libgz: 0 of 4 runs are recorded; the same command continues\n"
    report = subprocess.run([*LIBGZ, "report", "push.results"], cwd=folder, capture_output=True, text=True)
    assert "0 of 4 runs are recorded" in report.stderr


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "tls://127.0.0.1:1"])
def test_a_scheduler_without_tls_is_named_as_trusted(address, monkeypatch, caplog):
    class Distributed:
        def Client(self, *_arguments, **_options):
            raise OSError("refused")

        def Security(self):
            return self

        def get_connection_args(self, _role):
            return {"ssl_context": object()}

    monkeypatch.setattr(driver, "_distributed", Distributed)
    with pytest.raises(GazeboError, match=f"cannot reach the scheduler '{address}': refused"), driver.cluster(address):
        pass
    told = f"{address} has no TLS: whoever can connect to it can run code" in caplog.text
    assert told is address.startswith("tcp")


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("tls://127.0.0.1:1", "tls://127.0.0.1:1 needs certificates; dask's configuration names none"),
        ("other://x", "'other://x' begins with none of tls://, tcp://, wss://, ws://"),
    ],
)
def test_a_scheduler_that_no_client_can_be_made_for_is_refused(address, said):
    """By a sentence: half a client of dask waits for 40 s at its end, and its traceback says less."""
    with pytest.raises(GazeboError, match=re.escape(said)), driver.cluster(address):
        pass


def test_other_studies_do_not_mix(folder):
    assert sweep(folder, "--dry-run").stdout == "8 runs of 1 s\n"
    change(folder, ("duration = 1.0", "duration = 0.1"))
    sweep(folder)
    change(folder, ("duration = 0.1", "duration = 0.2"))
    done = sweep(folder)
    assert done.returncode == 1
    assert "has the results of another study" in done.stderr
    change(folder, ("duration = 0.2", "duration = 0.1"))
    assert "has results as csv, not as parquet" in sweep(folder, "--format", "parquet").stderr


FAILURES = [
    ("fail", "failed", "ValueError: out of order"),
    ("hang", "timeout", "it took more than 1 s"),
    ("crash", "crashed", "its process ended with signal 11"),
    ("eat", "memory", "it took more than 150 MB"),
]


@pytest.mark.trial
def test_failed_runs_are_retried_and_recorded(folder):
    names = ", ".join(f'{name} = "drive.py:{name}"' for name, *_ in FAILURES)
    change(
        folder,
        ('controller = "drive.py:Drive"', f"controllers = {{ {names} }}"),
        ('"controller/speed" = [0.2, 0.4]\n', ""),
        ('"crate/mass" = [1.0, 8.0]\n', ""),
        ('calls = "drive.py:calls"', "[limits]\ntime = 1\nmemory = 150"),
        ("seeds = 2", "retries = 1"),
    )
    done = sweep(folder, "-j", "2")
    assert done.returncode == 1
    assert "4 of them failed" in done.stdout
    rows = {row["controller"]: row for row in rows_of(folder)}
    for name, state, message in FAILURES:
        assert (rows[name]["state"], rows[name]["message"], rows[name]["attempts"]) == (state, message, 2)
        assert rows[name]["distance"] != rows[name]["distance"]  # NaN


@pytest.mark.trial
def test_a_retry_can_succeed_and_a_controller_can_end_its_run(folder):
    change(
        folder,
        ('controller = "drive.py:Drive"', 'controllers = { once = "drive.py:fail_first", stop = "drive.py:stop" }'),
        ('"controller/speed" = [0.2, 0.4]\n', ""),
        ('"crate/mass" = [1.0, 8.0]\n', ""),
        ('calls = "drive.py:calls"', ""),
        ("seeds = 2", ""),
    )
    assert sweep(folder, "-j", "1").returncode == 0
    once, stop = rows_of(folder)
    assert (once["state"], once["attempts"]) == ("ok", 2)
    assert stop["sim_time"] == pytest.approx(0.4)


@pytest.mark.trial
def test_client_programs_drive_too(folder):
    (folder / "client.py").write_text(
        "import sys, libgz\n"
        "with libgz.Client(int(sys.argv[1]), timeout=10) as client:\n"
        "    client.position('robot1').command(vx=0.4)\n"
        "    while client.wait(timeout=1.0) and client.sim().sim_time < 0.8: pass\n"
    )
    (folder / "bad.py").write_text("raise SystemExit(3)\n")
    words = f'"{sys.executable}", "{folder}/%s.py", "{{server_id}}"'
    change(
        folder,
        (
            'controller = "drive.py:Drive"',
            f"[controllers]\ngood = {{ command = [{words % 'client'}] }}\n"
            f"bad = {{ command = [{words % 'bad'}], speed = 0.5 }}",
        ),
        ("seeds = 2\n", "retries = 0\n"),
        ("duration = 1.0", "duration = 4.0"),
        ('"controller/speed" = [0.2, 0.4]\n', ""),
        ('"crate/mass" = [1.0, 8.0]\n', ""),
        ('calls = "drive.py:calls"', ""),
    )
    done = sweep(folder, "-j", "1")
    rows = {row["controller"]: row for row in rows_of(folder)}
    assert (rows["good"]["state"], rows["good"]["message"]) == ("ok", ""), done.stderr
    assert rows["good"]["distance"] > 0.01
    assert rows["good"]["sim_time"] < 3.0  # it ends with its program
    assert "ended with exit code 3" in rows["bad"]["message"]


@pytest.mark.trial
def test_runs_from_one_state_are_as_runs_from_the_start(folder):
    sweep(folder, "--results", "whole")
    change(folder, ("duration = 1.0", "duration = 1.4\nstart = 0.4"))
    sweep(folder, "--results", "shared", "-j", "1")
    shared = rows_of(folder, "shared")
    assert {row["state"] for row in shared} == {"ok"}
    assert {row["calls"] for row in shared} == {10}
    change(folder, ("[0.2, 0.4]", "[0.4, 0.2]"))  # now the other one of each pair begins from the kept state
    sweep(folder, "--results", "other", "-j", "1")
    key = ("crate/mass", "controller/speed", "seed")
    tables = [
        {tuple(row[name] for name in key): row["distance"] for row in rows}
        for rows in (shared, rows_of(folder, "other"))
    ]
    assert tables[0] == tables[1]


def kill_when(process, path, lines, number=signal.SIGKILL):
    end = time.monotonic() + 120
    while time.monotonic() < end and process.poll() is None:
        if path.exists() and path.read_bytes().count(b"\n") >= lines:
            break
        time.sleep(0.02)
    os.kill(process.pid, number)
    process.wait(60)


@pytest.mark.trial
@pytest.mark.parametrize("format", ["csv", "parquet"])
def test_a_killed_sweep_goes_on_and_loses_nothing(folder, format):
    change(
        folder,
        ('controller = "drive.py:Drive"', 'controller = "drive.py:slow"'),
        ('"controller/speed" = [0.2, 0.4]\n', ""),
        ('calls = "drive.py:calls"', ""),
        ("seeds = 2", "seeds = 6"),
    )
    whole = sweep(folder, "--results", "whole", "-j", "2")
    assert whole.returncode == 0, whole.stderr
    options = ["--results", "cut", "--format", format, "-j", "2"]
    file = folder / "cut" / ("results.csv" if format == "csv" else "journal.jsonl")
    for lines in (3, 6):
        process = subprocess.Popen([*LIBGZ, "push.toml", *options], cwd=folder, stderr=subprocess.DEVNULL)
        kill_when(process, file, lines)
    before = {row["run"]: row for row in rows_of(folder, "cut")}
    assert 5 <= len(before) < 12
    with file.open("ab") as cut:
        cut.write(b'{"run": 11, "cra' if format == "parquet" else b"11,5.0,0.6")  # a line that was being written
    assert sweep(folder, *options).returncode == 0
    rows = rows_of(folder, "cut")
    assert measured(rows) == measured(rows_of(folder, "whole"))
    assert all(row == before[row["run"]] for row in rows if row["run"] in before)


@pytest.mark.parametrize("name", ["study.json", ".lock", "results.csv", "journal.jsonl", "part-000000.parquet"])
@pytest.mark.parametrize("there", [True, False])
def test_results_are_written_to_no_link(folder, name, there):
    """A folder of somebody else, or in one that all may write, would lead to a user's files."""
    own = folder / "own"
    if there:
        own.write_text("precious")
    (folder / "push.results").mkdir()
    (folder / "push.results" / name).symlink_to(own)
    done = run_libgz("sweep", "push.toml", cwd=folder)
    assert done.returncode == 1
    assert f"{name} is a symbolic link, which results cannot be" in done.stderr
    assert own.exists() == there
    assert not there or own.read_text() == "precious"


@pytest.mark.parametrize("name", [".lock", "results.csv", "journal.jsonl"])
def test_results_are_written_to_no_pipe(folder, name):
    """Whoever opens one waits for its reader."""
    (folder / "push.results").mkdir()
    os.mkfifo(folder / "push.results" / name)
    done = run_libgz("sweep", "push.toml", cwd=folder, timeout=60)
    assert done.returncode == 1
    assert f"{name} is no file, which results must be" in done.stderr


ABOUT = {"digest": "x", "format": "csv", "runs": 200, "parameters": ["p"], "random": [], "measures": ["m"]}


@pytest.mark.parametrize(
    ("p", "m"),
    [
        (lambda i: i, lambda i: "9" * 4000),
        (lambda i: "9" * (4000 + i), lambda i: i),
        (lambda i: i, lambda i: (-1) ** i * 1.7e308),
        (lambda i: "same", lambda i: 1e90 if i == 7 else 1e-9 * i),
        (lambda i: "x" * 10_000 + str(i), lambda i: i),
        (lambda i: f"text{i}", lambda i: i),
        (lambda i: "nan", lambda i: "inf"),
    ],
)
def test_odd_results_are_plotted_without_what_cannot_be(tmp_path, p, m):
    (tmp_path / "study.json").write_text(json.dumps(ABOUT))
    rows = [f"{i},{p(i)},c,1,ok,{m(i)},0,0,1,,h,l,3.11" for i in range(ABOUT["runs"])]
    head = "run,p,controller,seed,state,m,sim_time,wall_time,attempts,message,host,libgz,python"
    (tmp_path / "results.csv").write_text("\n".join([head, *rows, ""]))
    about, found = read_results(tmp_path)
    assert len(found) == ABOUT["runs"]
    assert [path.name for path in plot_measures(about, found, tmp_path)] == ["m.png"]


def test_each_measure_has_a_figure_of_its_own(tmp_path):
    """Also those whose names differ in letters only that no file name has, and one that would be too long for it."""
    measures = ["a b", "a-b", "A b", "a/b", "x" * 300]
    row = {"p": 1.0, "controller": "c", "state": "ok"} | dict.fromkeys(measures, 1.0)
    about = {"parameters": ["p"], "random": [], "measures": measures}
    names = [path.name for path in plot_measures(about, [row], tmp_path)]
    assert names == ["a-b.png", "a-b-2.png", "A-b-3.png", "a-b-4.png", "x" * 200 + ".png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


@pytest.mark.parametrize("runs", [-1, 10**9 + 1, 10**400])
def test_results_of_more_runs_than_a_study_has_are_damaged(tmp_path, runs):
    (tmp_path / "study.json").write_text(json.dumps(ABOUT | {"runs": runs}))
    with pytest.raises(ParameterError, match=r"study.json is damaged: ValueError: it has -?\d+ runs"):
        read_results(tmp_path)


@pytest.mark.trial
def test_two_commands_do_not_write_the_same_results(folder):
    change(
        folder,
        ("drive.py:Drive", "drive.py:hang"),
        ('"controller/speed" = [0.2, 0.4]\n', ""),
        ('calls = "drive.py:calls"', ""),
    )
    process = subprocess.Popen([*LIBGZ, "push.toml", "-j", "1"], cwd=folder, stderr=subprocess.PIPE, text=True)
    while not (folder / "push.results" / "results.csv").exists():
        assert process.poll() is None
        time.sleep(0.05)
    assert "another process writes these results" in sweep(folder).stderr
    process.send_signal(signal.SIGINT)
    assert "0 of 4 runs are recorded; the same command continues" in process.communicate(timeout=30)[1]
    assert process.returncode == 130


@pytest.mark.trial
def test_dask_workers_give_what_one_process_gives_and_may_be_killed(folder):
    pytest.importorskip("distributed")
    from distributed import LocalCluster

    change(
        folder,
        ('controller = "drive.py:Drive"', 'controller = "drive.py:slow"'),
        ('"controller/speed" = [0.2, 0.4]\n', ""),
        ('calls = "drive.py:calls"', ""),
        ("seeds = 2", "seeds = 6"),
    )
    assert sweep(folder, "--results", "one", "-j", "1").returncode == 0
    with LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster:
        options = ["--scheduler", cluster.scheduler_address, "--results", "two", "--format", "parquet"]
        process = subprocess.Popen([*LIBGZ, "push.toml", *options], cwd=folder, stderr=subprocess.PIPE, text=True)
        journal = folder / "two" / "journal.jsonl"
        while process.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") >= 3):
            time.sleep(0.02)
        os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
        errors = process.communicate(timeout=120)[1]
        assert process.returncode == 0, errors
    assert measured(rows_of(folder, "two")) == measured(rows_of(folder, "one"))
    assert json.loads((folder / "two" / "study.json").read_text())["runs"] == 12


@pytest.mark.trial
def test_a_lost_scheduler_ends_the_command_and_nothing_is_lost(folder):
    pytest.importorskip("distributed")
    change(
        folder,
        ('controller = "drive.py:Drive"', 'controller = "drive.py:slow"'),
        ('"controller/speed" = [0.2, 0.4]\n', ""),
        ('calls = "drive.py:calls"', ""),
        ("seeds = 2", "seeds = 20"),
    )
    code = (
        "from distributed import LocalCluster\n"
        "if __name__ == '__main__':\n"
        "    with LocalCluster(1, threads_per_worker=1, dashboard_address=None) as c:\n"
        "        print(c.scheduler_address, flush=True)\n        input()\n"
    )
    (folder / "cluster.py").write_text(code)
    cluster = subprocess.Popen(
        [sys.executable, folder / "cluster.py"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    address = cluster.stdout.readline().strip()
    process = subprocess.Popen(
        [*LIBGZ, "push.toml", "--scheduler", address], cwd=folder, stderr=subprocess.PIPE, text=True
    )
    kill_when(cluster, folder / "push.results" / "results.csv", 3)
    errors = process.communicate(timeout=120)[1]
    cluster.stdin.close()
    cluster.stdout.close()
    assert process.returncode == 1
    assert "the connection to the scheduler was lost" in errors
    recorded = len(rows_of(folder))
    assert 2 <= recorded < 40
    assert f"{recorded} of 40 runs are recorded" in errors
    assert sweep(folder, "-j", "2").returncode == 0
    assert [row["run"] for row in rows_of(folder)] == list(range(40))
