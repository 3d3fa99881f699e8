"""What goes wrong is said with place and remedy, and changes nothing."""

import subprocess
import sys
import time

import FreeCAD as App
import Mesh
import pytest

import carreau_freecad as cf
from carreau_freecad import settings
from carreau_freecad.operations import OPERATIONS, Job


def fan():
    """Three triangles at one edge."""
    a, b = (0, 0, 0), (0, 0, 1)
    return Mesh.Mesh([[a, b, c] for c in ((1, 0, 0), (0, 1, 0), (-1, -1, 0))])


def test_a_broken_mesh_is_refused_with_its_name_the_place_and_a_remedy(put, document):
    mesh = put(fan(), "Broken")
    before = len(document.Objects)
    with pytest.raises(cf.Failure) as caught:
        cf.hexes(mesh)
    failure = caught.value
    assert failure.code == 3 and failure.what.startswith("Broken: ") and failure.where and failure.remedy
    assert "carreau repair" not in failure.remedy and "Prepare" in failure.remedy
    assert len(document.Objects) == before


def test_what_is_no_mesh_is_refused(document):
    box = document.addObject("Part::Box", "Box")
    with pytest.raises(cf.Failure, match="Box is no mesh"):
        cf.cad(box)
    with pytest.raises(cf.Failure, match="has no triangles"):
        cf.cad(document.addObject("Mesh::Feature", "Empty"))


def test_a_wrong_option_is_named(put):
    with pytest.raises(cf.Failure) as caught:
        cf.quads(put("cylinder"), quads=-3)
    assert caught.value.code == 2 and "quads" in caught.value.what


def test_a_wrong_path_is_named(put):
    settings.parameters().SetString("Path", "/nowhere/carreau")
    with pytest.raises(cf.Failure) as caught:
        cf.info(put("cylinder"))
    assert "/nowhere/carreau" in caught.value.what and "preferences" in caught.value.remedy


def test_a_deadline_is_kept(put):
    settings.parameters().SetFloat("Deadline", 1e-3)
    try:
        with pytest.raises(cf.Failure) as caught:
            cf.quads(put("bracket"), quads=20000)
    finally:
        settings.parameters().SetFloat("Deadline", 0.0)
    assert caught.value.code == 124


def test_cancel_ends_the_child_and_changes_nothing(put, document):
    mesh = put("bracket")
    before = len(document.Objects)
    job = Job("quads", mesh, {"quads": 20000})
    with job.child as child:
        child.start(*job.files)
        assert not child.done()
        child.cancel()
        while not child.done():
            time.sleep(0.01)
        with pytest.raises(cf.Cancelled):
            job.finish()
    assert len(document.Objects) == before


def test_a_mesh_that_goes_meanwhile_does_no_harm(put, document):
    for gone in ("mesh", "document"):
        mesh = put(Mesh.createBox(10, 20, 30))
        job = Job("cad", mesh, {})
        with job.child as child:
            child.start(*job.files)
            if gone == "mesh":
                document.removeObject(mesh.Name)
            else:
                App.closeDocument(document.Name)
            while not child.done():
                time.sleep(0.01)
            if gone == "mesh":
                assert job.finish()[0].Shape.isValid()
            else:
                with pytest.raises(cf.Failure, match="was closed"):
                    job.finish()


def test_every_operation_has_words_and_an_icon():
    from pathlib import Path

    from carreau_freecad.resources import icon

    for name, operation in OPERATIONS.items():
        assert operation.title and operation.tip and Path(icon(name)).is_file()
        assert all(option.label and option.tip for option in operation.options)


def test_the_interpreter_beside_freecad_is_of_its_version():
    """FreeCAD is its own `sys.executable`; the Python package is run by a Python beside it."""
    from carreau_freecad.child import interpreter

    said = subprocess.run(
        [interpreter(), "-c", "import sys; print(sys.version_info[:2])"], check=True, capture_output=True
    )
    assert said.stdout.decode().strip() == str(sys.version_info[:2])
