"""What a notebook shows."""

from __future__ import annotations

from html import escape

__all__ = ["framed"]


def framed(page: str, height: int = 560) -> str:
    """A page within a notebook: it keeps its styles and scripts to itself.

    Parameters
    ----------
    page : str
        HTML.
    height : int
        Pixels.
    """
    style = f"width:100%;height:{height}px;border:1px solid #8884;border-radius:4px"
    return f'<iframe style="{style}" srcdoc="{escape(page, quote=True)}"></iframe>'
