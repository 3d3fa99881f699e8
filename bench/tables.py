"""Tables of the comparison, read as a reader does: where a row of carreau's is behind a peer's, and behind its own of before.

A table is a block of lines that begin with a bar. One of its columns names the tool; the first column names the file. Rows of
one file follow each other; when a tool comes a second time, the next group of that file begins (another number of triangles).
"""
import re
from dataclasses import dataclass

TOOL = ("tool", "method")
# Figures by their columns: whether less is better. Others are told, not compared (counts that were asked for, memory).
LESS_IS_BETTER = {
    "CPU s": True, "irregular": True, "inverted": True, "distance %": True, "rms %": True, "bad": True, "mean Q": True,
    "features kept": False, "SJ min": False, "SJ mean": False, "shape min": False, "shape mean": False, "inside": False,
}
# A peer's result that is broken is no rival in quality; its time counts.
ALWAYS_COMPARED = ("CPU s",)
# How much better a peer must be to be told: less is within the digits of the table.
TOLD_FROM = 1.02
# How much worse than before a row must be to be told (the share that README.md names).
WORSE_FROM = 1.10
OURS = "carreau"


@dataclass
class Row:
    """`key`: file, number of the group, tool."""
    key: tuple
    cells: dict

    @property
    def tool(self):
        return self.key[2]

    @property
    def is_ours(self):
        return self.tool.split()[0] == OURS

    @property
    def is_sound(self):
        """Whether what the tool made is what was asked for."""
        return number(self.cells.get("inverted", "0")) == 0 and not self.cells.get("")


def number(cell):
    """The number that a cell begins with, or None."""
    found = re.match(r"-?\d+(\.\d+)?", cell.strip())
    return float(found[0]) if found else None


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def rows_of(text):
    """(head, rows) of the first table in a text."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    if len(lines) < 2:
        return [], []
    cells = [cells_of(line) for line in lines]
    head, rows, group, seen = cells[0], [], 0, (None, set())
    tool = next((k for k, name in enumerate(head) if name in TOOL), None)
    if tool is None:
        return head, []
    for line in cells[2:]:
        line += [""] * (len(head) - len(line))
        name = line[0]
        if name != seen[0]:
            group, seen = 0, (name, set())
        elif line[tool] in seen[1]:
            group, seen = group + 1, (name, set())
        seen[1].add(line[tool])
        rows.append(Row((name, group, line[tool]), dict(zip(head, line))))
    return head, rows


def behind(mine, other, column):
    """How many times better a figure of `other` is; None where they do not compare."""
    mine, other = (number(row.cells.get(column, "")) for row in (mine, other))
    if mine is None or other is None:
        return None
    if LESS_IS_BETTER[column]:
        mine, other = other, mine
    # Now more is better; a figure of nothing, or a negative one, is beaten by any.
    if other <= mine:
        return 1.0
    return other / mine if mine > 0 else float("inf")


def compared(text, beside):
    """The table with two columns more in carreau's rows: the time over that of the fastest peer, and the figures in which a peer
    is ahead. `beside`: the peers of each tool; all where a tool is not named."""
    head, rows = rows_of(text)
    if not rows:
        return text
    lines, told = [], iter(rows)
    for line in text.splitlines():
        if not line.startswith("|"):
            lines.append(line)
        elif line.startswith("|---"):
            lines.append(line + "---|---|")
        elif cells_of(line) == head:
            lines.append(line + " time / peer | behind |")
        else:
            row = next(told)
            lines.append(line + " ".join(["", *(f"{cell} |" for cell in beside_peers(row, rows, beside))]))
    return "\n".join(lines)


def beside_peers(row, rows, beside):
    if not row.is_ours:
        return "", ""
    peers = [r for r in rows if r.key[:2] == row.key[:2] and not r.is_ours]
    if row.tool in beside:
        peers = [r for r in peers if r.tool in beside[row.tool]]
    mine = number(row.cells.get("CPU s", ""))
    times = [t for t in (number(r.cells.get("CPU s", "")) for r in peers) if t]
    ratio = f"{mine / min(times):.2f}" if mine is not None and times else ""
    losses = []
    for column in (c for c in row.cells if c in LESS_IS_BETTER):
        rivals = [r for r in peers if r.is_sound or column in ALWAYS_COMPARED]
        by = {r.tool: behind(row, r, column) for r in rivals}
        by = {tool: ratio for tool, ratio in by.items() if ratio is not None and ratio > TOLD_FROM}
        if by:
            tool = max(by, key=by.get)
            losses.append(f"**{column}**: {tool}")
    return ratio, ", ".join(losses)


def worse(new, old):
    """Sentences about carreau's figures that are more than a tenth worse than in the table of before."""
    before = {row.key: row for row in rows_of(old)[1]}
    said = []
    for row in rows_of(new)[1]:
        if not row.is_ours or row.key not in before:
            continue
        for column in (c for c in row.cells if c in LESS_IS_BETTER):
            ratio = behind(row, before[row.key], column)
            if ratio is not None and ratio > WORSE_FROM and not is_last_digit(row.cells[column], before[row.key].cells[column]):
                said.append(f"{row.key[0]}, {row.tool}: {column} is {row.cells[column]}, was {before[row.key].cells[column]}")
    return said


def is_last_digit(a, b):
    """Whether two cells differ by no more than one in their last digit."""
    digits = max((len(c.split(".")[1].split()[0].rstrip("°%")) if "." in c else 0) for c in (a, b))
    return abs(number(a) - number(b)) < 1.5 * 10 ** -digits
