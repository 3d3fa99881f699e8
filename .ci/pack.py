"""Packs a folder for people to download: `pack.py FOLDER OUT`.

A .zip file where there is an executable of Windows, else a .tar.gz file; the same files give the same bytes.
"""

import gzip
import io
import sys
import tarfile
import zipfile
from pathlib import Path

#: The earliest time that a .zip file can hold.
EPOCH = (1980, 1, 1, 0, 0, 0)


def files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def mode(path: Path) -> int:
    return 0o755 if path.name in ("carreau", "carreau.exe") else 0o644


def zipped(folder: Path, out: Path) -> Path:
    target = out / f"{folder.name}.zip"
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in files(folder):
            entry = zipfile.ZipInfo(path.relative_to(folder.parent).as_posix(), EPOCH)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, mode(path) << 16
            archive.writestr(entry, path.read_bytes())
    return target


def tarred(folder: Path, out: Path) -> Path:
    target, held = out / f"{folder.name}.tar.gz", io.BytesIO()
    with tarfile.open(fileobj=held, mode="w") as archive:
        for path in files(folder):
            entry = tarfile.TarInfo(path.relative_to(folder.parent).as_posix())
            entry.size, entry.mode = path.stat().st_size, mode(path)
            archive.addfile(entry, io.BytesIO(path.read_bytes()))
    target.write_bytes(gzip.compress(held.getvalue(), mtime=0))
    return target


def main() -> int:
    folder, out = (Path(word).resolve() for word in sys.argv[1:])
    windows = any(path.suffix == ".exe" for path in files(folder))
    print((zipped if windows else tarred)(folder, out))
    return 0


if __name__ == "__main__":
    sys.exit(main())
