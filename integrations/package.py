"""Makes the add-ons as they are installed: the shared modules beside their own, as folders and as archives.

    python integrations/package.py dist

writes `dist/carreau-freecad/`, `dist/carreau-blender/` and an archive of each. The same sources give the same bytes.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
#: Where the files of an add-on lie, and the package in there that the shared modules go into.
ADDONS = {"freecad": ("freecad", "carreau_freecad"), "blender": ("blender/carreau_blender", ".")}
LICENCES = ("LICENSE-MIT", "LICENSE-APACHE")
#: What only a clone needs.
LEFT_OUT = shutil.ignore_patterns("tests", "__pycache__", "*.pyc")
#: The earliest time that an archive can hold.
EPOCH = (1980, 1, 1, 0, 0, 0)


def assemble(name: str, out: Path) -> Path:
    """The folder of an add-on, made anew."""
    folder = out / f"carreau-{name}"
    shutil.rmtree(folder, ignore_errors=True)
    source, package = ADDONS[name]
    shutil.copytree(HERE / source, folder, ignore=LEFT_OUT)
    for module in sorted((HERE / "shared").glob("*.py")):
        shutil.copy(module, folder / package / module.name)
    for licence in LICENCES:
        shutil.copy(HERE.parent / licence, folder / licence)
    return folder


def archive(folder: Path, within: str) -> Path:
    """An archive of a folder whose files lie in the folder `within` of it."""
    path = folder.parent / f"{folder.name}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for source in sorted(p for p in folder.rglob("*") if p.is_file()):
            entry = zipfile.ZipInfo(f"{within}{source.relative_to(folder).as_posix()}", EPOCH)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            file.writestr(entry, source.read_bytes())
    return path


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    for name in ADDONS:
        # Blender wants the manifest at the top; FreeCAD's Mod folder wants one folder an add-on.
        print(archive(assemble(name, out), "carreau/" if name == "freecad" else ""))
    return 0


if __name__ == "__main__":
    sys.exit(main())
