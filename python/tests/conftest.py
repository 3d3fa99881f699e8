"""What the tests share: small models, and packages that may be absent."""

from __future__ import annotations

import importlib
import os

import pytest

import carreau as cr


def need(name: str):
    """A module that only some tests need: without it they are skipped, on the CI they fail."""
    try:
        return importlib.import_module(name)
    except ImportError:
        if os.environ.get("CARREAU_ALL_PACKAGES"):
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
