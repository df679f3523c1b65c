"""Readers of compressed files hold no more than their budget, whatever sizes a file states."""

import bz2
import zlib

import lz4.frame
import pytest
import zstandard

from libgz.base.budget import DECOMPRESSED, VARIABLE, Budget, BudgetError
from libgz.base.errors import ParameterError

DATA = bytes(range(256)) * 40
SIZE = len(DATA)
TOOLS = {
    "zlib": (zlib.compress, lambda budget, data, size: budget.zlib(data)),
    "bz2": (bz2.compress, lambda budget, data, size: budget.bz2(data)),
    "zstd": (zstandard.compress, Budget.zstd),
    "lz4": (lz4.frame.compress, Budget.lz4),
}


@pytest.fixture(params=TOOLS)
def tool(request):
    return TOOLS[request.param]


def test_what_fits_is_decompressed_and_counted(tool):
    compress, decompress = tool
    budget = Budget(SIZE)
    assert decompress(budget, compress(DATA), SIZE) == DATA
    assert (budget.used, budget.left) == (SIZE, 0)
    with pytest.raises(BudgetError, match=rf"takes more than 0 MiB decompressed; the environment variable {VARIABLE}"):
        budget.take(1)


@pytest.mark.parametrize("size", [SIZE - 1, SIZE - 2])
@pytest.mark.parametrize("name", ["zstd", "lz4"])
def test_sizes_may_be_odd_and_even(name, size):
    compress, decompress = TOOLS[name]
    assert decompress(Budget(), compress(DATA[:size]), size) == DATA[:size]


def test_what_does_not_fit_is_refused(tool):
    compress, decompress = tool
    with pytest.raises(BudgetError):
        decompress(Budget(SIZE - 1), compress(DATA), SIZE)


def test_damaged_and_truncated_data_are_errors(tool):
    compress, decompress = tool
    for data in (b"abc", compress(DATA)[:-9]):
        with pytest.raises(ValueError):
            decompress(Budget(), data, SIZE)


@pytest.mark.parametrize("name", ["zstd", "lz4"])
@pytest.mark.parametrize("stated", [SIZE - 1, SIZE + 1, 0])
def test_a_wrong_size_is_an_error(name, stated):
    compress, decompress = TOOLS[name]
    with pytest.raises(ValueError, match=f"has not the {stated} bytes that it states"):
        decompress(Budget(), compress(DATA), stated)


def test_what_parsers_make_of_small_elements_counts():
    with pytest.raises(BudgetError):
        Budget(1 << 20).take_xml("<a/>" * 10_000)
    with pytest.raises(BudgetError):
        Budget(1 << 20).take_json(b"[],[]," * 10_000)
    budget = Budget(1 << 20)
    budget.take_xml("<a>" + "1" * 100_000 + "</a>")
    budget.take_json(b'{"a": "' + b"1" * 100_000 + b'"}')
    assert budget.used < 1000


def test_the_environment_sets_the_limit(monkeypatch):
    assert Budget().limit == DECOMPRESSED == 256 << 20
    monkeypatch.setenv(VARIABLE, "1000")
    assert Budget().limit == 1000 << 20
    for text in ("-1", "0", "many", "1e3"):
        monkeypatch.setenv(VARIABLE, text)
        with pytest.raises(ParameterError, match=f"{VARIABLE} is '{text}'; a number of MiB from 1 on is allowed"):
            Budget()
