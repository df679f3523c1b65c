"""libgz stats: its lines are those of Gazebo's own command."""

import pytest

from libgz.apps.stats import _Printer
from libgz.classic import msgs


@pytest.mark.parametrize(
    ("plot", "line"),
    [
        (True, "0.99,         3.758000,         3.797000, F"),  # as the real `gz stats -p` writes it
        (False, "Factor[0.99] SimTime[3.76] RealTime[3.80] Paused[F]"),
    ],
)
def test_lines_are_those_of_gazebo(plot, line, capsys):
    printer = _Printer(plot, as_json=False)
    for sim, real in ((2_768_000_000, 2_797_000_000), (3_758_000_000, 3_797_000_000)):
        message = msgs.WorldStatistics()
        for time, total in ((message.sim_time, sim), (message.real_time, real)):
            time.sec, time.nsec = divmod(total, 1_000_000_000)
        message.paused = False
        printer.on_statistics(message)
    assert capsys.readouterr().out == f"{line}\n"
