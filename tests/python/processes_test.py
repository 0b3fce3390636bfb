# SPDX-License-Identifier: Apache-2.0
"""The package in a process with threads and signals of others, and in folders that change."""
import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest
import sarblock
from conftest import SCENES

SCENE = SCENES / "leberl-aircraft.toml"


def script(folder, text, code=0):
    """Runs a script of its own in a folder; what it printed. One that hangs fails after a minute."""
    ended = subprocess.run([sys.executable, "-c", textwrap.dedent(text)], cwd=folder, capture_output=True, text=True,
                           timeout=60, check=False)
    assert ended.returncode == code, ended.stderr
    return ended.stdout


@pytest.fixture
def folder(tmp_path):
    block = sarblock.simulate(SCENE, points={"count": 2000})
    for i in range(2):
        block.write(tmp_path / f"in{i}.h5")
    return tmp_path


def test_threads_read_hdf5_files_while_others_write_them(folder):
    assert script(folder, """
        import threading
        from concurrent.futures import ThreadPoolExecutor
        import sarblock
        block, stop = sarblock.read_block("in0.h5"), threading.Event()
        def write():
            while not stop.is_set():
                block.write("out.h5", force=True)
        writer = threading.Thread(target=write)
        writer.start()
        with ThreadPoolExecutor(2) as pool:
            print(len(list(pool.map(sarblock.read_block, ["in0.h5", "in1.h5"] * 10))))
        stop.set()
        writer.join()
        """) == "20\n"


def test_a_block_is_read_while_numpy_multiplies(folder):
    assert script(folder, """
        import os, threading
        import numpy as np
        import sarblock
        a = np.ones((300, 300))
        def multiply():
            while True:
                a @ a
        threading.Thread(target=multiply, daemon=True).start()
        for i in range(20):
            sarblock.read_block("in0.h5")
        print("read", flush=True)
        os._exit(0)
        """) == "read\n"


# Python ends a daemon that asks for its lock at the interpreter's end by unwinding: through C++ that
# was abort(), in most of the runs.
@pytest.mark.parametrize("progress", ["None", "lambda *news: None"])
def test_daemons_at_work_let_the_interpreter_end(folder, progress):
    for _ in range(3):
        assert script(folder, f"""
            import threading, time
            import sarblock
            block = sarblock.read_block("in0.h5")
            def work(out):
                while True:
                    block.write(out, force=True, progress={progress})
                    sarblock.read_block("in1.h5", progress={progress})
            for out in ("a.h5", "b.h5", "c.h5"):
                threading.Thread(target=work, args=(out,), daemon=True).start()
            time.sleep(0.3)
            print("ends")
            """) == "ends\n"


def test_work_is_done_in_functions_that_end_with_the_interpreter(folder):
    assert script(folder, """
        import atexit
        atexit.register(lambda: print(len(sarblock.read_block("in0.h5").looks)))
        import sarblock
        atexit.register(lambda: print(len(sarblock.read_block("in0.h5").looks)))
        """).split() == ["4088"] * 2


def test_a_process_that_reaps_all_children_reads(folder):
    assert script(folder, """
        import os, signal
        import sarblock
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)
        for number in (0, 1, 2):
            os.close(number)
        sarblock.read_block("in0.h5")
        out = os.open("said", os.O_WRONLY | os.O_CREAT)
        os.write(out, b"read")
        """) == ""
    assert (folder / "said").read_text() == "read"


def test_ctrl_c_ends_the_reading_of_files(folder):
    assert script(folder, """
        import os, signal, threading, time
        import sarblock
        def press():
            time.sleep(1.0)
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=press, daemon=True).start()
        try:
            while True:
                sarblock.read_block("in0.h5")
        except KeyboardInterrupt:
            print("ended")
        """) == "ended\n"


def test_a_job_goes_on_after_a_disk_was_full(tmp_path):
    script(tmp_path, f"""
        import resource
        import sarblock
        block = sarblock.simulate({str(SCENE)!r})
        block.write("whole.h5")
        size = __import__("os").stat("whole.h5").st_size
        for part in range(1, 12):
            resource.setrlimit(resource.RLIMIT_FSIZE, (size * part // 12, resource.RLIM_INFINITY))
            try:
                block.write("cut.h5")
            except sarblock.InputError as error:
                assert "File too large" in str(error), error
            else:
                raise AssertionError(part)
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        block.write("cut.h5")
        assert len(sarblock.read_block("cut.h5").points.ids) == len(block.points.ids)
        """)


def test_what_is_asked_of_a_block_later_is_of_the_block_that_was_read(tmp_path, monkeypatch):
    for name, seed in (("one", 1), ("two", 2)):
        (tmp_path / name).mkdir()
        sarblock.simulate(SCENE, seed=seed).write(tmp_path / name / "block")
    monkeypatch.chdir(tmp_path / "one")
    block = sarblock.read_block("block")
    truth_m, predicted = block.truth_m, sarblock.predict(block).points.sigma_enu_m
    again = sarblock.read_block("block")
    monkeypatch.chdir(tmp_path / "two")
    assert np.array_equal(again.truth_m, truth_m)
    assert np.array_equal(sarblock.predict(again).points.sigma_enu_m, predicted, equal_nan=True)
    again = sarblock.read_block("../one/block")
    sarblock.simulate(SCENE, seed=3).write("../one/block", force=True)
    assert np.array_equal(again.truth_m, truth_m)
    assert os.path.isabs(again._core.path)


def test_a_list_that_the_block_names_is_the_one_that_was_read(tmp_path):
    block = sarblock.simulate(SCENE, points={"count": 20})
    block.write(tmp_path / "block")
    first, second, third = block.points.ids[:3]
    toml = tmp_path / "block" / "block.toml"
    text = toml.read_text()
    assert text.count('pairs = "none"\n') == 1
    toml.write_text(text.replace('pairs = "none"\n', 'pairs = "pairs.csv"\n'))
    pairs = tmp_path / "block" / "pairs.csv"
    pairs.write_text(f"point_a,point_b\n{first},{second}\n")
    read = sarblock.read_block(tmp_path / "block")
    assert len(sarblock.adjust(read).pairs) == 1
    pairs.write_text(f"point_a,point_b\n{first},{third}\n")
    with pytest.raises(sarblock.InputError, match="pairs.csv: has changed since the block was read"):
        sarblock.adjust(read)


def test_arrays_that_are_kept_cannot_be_written_to(local_result, local_block):
    kept = 0
    for part in (local_result.points, local_result.looks, local_result.corrections, local_block.points, local_block.looks):
        for name in dir(type(part)):
            if name.startswith("_") or name == "geodetic":  # of geocentric frames
                continue
            value = getattr(part, name)
            if isinstance(value, np.ndarray) and value is getattr(part, name):
                assert not value.flags.writeable, name
                kept += 1
    assert kept > 20
    local_result.summary["verdict"] = "changed"
    assert local_result.verdict != "changed"
