"""All that has a version has the same: `check_version.py [VERSION]`, that of the workspace by default."""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def versions() -> dict[str, str]:
    """The versions that are stated, by place."""
    cargo = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))
    found = {"Cargo.toml": cargo["workspace"]["package"]["version"]}
    for name in ("carreau", "carreau-cli", "carreau-py"):
        manifest = tomllib.loads((ROOT / "crates" / name / "Cargo.toml").read_text(encoding="utf-8"))
        for dependency, what in manifest["dependencies"].items():
            if dependency.startswith("carreau"):
                found[f"{name} on {dependency}"] = what["version"]
    blender = ROOT / "integrations" / "blender" / "carreau_blender" / "blender_manifest.toml"
    found["Blender's manifest"] = tomllib.loads(blender.read_text(encoding="utf-8"))["version"]
    freecad = (ROOT / "integrations" / "freecad" / "package.xml").read_text(encoding="utf-8")
    found["FreeCAD's package"] = re.findall(r"<version>(.*?)</version>", freecad)[0]
    return found


def main() -> int:
    stated = versions()
    wanted = sys.argv[1] if len(sys.argv) > 1 else stated["Cargo.toml"]
    wrong = {place: version for place, version in stated.items() if version != wanted}
    for place, version in wrong.items():
        print(f"{place}: {version}, not {wanted}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
