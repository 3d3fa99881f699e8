"""Batches: rows, restarts, and jobs that crash, hang or eat memory."""

from __future__ import annotations

import json
import os
import sys
import textwrap
import time
from pathlib import Path

import pytest
from conftest import need

import carreau as cr
from carreau import batch

#: A command line that misbehaves on files of certain names, and is carreau's on all others.
EVIL = f"""#!{sys.executable} -I
import os, runpy, sys, time
name = os.path.basename(sys.argv[-1])
if name.startswith("abort"):
    os.abort()
if name.startswith("hang"):
    time.sleep(600)
if name.startswith("eat"):
    hoard = []
    while True:
        hoard.append(bytearray(20_000_000))
        time.sleep(0.01)
sys.argv[0] = {str(Path(batch.__file__).with_name("_launch.py"))!r}
runpy.run_path(sys.argv[0], run_name="__main__")
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> list[Path]:
    """A hundred models, and three whose names say what becomes of their jobs."""
    folder = tmp_path_factory.mktemp("models")
    torus = cr.sample("torus", 10)
    made = []
    for k in range(100):
        made.append(folder / f"torus_{k:03}.ply")
        cr.Mesh(torus.points * (1 + k), torus.faces).write(made[-1])
    for k, name in ((20, "abort"), (50, "hang"), (80, "eat")):
        made.insert(k, folder / f"{name}.ply")
        torus.write(made[k])
    return made


@pytest.fixture(scope="module")
def command(tmp_path_factory) -> list[str]:
    script = tmp_path_factory.mktemp("bin") / "evil"
    script.write_text(textwrap.dedent(EVIL))
    script.chmod(0o755)
    return [str(script)]


def check_that_only_three_are_lost(summary: batch.Summary, rows: list[dict], files: list[Path]) -> None:
    assert (summary.jobs, summary.skipped, summary.done, summary.failed) == (103, 0, 100, 3)
    assert [Path(row["file"]) for row in rows] == files
    by_name = {Path(row["file"]).stem: row for row in rows}
    assert by_name["abort"]["exit_code"] == 134 and "SIGABRT" in by_name["abort"]["message"]
    assert by_name["hang"]["exit_code"] == 124 and "deadline" in by_name["hang"]["message"]
    assert by_name["eat"]["exit_code"] == 137 and "memory" in by_name["eat"]["message"]
    for name, row in by_name.items():
        if name.startswith("torus"):
            assert row["exit_code"] == 0 and row["input.faces"] > 0 and row["topology.euler"] == 0
            assert 0 < row["seconds"] < 60 and row["peak_memory_mb"] > 1


@pytest.mark.parametrize("engine", ["local", "dask", "ray"])
def test_bad_jobs_lose_their_own_rows_only(tmp_path, files, command, engine):
    if engine != "local":
        need("distributed" if engine == "dask" else engine)
    out = tmp_path / "rows.jsonl"
    given = {"verb": "info", "deadline": 10.0, "memory": 400.0, "options": {"threads": 1}, "command": command}
    summary = batch.run(files, out, engine=engine, workers=2, **given)
    check_that_only_three_are_lost(summary, list(batch.read_rows(out)), files)
    assert os.listdir(tmp_path) == ["rows.jsonl"]
    # The same call finds everything done.
    again = batch.run(files, out, engine=engine, workers=2, **given)
    assert (again.jobs, again.skipped, again.done, again.failed) == (103, 103, 0, 0)


def test_dask_loses_a_job_that_kills_its_worker(tmp_path, files):
    """Not even a job that ends the process which watches it takes others along."""
    need("distributed")
    killer = tmp_path / "killer"
    killer.write_text(EVIL.replace("os.abort()", "os.kill(os.getppid(), 9)"))
    killer.chmod(0o755)
    some = [*files[:8], files[20], *files[30:38]]
    out = tmp_path / "rows.jsonl"
    given = {"verb": "info", "options": {"threads": 1}, "command": [str(killer)]}
    summary = batch.run(some, out, engine="dask", workers=2, **given)
    assert (summary.done, summary.failed) == (16, 1)
    row = next(row for row in batch.read_rows(out) if row["exit_code"] != 0)
    assert Path(row["file"]).stem == "abort" and "worker died" in row["message"]


def test_rows_are_those_of_the_record(tmp_path, bracket):
    source, out = tmp_path / "part.ply", tmp_path / "quads.obj"
    bracket.write(source)
    job = batch.Job(str(source), "quad", str(out), {"quads": 500})
    row = batch.run_one(job)
    result = cr.quad(source, quads=500, quiet=True)
    assert row["exit_code"] == 0 and row["message"] == "" and row["hash"] == job.key()
    assert row["quads"] == len(result.quads) and row["quality.irregular"] == result.quality["irregular"]
    assert json.loads(row["options"]) == {"quads": 500}
    assert cr.read(out).n_faces == row["output.faces"]
    assert all(isinstance(value, (str, int, float, bool)) for value in row.values())


@pytest.mark.parametrize(
    ("job", "code", "text"),
    [
        ({"file": "gone.ply", "verb": "info"}, 5, "gone.ply"),
        ({"file": "part.ply", "verb": "nonsense"}, 2, "nonsense"),
        ({"file": "part.ply", "verb": "quad", "options": {"quad": 3}}, 2, "quad"),
        ({"file": "part.ply", "verb": "quad", "options": {"quads": "many"}}, 2, "many"),
        ({"file": "part.ply", "verb": "quad", "command": ("/no/such/program",)}, 70, "program"),
        ({"file": "part.ply", "verb": "quad", "deadline": 0.05}, 124, "deadline"),
        ({"verb": "quad"}, 70, "file"),
    ],
)
def test_a_job_never_raises(tmp_path, monkeypatch, job, code, text):
    monkeypatch.chdir(tmp_path)
    cr.sample("bracket", 60).write("part.ply")
    row = batch.run_one(job)
    assert row["exit_code"] == code and text in row["message"], row


def test_jobs_are_the_same_by_their_content(tmp_path, torus):
    a, b = tmp_path / "a.ply", tmp_path / "b.ply"
    torus.write(a)
    torus.write(b)
    job = batch.Job(str(a), "info", options={"threads": 1, "seed": 2})
    assert job.key() == batch.Job(str(b), "info", options={"seed": 2, "threads": 1}, deadline=5).key()
    assert job.key() != batch.Job(str(a), "info", options={"seed": 2}).key()
    assert job.key() != batch.Job(str(a), "quad", options={"threads": 1, "seed": 2}).key()
    key = job.key()
    a.write_bytes(a.read_bytes() + b"\n")
    assert job.key() != key


def test_a_run_that_was_stopped_goes_on(tmp_path, files):
    out, some = tmp_path / "rows.csv", [f for f in files if f.stem.startswith("torus")][:12]
    seen = []

    def stop(row) -> None:
        seen.append(row["file"])
        if len(seen) == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        batch.run(some, out, verb="info", workers=2, watch=stop)
    journal = tmp_path / "rows.csv.journal"
    assert not out.exists() and len(journal.read_text().splitlines()) == 5
    # The machine may stop in the middle of a line.
    with open(journal, "a") as file:
        file.write('{"hash": "12')
    summary = batch.run(some, out, verb="info", workers=2)
    assert (summary.skipped, summary.done, summary.failed) == (5, 7, 0)
    assert [row["file"] for row in batch.read_rows(out)] == [str(f) for f in some]
    assert not journal.exists()


def test_a_run_that_is_stopped_leaves_no_children(tmp_path, files):
    """The job that hangs is ended with the run, and so is what it started."""
    script, note = tmp_path / "evil", tmp_path / "pid"
    script.write_text(
        EVIL.replace("time.sleep(600)", f"open({str(note)!r}, 'w').write(str(os.getpid())); time.sleep(600)")
    )
    script.chmod(0o755)
    hang = next(f for f in files if f.stem == "hang")

    def stop(row) -> None:
        while not (note.exists() and note.read_text()):
            time.sleep(0.01)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        batch.run([hang, files[0]], tmp_path / "rows.csv", verb="info", workers=2, command=[str(script)], watch=stop)
    child = Path("/proc") / note.read_text()
    for _ in range(1000):
        if not child.exists():
            return
        time.sleep(0.01)
    pytest.fail(f"{child} is still there: {(child / 'cmdline').read_bytes()}")


def test_what_failed_or_lost_its_output_runs_again(tmp_path, files):
    jobs = [
        {"file": files[0], "verb": "convert", "output": tmp_path / "a.obj"},
        {"file": tmp_path / "no.ply", "verb": "info"},
    ]
    out = tmp_path / "rows.csv"
    assert batch.run(jobs, out).failed == 1
    assert batch.run(jobs, out).skipped == 2
    assert batch.run(jobs, out, retry=True).failed == 1
    (tmp_path / "a.obj").unlink()
    assert batch.run(jobs, out).done == 1 and (tmp_path / "a.obj").exists()


@pytest.mark.parametrize("extension", ["csv", "jsonl", "parquet"])
def test_manifests_and_tables_of_every_kind(tmp_path, files, extension):
    if extension == "parquet":
        need("pyarrow")
    manifest, out = tmp_path / f"jobs.{extension}", tmp_path / f"rows.{extension}"
    jobs = [
        {"file": str(files[0]), "verb": "info", "output": None, "triangles": None, "geometric": None},
        {
            "file": str(files[1]),
            "verb": "simplify",
            "output": str(tmp_path / "light.ply"),
            "triangles": 150,
            "geometric": True,
        },
    ]
    batch.write_rows(manifest, jobs)
    known = list(batch.read_manifest(manifest, deadline=50))
    assert [dict(job.options) for job in known] == [{}, {"triangles": 150, "geometric": True}]
    assert [job.deadline for job in known] == [50, 50]
    summary = batch.run(manifest, out)
    assert (summary.done, summary.failed) == (2, 0)
    rows = list(batch.read_rows(out))
    assert rows[0]["topology.euler"] == 0 and rows[0].get("output.faces") is None
    assert abs(rows[1]["output.faces"] - 150) <= 2
    assert batch.run(manifest, out).skipped == 2
    assert list(batch.read_rows(out)) == rows


def test_tables_of_unknown_kinds_are_refused_before_anything_runs(tmp_path, files):
    with pytest.raises(ValueError, match="csv"):
        batch.run(files, tmp_path / "rows.txt", verb="info")
    with pytest.raises(ValueError, match="engine"):
        batch.run(files, tmp_path / "rows.csv", verb="info", engine="spark")
    assert list(tmp_path.iterdir()) == []


def test_a_batch_from_a_terminal(tmp_path, files):
    import subprocess

    manifest, out = tmp_path / "jobs.csv", tmp_path / "rows.csv"
    batch.write_rows(manifest, [{"file": str(f)} for f in (files[0], tmp_path / "no.ply")])
    words = [str(manifest), str(out), "--verb", "simplify", "-O", "triangles=100", "--workers", "2"]
    done = subprocess.run([sys.executable, "-m", "carreau.batch", *words], capture_output=True, text=True)
    assert done.returncode == 4 and "2 jobs: 1 done, 1 failed" in done.stderr and "no.ply" in done.stderr
    assert len(list(batch.read_rows(out))) == 2
