"""Documents and meshes for the tests in FreeCAD."""

import os
import subprocess

import FreeCAD as App
import Mesh
import pytest

from carreau_freecad import settings

CARREAU = os.environ["CARREAU"]


@pytest.fixture(autouse=True)
def program():
    settings.parameters().SetString("Path", CARREAU)


@pytest.fixture
def document():
    document = App.newDocument("Test")
    document.UndoMode = 1
    name = document.Name
    yield document
    if name in App.listDocuments():
        App.closeDocument(name)


@pytest.fixture(scope="session")
def sample(tmp_path_factory):
    """The file of a built-in model."""
    folder = tmp_path_factory.mktemp("samples")

    def make(name, kind="stl"):
        path = folder / f"{name}.{kind}"
        if not path.exists():
            subprocess.run([CARREAU, "sample", name, "-q", "-o", path], check=True)
        return str(path)

    return make


@pytest.fixture
def put(document, sample):
    """Puts a built-in model, or points and triangles, into the document, turned and moved."""

    def make(what, label="Part"):
        feature = document.addObject("Mesh::Feature", "Mesh")
        feature.Label = label
        feature.Mesh = Mesh.Mesh(sample(what) if isinstance(what, str) else what)
        feature.Placement = App.Placement(App.Vector(100, -20, 3), App.Rotation(App.Vector(1, 2, 3), 40))
        return feature

    return make
