"""What a notebook shows."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from html import escape
from typing import Any

__all__ = ["page"]


def page(title: str, figures: Mapping[str, Any], picture: bytes | None) -> str:
    """A table of figures beside a picture.

    Parameters
    ----------
    title : str
        What is shown.
    figures : mapping of str to number or str
        Rows of the table.
    picture : bytes or None
        PNG.
    """
    cell = "<td style='text-align:right'>"
    rows = "".join(
        f"<tr><th>{escape(name)}</th>{cell}{escape(_text(value))}</td></tr>" for name, value in figures.items()
    )
    image = ""
    if picture:
        data = base64.b64encode(picture).decode("ascii")
        image = f"<img alt='{escape(title)}' style='max-width:520px' src='data:image/png;base64,{data}'>"
    return (
        "<div style='display:flex;gap:1.5em;align-items:center;flex-wrap:wrap'>"
        f"{image}<div><b>{escape(title)}</b><table>{rows}</table></div></div>"
    )


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value)
