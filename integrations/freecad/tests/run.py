"""Runs the tests of this folder in FreeCAD: `freecadcmd run.py`.

From the environment: CARREAU, the executable; CARREAU_ADDON, the folder of the add-on that `integrations/package.py`
makes; CARREAU_PYTEST, the folder that has pytest, of any Python of about the same version.
"""

import os
import sys
from pathlib import Path


def main() -> int:
    sys.path.insert(0, os.environ["CARREAU_ADDON"])
    sys.path.append(os.environ["CARREAU_PYTEST"])
    sys.dont_write_bytecode = True
    import pytest

    here = Path(__file__).resolve().parent
    more = os.environ.get("CARREAU_PYTEST_ARGS", "").split()
    return int(pytest.main([str(here), "-q", "-ra", "-p", "no:cacheprovider", f"--rootdir={here}", *more]))


code = main()
sys.stdout.flush()
# FreeCAD would ask for the next line and end with 0.
os._exit(code)
