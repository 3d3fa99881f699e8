"""The process that both add-ons run, by the executable and by the Python package; and the archives of the add-ons."""

import importlib.util
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import child
import ply

HERE = Path(__file__).resolve().parent.parent
CARREAU = os.environ.get("CARREAU", "")
pytestmark = pytest.mark.skipif(not CARREAU, reason="CARREAU does not name the executable")


@pytest.fixture(params=["executable", "package"])
def command(request):
    if request.param == "executable":
        return child.find(CARREAU)
    if importlib.util.find_spec("carreau") is None:
        pytest.skip("the Python package is not installed")
    found = child.find()
    assert len(found) == 2
    return found


@pytest.fixture(scope="module")
def bracket(tmp_path_factory):
    path = tmp_path_factory.mktemp("models") / "bracket.ply"
    subprocess.run([CARREAU, "sample", "bracket", "-q", "-o", path], check=True)
    return ply.read(str(path))


def started(command, verb, options, surface):
    run = child.Child(command, verb, options, "My part")
    ply.write(run.path("in.ply"), surface.points, surface.faces)
    return run


def test_a_run_gives_record_summary_and_the_same_points_and_faces(command, bracket):
    with started(command, "segment", {"rectify": "none", "regions": None}, bracket) as run:
        child.attend(run, "in.ply", "out.ply")
        record = run.finish()
        found = ply.read(run.path("out.ply"))
        folder = os.path.dirname(run.path("x"))
    assert record["options"]["rectify"] == "none" and record["summary"]
    assert found.points == bracket.points and found.faces == bracket.faces
    assert len(found.of_faces["region"]) == len(found.faces)
    assert not os.path.exists(folder)


def test_progress_names_stages(command, bracket):
    seen = []
    with started(command, "simplify", {"triangles": 500}, bracket) as run:
        child.attend(run, "in.ply", "out.ply", lambda stage, share: seen.append((stage, share)))
        run.finish()
    assert len({stage for stage, _ in seen}) > 2
    if len(command) == 2:
        assert all(0 <= share <= 1 for stage, share in seen if stage)


def test_a_failure_has_its_parts_and_the_name_of_the_object(command, bracket):
    with child.Child(command, "quad", {}, "My part") as run:
        points = [(float("nan"), 0.0, 0.0), *bracket.points[1:]]
        ply.write(run.path("in.ply"), points, bracket.faces)
        child.attend(run, "in.ply", "out.ply")
        with pytest.raises(child.Failure) as caught:
            run.finish()
    failure = caught.value
    assert "not finite" in failure.what and failure.where == "vertex 0" and failure.remedy and failure.code == 3
    assert not any("carreau-" in line for line in failure.lines())


@pytest.mark.parametrize(("options", "word"), [({"quads": -3}, "-3"), ({"nonsense": 1}, "nonsense")])
def test_wrong_options_are_named(command, bracket, options, word):
    with started(command, "quad", options, bracket) as run:
        child.attend(run, "in.ply", "out.ply")
        with pytest.raises(child.Failure) as caught:
            run.finish()
    assert word in caught.value.what


def test_cancel_from_the_watch_ends_the_process(command, bracket):
    with started(command, "quad", {"quads": 50000}, bracket) as run:
        child.attend(run, "in.ply", "out.ply", lambda stage, share: not stage)
        with pytest.raises(child.Cancelled):
            run.finish()
        assert not os.path.exists(run.path("out.ply"))


def test_closing_ends_what_goes_on(command, bracket):
    run = started(command, "quad", {"quads": 50000}, bracket)
    run.start("in.ply", "out.ply")
    process = run._process
    run.close()
    assert process.poll() is not None


def test_a_child_that_does_not_listen_is_killed(tmp_path):
    deaf = tmp_path / "carreau"
    deaf.write_text(
        f"#!{sys.executable}\n"
        "import signal, sys, time\n"
        "signal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
        "print('INFO stage{name=\"deaf\"}: close', file=sys.stderr, flush=True)\n"
        "time.sleep(600)\n"
    )
    deaf.chmod(0o755)
    with child.Child(child.find(str(deaf)), "quad", {}) as run:
        child.attend(run, "in.ply", "", lambda stage, share: stage != "deaf")
        with pytest.raises(child.Cancelled):
            run.finish()


def test_a_folder_of_that_name_is_no_package(tmp_path, monkeypatch):
    """FreeCAD's folder of add-ons is on the path, and the add-on's folder in it is named after the program."""
    (tmp_path / "some_addon" / "resources").mkdir(parents=True)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert child._package("some_addon") == ""
    (tmp_path / "some_addon" / "__init__.py").touch()
    importlib.invalidate_caches()
    sys.modules.pop("some_addon", None)
    assert child._package("some_addon") == str(tmp_path)


def test_what_is_not_there_is_said():
    with pytest.raises(child.Failure, match="no program") as caught:
        child.find("/nowhere/carreau")
    assert caught.value.remedy


@pytest.mark.parametrize(
    "text, parts",
    [
        ("what; at vertex 3; do this", ("what", "vertex 3", "do this")),
        ("what; do this; and that", ("what", "", "do this; and that")),
        ("what", ("what", "", "")),
    ],
)
def test_messages_are_divided(text, parts):
    assert child._parts(text) == parts


def test_ply_keeps_what_it_is_given(tmp_path):
    path = str(tmp_path / "x.ply")
    points = [(0.1, -1e300, 5e-324), (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (7.0, 8.0, 9.5)]
    ply.write(path, points, [(0, 1, 2), (3, 2, 1, 0)])
    found = ply.read(path)
    assert found.points == points and found.faces == [(0, 1, 2), (3, 2, 1, 0)]


def test_archives_are_the_same_every_time_and_whole(tmp_path):
    packed = []
    for folder in ("a", "b"):
        out = tmp_path / folder
        subprocess.run([sys.executable, HERE / "package.py", out], check=True, stdout=subprocess.DEVNULL)
        packed.append({path.name: path.read_bytes() for path in out.glob("*.zip")})
    assert packed[0] == packed[1] and set(packed[0]) == {"carreau-freecad.zip", "carreau-blender.zip"}
    for name, package in (("freecad", "carreau/carreau_freecad/"), ("blender", "")):
        with zipfile.ZipFile(tmp_path / "a" / f"carreau-{name}.zip") as file:
            for module in (HERE / "shared").glob("*.py"):
                assert file.read(f"{package}{module.name}") == module.read_bytes()
            assert not any("tests" in entry or "__pycache__" in entry for entry in file.namelist())
