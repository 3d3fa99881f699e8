"""Threads, deadlines, interrupts, progress, panics: what surrounds a run."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import need

import carreau as cr
from carreau import _core


@pytest.fixture(scope="module")
def large() -> cr.Mesh:
    """A mesh that keeps a verb busy for a while: how long is up to the machine, no test counts on it."""
    return cr.sample("bracket", 250)


def test_results_do_not_depend_on_threads(bracket):
    for verb, options in ((cr.segment, {}), (cr.simplify, {}), (cr.quad, {"quads": 800})):
        one, two = (verb(bracket, threads=n, quiet=True, **options).mesh for n in (1, 2))
        assert np.array_equal(one.points, two.points) and np.array_equal(one.face_corners, two.face_corners)


def test_other_threads_run_meanwhile(large):
    """Python goes on while a verb works: a counter in another thread advances at its usual pace."""
    ticks, stop = [], threading.Event()

    def count() -> None:
        while not stop.wait(0.005):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=count)
    thread.start()
    start = time.monotonic()
    with contextlib.suppress(cr.DeadlineError):
        cr.quad(large, deadline=1.5, threads=1)
    end = time.monotonic()
    stop.set()
    thread.join()
    within = [t for t in ticks if start <= t <= end]
    # With the lock held there would be none at all.
    assert len(within) > 10


def test_verbs_run_side_by_side(bracket):
    results = [None] * 3

    def work(k: int) -> None:
        results[k] = cr.segment(bracket, threads=1).labels

    threads = [threading.Thread(target=work, args=(k,)) for k in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(labels, results[0]) for labels in results)


def test_deadlines_are_timeouts(tmp_path, large):
    out = tmp_path / "never.ply"
    with pytest.raises(TimeoutError) as caught:
        cr.quad(large, deadline=0.2, output=out)
    assert isinstance(caught.value, cr.DeadlineError) and caught.value.exit_code == 124
    assert not out.exists()


def test_ctrl_c_stops_a_run_and_leaves_python_alive():
    code = """
        import carreau as cr, sys, threading
        mesh = cr.sample("bracket", 250)
        print("ready", flush=True)
        try:
            cr.quad(mesh)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        # Python's own handling is as it was, and the next run is not cancelled.
        assert cr.segment(cr.sample("bracket", 20)).regions
        print("alive", flush=True)
    """
    child = subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    said, _ = child.communicate(timeout=120)
    assert said == "interrupted\nalive\n" and child.returncode == 0


def test_progress_is_told_and_can_stop_a_run(large):
    seen: list[tuple[str, float]] = []
    with contextlib.suppress(cr.DeadlineError):
        cr.quad(large, deadline=1.0, progress=lambda stage, share: seen.append((stage, share)))
    assert {stage for stage, _ in seen} - {""} and all(0 <= share <= 1 for _, share in seen)

    class Enough(Exception):
        pass

    def stop(stage: str, share: float) -> None:
        raise Enough

    with pytest.raises(Enough):
        cr.quad(large, progress=stop)


def test_a_bar_is_shown_when_asked_for(large, capsys):
    need("tqdm")
    with contextlib.suppress(cr.DeadlineError):
        cr.quad(large, deadline=2.5, progress=True)
    assert "%" in capsys.readouterr().err


def test_panics_are_runtime_errors():
    panic = getattr(_core, "_panic", None)
    if panic is None:
        pytest.skip("releases have no way to panic on purpose: build with the profile dev")
    with pytest.raises(RuntimeError, match="on purpose") as caught:
        panic()
    assert isinstance(caught.value, cr.InternalError) and caught.value.exit_code == 70


def test_the_command_line_is_there(tmp_path):
    run = [sys.executable, "-m", "carreau"]
    said = subprocess.run([*run, "--version"], capture_output=True, text=True, check=True).stdout
    assert cr.__version__ in said
    assert subprocess.run([*run, "quad", "no.stl", "-o", "x.obj"], capture_output=True).returncode == 5
    assert subprocess.run([*run, "nonsense"], capture_output=True).returncode == 2
    out = tmp_path / "torus.ply"
    subprocess.run([*run, "sample", "torus", "--resolution", "20", "-o", str(out)], check=True, capture_output=True)
    assert cr.read(out).topology()["genus"] == 1


def test_ctrl_c_stops_the_command_line(tmp_path):
    model = tmp_path / "part.ply"
    cr.sample("bracket", 250).write(model)
    run = [sys.executable, "-m", "carreau", "quad", str(model), "-o", str(tmp_path / "out.obj")]
    child = subprocess.Popen(run, stderr=subprocess.DEVNULL)
    time.sleep(1.5)
    child.send_signal(signal.SIGINT)
    assert child.wait(timeout=60) == 130
    assert os.listdir(tmp_path) == ["part.ply"]
