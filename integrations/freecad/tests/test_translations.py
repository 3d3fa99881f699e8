"""Every text that is shown is in the files for the translators, and the compiled ones hold what these say."""

import ast
import os
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

QtCore = pytest.importorskip("PySide.QtCore")

ADDON = Path(os.environ["CARREAU_ADDON"])
FILES = sorted((ADDON / "resources" / "translations").glob("*.ts"))


def shown():
    """The texts in the sources."""
    calls = [
        node
        for module in (ADDON / "carreau_freecad").glob("*.py")
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("_noop", "translated")
    ]
    return {call.args[0].value for call in calls if call.args and isinstance(call.args[0], ast.Constant)}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_translations_are_complete(file):
    texts = {message.findtext("source"): message.findtext("translation") for message in ET.parse(file).iter("message")}
    assert set(texts) == shown()
    compiled = file.with_suffix(".qm")
    if "_" in file.stem:
        translator = QtCore.QTranslator()
        assert translator.load(str(compiled))
        assert all(translator.translate("carreau", text) == words for text, words in texts.items())
