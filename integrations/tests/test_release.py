"""What a release is checked by."""

import importlib.util
import stat
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

CI = Path(__file__).resolve().parent.parent.parent / ".ci"


def load(name):
    spec = importlib.util.spec_from_file_location(name, CI / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("expression", "met"),
    [
        ("MIT", True),
        ("GPL-3.0", False),
        ("MIT OR GPL-3.0", True),
        ("GPL-3.0/MIT", True),
        ("MIT AND GPL-3.0", False),
        ("Apache-2.0 WITH LLVM-exception OR GPL-3.0", True),
        ("GPL-3.0 WITH Classpath-exception-2.0", False),
        ("(MIT OR GPL-3.0) AND Unicode-3.0", True),
        ("(GPL-2.0 OR LGPL-3.0) AND MIT", False),
        ("MIT OR (GPL-2.0 AND LGPL-3.0)", True),
    ],
)
def test_licences_are_met_or_not(expression, met):
    assert load("licences").permitted(expression) is met


def test_versions_agree():
    stated = load("check_version").versions()
    assert len(stated) > 4 and len(set(stated.values())) == 1, stated


@pytest.mark.parametrize("executable", ["carreau", "carreau.exe"])
def test_archives_hold_a_program_that_may_run(tmp_path, executable):
    folder = tmp_path / "carreau-here"
    (folder / "completions").mkdir(parents=True)
    (folder / executable).write_bytes(b"\x7f")
    (folder / "README.md").write_text("x")
    made = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        done = subprocess.run(
            [sys.executable, CI / "pack.py", folder, tmp_path / name], check=True, capture_output=True
        )
        made.append(Path(done.stdout.decode().strip()))
    assert made[0].read_bytes() == made[1].read_bytes()
    if executable == "carreau":
        with tarfile.open(made[0]) as archive:
            modes = {entry.name: entry.mode for entry in archive}
    else:
        with zipfile.ZipFile(made[0]) as archive:
            modes = {entry.filename: entry.external_attr >> 16 for entry in archive.infolist()}
    assert modes[f"carreau-here/{executable}"] & stat.S_IXUSR and not modes["carreau-here/README.md"] & stat.S_IXUSR
