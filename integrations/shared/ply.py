"""Binary PLY files, as the add-ons exchange meshes with carreau: doubles, polygons of any size, labels of faces."""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Iterable, Sequence
from typing import Any, BinaryIO

__all__ = ["Surface", "read", "write"]

_CODES = {
    "char": "b",
    "int8": "b",
    "uchar": "B",
    "uint8": "B",
    "short": "h",
    "int16": "h",
    "ushort": "H",
    "uint16": "H",
    "int": "i",
    "int32": "i",
    "uint": "I",
    "uint32": "I",
    "float": "f",
    "float32": "f",
    "double": "d",
    "float64": "d",
}


class Surface:
    """Points, faces as tuples of vertex ids, and the scalar columns of both by name."""

    def __init__(self, elements: dict[str, dict[str, list[Any]]]) -> None:
        vertex, face = elements.get("vertex", {}), elements.get("face", {})
        self.points: list[tuple[float, float, float]] = list(zip(vertex["x"], vertex["y"], vertex["z"], strict=True))
        self.faces: list[tuple[int, ...]] = face.pop("vertex_indices", [])
        self.of_vertices, self.of_faces = vertex, face


def write(path: str, points: Iterable[Sequence[float]], faces: Sequence[Sequence[int]]) -> None:
    """Writes a surface."""
    coordinates = array("d", (float(x) for point in points for x in point))
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(coordinates) // 3}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uint32 uint32 vertex_indices\nend_header\n"
    )
    numbers = array("I", (n for face in faces for n in (len(face), *face)))
    if sys.byteorder == "big":
        coordinates.byteswap()
        numbers.byteswap()
    with open(path, "wb") as file:
        file.write(header.encode("ascii"))
        coordinates.tofile(file)
        numbers.tofile(file)


def read(path: str) -> Surface:
    """Reads what carreau wrote: binary, little-endian."""
    with open(path, "rb") as file:
        elements = _header(file)
        data, at, found = file.read(), 0, {}
        for name, count, properties in elements:
            if any(size for _, size, _ in properties):
                found[name], at = _with_lists(data, at, count, properties)
            else:
                found[name], at = _scalars(data, at, count, properties)
    return Surface(found)


def _header(file: BinaryIO) -> list[tuple[str, int, list[tuple[str, str, str]]]]:
    """Name, number and properties of every element. A property: name, code of a list's size (a scalar: none), code."""
    elements: list[tuple[str, int, list[tuple[str, str, str]]]] = []
    for line in iter(file.readline, b"end_header\n"):
        words = line.decode("utf-8").split()
        if not words:
            raise ValueError("the header of the PLY file has no end")
        if words[0] == "format" and words[1] != "binary_little_endian":
            raise ValueError(f"a PLY file of the format {words[1]}")
        if words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property" and words[1] == "list":
            elements[-1][2].append((words[4], _CODES[words[2]], _CODES[words[3]]))
        elif words[0] == "property":
            elements[-1][2].append((words[2], "", _CODES[words[1]]))
    return elements


def _scalars(
    data: bytes, at: int, count: int, properties: list[tuple[str, str, str]]
) -> tuple[dict[str, list[Any]], int]:
    row = struct.Struct("<" + "".join(code for _, _, code in properties))
    end = at + count * row.size
    rows = row.iter_unpack(data[at:end])
    columns = list(zip(*rows, strict=True)) or [()] * len(properties)
    return {name: list(column) for (name, _, _), column in zip(properties, columns, strict=True)}, end


def _with_lists(
    data: bytes, at: int, count: int, properties: list[tuple[str, str, str]]
) -> tuple[dict[str, list[Any]], int]:
    columns: dict[str, list[Any]] = {name: [] for name, _, _ in properties}
    for _ in range(count):
        for name, size, code in properties:
            if not size:
                scalar = struct.Struct("<" + code)
                columns[name].append(scalar.unpack_from(data, at)[0])
                at += scalar.size
                continue
            length = struct.Struct("<" + size)
            (n,) = length.unpack_from(data, at)
            at += length.size
            items = struct.Struct(f"<{n}{code}")
            columns[name].append(items.unpack_from(data, at))
            at += items.size
    return columns, at
