"""What the tests share: small models, and packages that may be absent."""

from __future__ import annotations

import importlib
import os

import pytest

import carreau as cr

#: What `.ci/run` installs, by the names of the modules.
INSTALLED = {
    "distributed",
    "ipykernel",
    "meshio",
    "nbclient",
    "nbformat",
    "pyarrow",
    "pyvista",
    "ray",
    "tqdm",
    "trimesh",
}


def need(name: str):
    """A module that only some tests need: without it they are skipped, but the CI must have installed it."""
    try:
        return importlib.import_module(name)
    except ImportError:
        if os.environ.get("CI") == "true" and name in INSTALLED:
            raise
        pytest.skip(f"{name} is not installed")


@pytest.fixture(scope="session")
def bracket() -> cr.Mesh:
    return cr.sample("bracket", 30)


@pytest.fixture(scope="session")
def torus() -> cr.Mesh:
    return cr.sample("torus", 30)


@pytest.fixture(scope="session")
def tube() -> cr.Skeleton:
    return cr.Skeleton([[0, 0, 0], [0, 0, 3], [0, 0, 6]], [[0, 1], [1, 2]], radii=[1, 1, 1])
