"""The licences of what carreau is made of: checks that all are permissive, and writes them down.

    python3 .ci/licences.py                 # checks
    python3 .ci/licences.py --out FOLDER    # and writes THIRD-PARTY.txt and carreau.cdx.json (CycloneDX) there

Counted are the crates that a build of the executable or of the Python package takes in, on any platform, not those that
only build or test it; and three.js, which is in the viewer of the pages.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
#: Licences that ask for no more than their text, by SPDX.
ALLOWED = {
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
}
TOPS = ("carreau-cli", "carreau-py")
TEXTS = re.compile(r"(licen[cs]e|copying|notice|unlicense)", re.IGNORECASE)


def crates() -> list[dict[str, Any]]:
    """The packages that are linked in, by name and version."""
    command = ["cargo", "metadata", "--format-version=1", "--locked"]
    found = json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
    packages = {package["id"]: package for package in found["packages"]}
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    own = set(found["workspace_members"])
    open_, seen = [i for i in own if packages[i]["name"] in TOPS], set()
    while open_:
        at = open_.pop()
        if at in seen:
            continue
        seen.add(at)
        for dependency in nodes[at]["deps"]:
            # Kind None: an ordinary one, neither for builds nor for tests. Procedural macros are not linked in.
            ordinary = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            macro = any("proc-macro" in target["kind"] for target in packages[dependency["pkg"]]["targets"])
            if ordinary and not macro:
                open_.append(dependency["pkg"])
    return sorted((packages[i] for i in seen - own), key=lambda package: (package["name"], package["version"]))


def permitted(expression: str) -> bool:
    """Whether an SPDX expression can be met by licences that are allowed; `A/B` is an old way to write `A OR B`."""
    words = re.findall(r"\(|\)|[^\s()]+(?: WITH [^\s()]+)?", expression.replace("/", " OR "))

    def any_of() -> bool:
        met = all_of()
        while words and words[0] == "OR":
            words.pop(0)
            met |= all_of()
        return met

    def all_of() -> bool:
        met = one()
        while words and words[0] == "AND":
            words.pop(0)
            met &= one()
        return met

    def one() -> bool:
        word = words.pop(0)
        if word != "(":
            return word in ALLOWED
        met = any_of()
        words.pop(0)
        return met

    return any_of()


def texts(folder: Path) -> list[str]:
    """The texts of licences and notices beside a manifest."""
    files = sorted(path for path in folder.iterdir() if path.is_file() and TEXTS.search(path.name))
    return [path.read_text(encoding="utf-8", errors="replace").strip() for path in files]


def three() -> dict[str, Any]:
    """three.js, in the version that the viewer was built with."""
    lock = json.loads((ROOT / "viewer" / "package-lock.json").read_text(encoding="utf-8"))["packages"][
        "node_modules/three"
    ]
    return {
        "name": "three",
        "version": lock["version"],
        "license": lock["license"],
        "folder": ROOT / "viewer" / "node_modules" / "three",
    }


def components() -> list[dict[str, Any]]:
    """Name, version, licence, folder and package URL of everything."""
    found = [
        {
            "name": package["name"],
            "version": package["version"],
            "license": package["license"] or "",
            "folder": Path(package["manifest_path"]).parent,
            "purl": f"pkg:cargo/{package['name']}@{package['version']}",
        }
        for package in crates()
    ]
    script = three()
    return [*found, {**script, "purl": f"pkg:npm/three@{script['version']}"}]


def third_party(parts: list[dict[str, Any]]) -> str:
    """What has to go with every copy: each text once, under the names of all that it belongs to."""
    head = ["carreau is made with the following, each under the licence that stands beside it.", ""]
    head += [f"  {part['name']} {part['version']}: {part['license']}" for part in parts]
    by_text: dict[str, list[str]] = {}
    for part in parts:
        for text in texts(part["folder"]) if part["folder"].is_dir() else []:
            by_text.setdefault(text, []).append(part["name"])
    for text, names in by_text.items():
        head += ["", "-" * 80, ", ".join(dict.fromkeys(names)), "-" * 80, "", text]
    return "\n".join(head) + "\n"


def bill(parts: list[dict[str, Any]]) -> dict[str, Any]:
    """The bill of materials, as CycloneDX."""
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "components": [
            {
                "type": "library",
                "name": part["name"],
                "version": part["version"],
                "purl": part["purl"],
                "licenses": [{"expression": part["license"].replace("/", " OR ")}],
            }
            for part in parts
        ],
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path)
    out = parser.parse_args().out
    parts = components()
    refused = [part for part in parts if not part["license"] or not permitted(part["license"])]
    for part in refused:
        print(f"{part['name']} {part['version']}: {part['license'] or 'no licence is stated'}", file=sys.stderr)
    print(f"licences: {len(parts)} components, {len(refused)} that may not be linked in")
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        (out / "THIRD-PARTY.txt").write_text(third_party(parts), encoding="utf-8")
        (out / "carreau.cdx.json").write_text(json.dumps(bill(parts), indent=1) + "\n", encoding="utf-8")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
