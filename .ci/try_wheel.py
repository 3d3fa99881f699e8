"""Tries a wheel as a user would: `try_wheel.py FOLDER` installs the one in there into a clean environment and runs it.

Fails where it is larger than 15 MB, needs a compiler, lacks the licences, or does not work; times are told.
"""

import subprocess
import sys
import tempfile
import time
import venv
import zipfile
from pathlib import Path

#: Bytes: what a package index and a slow line take without a thought.
LARGEST = 15 * 10**6
TRY = """
import time
start = time.perf_counter()
import carreau as cr
print(f"import: {time.perf_counter() - start:.2f} s")
part = cr.sample("bracket")
solid = cr.cad(part, quiet=True)
assert solid.record["solids"] == 1, solid.record
assert len(cr.segment(part, quiet=True).regions) == 13
"""


def timed(name: str, command: list[str]) -> None:
    start = time.perf_counter()
    subprocess.run(command, check=True)
    print(f"{name}: {time.perf_counter() - start:.1f} s", flush=True)


def main() -> int:
    (wheel,) = Path(sys.argv[1]).glob("*.whl")
    size = wheel.stat().st_size
    print(f"{wheel.name}: {size / 1e6:.1f} MB")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    missing = [
        word
        for word in ("LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY.txt")
        if not any(n.endswith(word) for n in names)
    ]
    if missing or size > LARGEST:
        print(f"too large, or without {missing}", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        scripts = Path(folder) / ("Scripts" if sys.platform == "win32" else "bin")
        python = str(scripts / "python")
        timed("install", [python, "-m", "pip", "install", "--quiet", "--only-binary", ":all:", str(wheel)])
        timed("try", [python, "-c", TRY])
        timed("command", [str(scripts / "carreau"), "sample", "torus", "-o", str(Path(folder) / "torus.stl")])
        timed("demo", [str(scripts / "carreau"), "demo", "-o", str(Path(folder) / "demo")])
    return 0


if __name__ == "__main__":
    sys.exit(main())
