"""Tables for a notebook: what `_repr_html_` of models, states, results and analyses gives."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import Any

MOST_ROWS = 60


def table(columns: Sequence[str], rows: Iterable[Sequence[Any]], title: str = "") -> str:
    """An HTML table; numbers with five digits, to the right. Rows behind the sixtieth are counted, not shown."""
    rows = list(rows)
    lines = [f"<p><b>{html.escape(title)}</b></p>"] if title else []
    lines += ["<table>", "<tr>" + "".join(f"<th>{html.escape(column)}</th>" for column in columns) + "</tr>"]
    lines += ["<tr>" + "".join(map(_cell, row)) + "</tr>" for row in rows[:MOST_ROWS]]
    lines.append("</table>")
    if len(rows) > MOST_ROWS:
        lines.append(f"<p>... and {len(rows) - MOST_ROWS} more</p>")
    return "\n".join(lines)


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f'<td style="text-align: right">{value:.5g}</td>'
    return f"<td>{html.escape(str(value))}</td>"
