"""``python -m carreau`` and the console script: the command line."""

from __future__ import annotations

import sys

from . import _core


def main() -> int:
    """Run the command line on this process's arguments; the exit code is that of the command line."""
    return _core.main(["carreau", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
