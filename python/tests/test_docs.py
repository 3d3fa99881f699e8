"""The examples in the docstrings hold."""

from __future__ import annotations

import doctest
import importlib
import warnings

import pytest

MODULES = ["carreau", "carreau._mesh", "carreau._verbs", "carreau.batch"]


@pytest.mark.parametrize("name", MODULES)
def test_examples_hold(name):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE)
    assert result.attempted > 0 and result.failed == 0
