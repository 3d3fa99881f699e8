"""Finite elements on a mesh of hexahedra: the example of the documents, against what is known exactly."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import carreau as cr

EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "heat_in_a_pipe.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("heat_in_a_pipe", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def result(example):
    return cr.hex(example.pipe())


def test_the_flow_through_a_bent_pipe_is_the_exact_one(example, result):
    flows = example.flows(result)
    # Cells about a round section take up a little less than all of it.
    assert flows["hexahedra"] == pytest.approx(flows["exact"], rel=0.02)
    assert flows["hexahedra"] == pytest.approx(flows["tetrahedra"], rel=0.01)


def test_temperatures_follow_the_angle(example, result):
    assert result.certified
    mesh, ends = example.model(result)
    _, temperature = example.flow(mesh, example.skfem.ElementHex1(), *ends)
    angle = np.arctan2(result.points[:, 1], result.points[:, 0]) / example.ANGLE
    expected = angle if temperature[np.argmin(angle)] < 0.5 else 1 - angle
    assert np.abs(temperature - expected).max() < 0.03
