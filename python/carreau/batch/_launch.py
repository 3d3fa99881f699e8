"""The command line without the package around it, as the child processes of a batch run it.

Neither carreau's Python half nor numpy is imported: that would take longer than a small job. Run as a script.
"""

import importlib.machinery
import importlib.util
import os
import sys
from pathlib import Path


def main() -> int:
    """Run the command line on this process's arguments."""
    package = Path(__file__).resolve().parent.parent
    library = next(path for path in sorted(package.glob("_core.*")) if path.suffix in (".so", ".pyd"))
    loader = importlib.machinery.ExtensionFileLoader("_core", str(library))
    spec = importlib.machinery.ModuleSpec("_core", loader, origin=str(library))
    native = importlib.util.module_from_spec(spec)
    loader.exec_module(native)
    return native.main(["carreau", *sys.argv[1:]])


def tell_peak(file: str) -> None:
    """Write this process's peak memory, in kilobytes: the parent cannot ask once it has ended."""
    with open("/proc/self/status", encoding="ascii", errors="replace") as status:
        peak = next(line.split()[1] for line in status if line.startswith("VmHWM"))
    Path(file).write_text(peak)


if __name__ == "__main__":
    code = main()
    if "CARREAU_PEAK_FILE" in os.environ:
        tell_peak(os.environ["CARREAU_PEAK_FILE"])
    sys.stdout.flush()
    # Nothing is left to tidy up, and an interpreter takes its time for it.
    os._exit(code)
