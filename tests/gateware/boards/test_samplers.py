"""The order of the samples in a word, proved with models of Lattice's primitives; and what the self-check would see."""

from dataclasses import replace

import pytest
from edge_bench import EdgeBench

from arcref_gateware.boards.board import SAMPLED_SIGNALS
from arcref_gateware.boards.board_file import load_board

FOUR = "ulx3s"
TWO_ICE40 = "icebreaker"
TWO_ECP5 = "ecp5, two samples"


def _board(name: str):
    if name == TWO_ECP5:
        return replace(load_board("ulx3s"), samples_per_word=2, word_clock_hz=150e6)
    return load_board(name)


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Benches by name, each compiled when it is first asked for."""
    made = {}

    def get(name: str) -> EdgeBench:
        if name not in made:
            made[name] = EdgeBench(_board(name), tmp_path_factory.mktemp("edge"))
        return made[name]

    return get


@pytest.mark.parametrize("name", [FOUR, TWO_ICE40, TWO_ECP5])
def test_words_are_the_samples_of_the_pads_in_their_order_and_all_lines_alike(bench, name):
    run = bench(name).run()
    assert not run.timed_out
    assert (run.passed, run.failed) == (True, False)
    offsets = {line: run.offset(line) for line in SAMPLED_SIGNALS}
    assert None not in offsets.values(), offsets
    assert len(set(offsets.values())) == 1, offsets


ORDERS_OF_FOUR = [
    "0123", "3201", "2310", "3120", "1320", "2130", "1230", "1032", "2103", "0321", "2013", "1203", "0312",
    "3012", "3102", "1302", "0132", "0231", "2031", "2301", "3021", "0213", "1023",
]  # fmt: skip


@pytest.mark.parametrize("order", ORDERS_OF_FOUR)
def test_any_other_order_of_four_samples_fails_the_self_check(bench, order):
    run = bench(FOUR).run(f"+order={int(order)}")
    assert (run.passed, run.failed) == (False, True)


@pytest.mark.parametrize("name", [TWO_ICE40, TWO_ECP5])
def test_two_samples_exchanged_fail_the_self_check(bench, name):
    run = bench(name).run("+order=1")
    assert (run.passed, run.failed) == (False, True)


def test_a_late_reset_slips_one_line_when_the_edge_clock_runs(bench):
    run = bench(FOUR).run("+late_reset=b_gearing", "+never_stop")
    assert abs(run.offset("b") - run.offset("a")) == 2
    assert run.offset("z") == run.offset("a")


def test_a_late_reset_slips_nothing_when_the_edge_clock_stands_still(bench):
    run = bench(FOUR).run("+late_reset=b_gearing")
    assert run.passed
    assert len({run.offset(line) for line in SAMPLED_SIGNALS}) == 1
