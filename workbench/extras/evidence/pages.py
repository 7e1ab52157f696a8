"""A report as a page for a browser, or as one for a printer.

The page is one file that fetches nothing and runs nothing.  The PDF needs Matplotlib,
of the extra `evidence`; it is text on A4, made so that the same report gives the same bytes.
"""

import io
import textwrap
from collections.abc import Iterable, Iterator
from html import escape

from workbench.extras.evidence.report import ReportTable

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1b1e23; max-width: 72rem; margin: 2rem auto;
  padding: 0 1.5rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.1rem; margin: 2rem 0 0.3rem; }
p { margin: 0.2rem 0 0.6rem; color: #4a4f57; }
table { border-collapse: collapse; width: 100%; font-size: 0.86rem; }
th, td { text-align: left; vertical-align: top; padding: 0.25rem 0.6rem 0.25rem 0;
  border-bottom: 1px solid #d9dde3; overflow-wrap: anywhere; }
th { color: #4a4f57; font-weight: 600; }
th[scope=row] { width: 9.5rem; } th[scope=col] { white-space: nowrap; }
td:empty { height: 2.2rem; }
.nowrap { white-space: nowrap; font-variant-numeric: tabular-nums; }
@media print { body { margin: 0; max-width: none; font-size: 9pt; } tr { break-inside: avoid; } }
@page { size: A4; margin: 15mm; }
"""

SHORT = 24
"""Cells of up to this many characters are not broken: numbers, times, names."""

COLUMNS, LINES = 112, 84
"""Of a printed page, in a font of one width."""

INCHES = (8.27, 11.69)

FONT = "DejaVu Sans Mono"


def html_page(title: str, tables: Iterable[ReportTable]) -> bytes:
    """The report as one HTML file; every text in it is escaped."""
    body = "".join(_section(table) for table in tables)
    policy = "default-src 'none'; style-src 'unsafe-inline'"
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head>"
        f"<body><h1>{escape(title)}</h1>{body}</body></html>\n"
    ).encode()


def _section(table: ReportTable) -> str:
    says = f"<p>{escape(table.says)}</p>" if table.says else ""
    if not table.rows:
        return f"<h2>{escape(table.title)}</h2>{says}<p>None.</p>"
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in table.columns)
    rows = "".join(_row(row, is_named=not table.columns) for row in table.rows)
    return f"<h2>{escape(table.title)}</h2>{says}<table><tr>{head}</tr>{rows}</table>"


def _row(row: tuple[str, ...], *, is_named: bool) -> str:
    cells = [
        f'<td class="nowrap">{escape(cell)}</td>'
        if len(cell) <= SHORT
        else f"<td>{escape(cell)}</td>"
        for cell in row
    ]
    if is_named:
        cells[0] = f'<th scope="row">{escape(row[0])}</th>'
    return f"<tr>{''.join(cells)}</tr>"


def pdf_pages(title: str, tables: Iterable[ReportTable]) -> bytes | None:
    """The report as a PDF file; None where Matplotlib is not installed."""
    try:
        import matplotlib
        from matplotlib.backends.backend_pdf import PdfPages
        from matplotlib.figure import Figure
    except ImportError:
        return None
    content = io.BytesIO()
    lines = list(_lines(title, tables))
    sheets = [lines[start : start + LINES] for start in range(0, len(lines), LINES)]
    # Text as text, in a font that has Latin, Greek and Cyrillic letters.
    with (
        matplotlib.rc_context({"pdf.fonttype": 42, "text.usetex": False, "text.parse_math": False}),
        PdfPages(content, metadata={"Title": title, "CreationDate": None}) as pages,
    ):
        for number, sheet in enumerate(sheets, 1):
            figure = Figure(figsize=INCHES)
            foot = f"{title}, page {number} of {len(sheets)}"
            # Both weights are equally wide and high: each is drawn where the other one leaves room.
            plain = "\n".join("" if is_bold else text for text, is_bold in sheet)
            bold = "\n".join(text if is_bold else "" for text, is_bold in sheet)
            for height, text, weight in (
                (0.955, plain, "normal"),
                (0.955, bold, "bold"),
                (0.03, foot, "normal"),
            ):
                place = figure.text(0.07, height, text, va="top", size=7.2, linespacing=1.25)
                place.set_fontfamily(FONT)
                place.set_fontweight(weight)
            pages.savefig(figure)
    return content.getvalue()


def _lines(title: str, tables: Iterable[ReportTable]) -> Iterator[tuple[str, bool]]:
    """The lines of the report, and which of them are headings."""
    yield title, True
    for table in tables:
        yield "", False
        yield table.title.upper(), True
        yield from ((line, False) for line in _wrap(table.says))
        if not table.rows:
            yield "None.", False
            continue
        rows = (table.columns, *table.rows) if table.columns else table.rows
        widths = [
            min(SHORT, max((len(cell) for cell in column if len(cell) <= SHORT), default=0))
            for column in zip(*rows, strict=True)
        ]
        for row in rows:
            yield from ((line, row is table.columns) for line in _cells(row, widths))


def _cells(row: tuple[str, ...], widths: list[int]) -> list[str]:
    """A row of a table; what the last cell says goes on under itself."""
    row = tuple("".join(letter if letter.isprintable() else " " for letter in cell) for cell in row)
    *before, last = row
    head = "".join(
        cell.ljust(width) + "  " for cell, width in zip(before, widths[:-1], strict=True)
    )
    if len(head) > COLUMNS - SHORT:
        return _wrap(head) + _wrap(last, "    ", "    ")
    return _wrap(last, head, " " * len(head)) or [head.rstrip()]


def _wrap(text: str, first: str = "", others: str = "") -> list[str]:
    return textwrap.wrap(
        text,
        COLUMNS,
        initial_indent=first,
        subsequent_indent=others,
        break_on_hyphens=False,
    )
