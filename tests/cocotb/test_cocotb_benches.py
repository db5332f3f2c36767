"""Every test of every cocotb bench, for each word size, as a test of its own."""

import pytest
from cocotb_runs import BENCHES, BenchRuns, names_of_tests

from arcref_gateware.quadrature import SAMPLES_PER_WORD

CASES = [(bench, size, test) for size in SAMPLES_PER_WORD for bench in BENCHES for test in names_of_tests(bench)]


@pytest.fixture(scope="session")
def bench_runs(request):
    """Starts the runs that the chosen tests need."""
    parameters = [item.callspec.params for item in request.session.items if "bench_runs" in item.fixturenames]
    runs = BenchRuns({(chosen["bench"], chosen["samples_per_word"]) for chosen in parameters})
    yield runs
    runs.stop()


@pytest.mark.parametrize(
    ("bench", "samples_per_word", "test"), CASES, ids=[f"{test}-N{size}" for _, size, test in CASES]
)
def test_bench(bench_runs, bench, samples_per_word, test):
    outcome = bench_runs.outcome(bench, samples_per_word)
    if test not in outcome:
        pytest.fail(f"{bench} ended before {test} ran:\n{outcome['log']}", pytrace=False)
    if outcome[test]:
        pytest.fail(outcome[test], pytrace=False)


@pytest.mark.parametrize("bench", BENCHES)
def test_bench_holds_tests_that_all_have_names_of_their_own(bench):
    everywhere = [test for other in BENCHES for test in names_of_tests(other)]
    assert names_of_tests(bench)
    assert all(everywhere.count(test) == 1 for test in names_of_tests(bench))
