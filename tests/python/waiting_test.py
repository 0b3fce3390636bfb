# SPDX-License-Identifier: Apache-2.0
"""What happens while the library works: other threads run, Ctrl-C ends it, progress is reported, and
BLAS has as many threads as before."""
import ctypes
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import sarblock
from conftest import SCENES

#: Takes some seconds: hundreds of adjustments with noise drawn anew.
LONG = {"covariance": "montecarlo", "montecarlo_runs": 100000}


@pytest.fixture(scope="module")
def block():
    return sarblock.simulate(SCENES / "block-12-strips.toml", points={"count": 400})


def stop_after(seconds, number=signal.SIGINT):
    timer = threading.Timer(seconds, os.kill, (os.getpid(), number))
    timer.start()
    return timer


def test_ctrl_c_ends_an_adjustment_within_a_second(block):
    stop_after(0.7)
    begin = time.monotonic()
    with pytest.raises(sarblock.Interrupted, match="interrupted during "):
        sarblock.adjust(block, **LONG)
    assert 0.6 < time.monotonic() - begin < 1.7
    assert issubclass(sarblock.Interrupted, KeyboardInterrupt)


def test_after_ctrl_c_the_next_call_works(block):
    stop_after(0.3)
    with pytest.raises(sarblock.Interrupted):
        sarblock.adjust(block, **LONG)
    assert sarblock.intersect(block).points.solved.any()


def test_what_a_signal_handler_raises_ends_the_work_and_is_raised(block):
    def handle(*_):
        raise TimeoutError("enough")

    before = signal.signal(signal.SIGALRM, handle)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.4)
        begin = time.monotonic()
        with pytest.raises(TimeoutError, match="enough"):
            sarblock.adjust(block, **LONG)
        assert time.monotonic() - begin < 1.5
    finally:
        signal.signal(signal.SIGALRM, before)


def test_another_thread_counts_while_adjust_runs(block):
    counted = []
    done = threading.Event()

    def count():
        number = 0
        while not done.is_set():
            number += 1
            if number % 1000 == 0:
                counted.append(time.monotonic())

    counter = threading.Thread(target=count)
    stop_after(1.2)
    counter.start()
    begin = time.monotonic()
    try:
        with pytest.raises(sarblock.Interrupted):
            sarblock.adjust(block, threads=1, **LONG)
        end = time.monotonic()
    finally:
        done.set()
        counter.join()
    within = [one for one in counted if begin <= one <= end]
    # A lock that was held would leave a gap as long as the call.
    gaps = np.diff([begin, *within, end])
    assert len(within) > 100
    assert gaps.max() < 0.5 * (end - begin)


def test_progress_is_reported_to_a_callable(block):
    reported = []
    sarblock.adjust(block, progress=lambda *news: reported.append(news), covariance="montecarlo", montecarlo_runs=300)
    assert reported
    for stage, done, total, detail in reported:
        assert isinstance(stage, str) and isinstance(detail, str)
        assert total == 0 or 0 <= done <= total


def test_what_the_callable_raises_ends_the_work_and_is_raised(block):
    def refuse(*_):
        raise LookupError("no more")

    begin = time.monotonic()
    with pytest.raises(LookupError, match="no more"):
        sarblock.adjust(block, progress=refuse, **LONG)
    assert time.monotonic() - begin < 2.0


def test_a_bar_of_tqdm_is_drawn(block, capsys):
    pytest.importorskip("tqdm")
    stop_after(0.8)
    with pytest.raises(sarblock.Interrupted):
        sarblock.adjust(block, progress=True, **LONG)
    assert "it/s" in capsys.readouterr().err


def test_two_threads_adjust_at_once_and_give_the_same_bytes(block):
    alone = sarblock.adjust(block).points.position_m
    results = [None, None]

    def work(place):
        results[place] = sarblock.adjust(block)

    threads = [threading.Thread(target=work, args=(place,)) for place in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results:
        np.testing.assert_array_equal(result.points.position_m, alone)


def blas_libraries():
    """The BLAS libraries of this process whose number of threads can be asked for."""
    with open("/proc/self/maps", encoding="utf-8") as maps:
        paths = {line.split()[-1] for line in maps if "blas" in line and ".so" in line}
    libraries = [ctypes.CDLL(path) for path in sorted(paths)]
    return [one for one in libraries if hasattr(one, "openblas_get_num_threads")]


@pytest.mark.parametrize("threads", [1, 2])
def test_blas_has_as_many_threads_as_before(block, threads):
    np.linalg.inv(np.eye(3))
    libraries = blas_libraries()
    if not libraries:
        pytest.skip("this BLAS does not tell its number of threads")
    for one in libraries:
        one.openblas_set_num_threads(threads)
    seen = []
    sarblock.adjust(block, progress=lambda *_: seen.append([one.openblas_get_num_threads() for one in libraries]))
    assert [one.openblas_get_num_threads() for one in libraries] == [threads] * len(libraries)
    with pytest.raises(sarblock.InputError):
        sarblock.adjust(block, robust="hubert")
    assert [one.openblas_get_num_threads() for one in libraries] == [threads] * len(libraries)


def test_importing_costs_no_optional_package():
    code = "import sys, sarblock; print([n for n in ('pandas', 'xarray', 'matplotlib', 'tqdm') if n in sys.modules])"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"
