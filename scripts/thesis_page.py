"""Put the figures and tables of `adc-bench reproduce thesis --out DIR` into docs/thesis.md.

Usage: python scripts/thesis_page.py DIR
"""

import shutil
import sys
from pathlib import Path

import msgspec
from PIL import Image

from adc_bench.reproduce.page import figure_text
from adc_bench.reproduce.tables import Table, Tables

DOCS = Path(__file__).resolve().parents[1] / "docs"
COLOURS = 64  # enough for figures, in a third of the bytes
BEGIN, END = "<!-- tables: by scripts/thesis_page.py -->", "<!-- end of the tables -->"


def main() -> None:
    made = Path(sys.argv[1])
    pictures = DOCS / "pictures" / "thesis"
    shutil.rmtree(pictures, ignore_errors=True)
    pictures.mkdir(parents=True)
    for figure in sorted((made / "figures").glob("*.png")):
        Image.open(figure).convert("RGB").quantize(COLOURS).save(pictures / figure.name, optimize=True)
    tables = msgspec.json.decode((made / "tables.json").read_bytes(), type=Tables).tables
    page = DOCS / "thesis.md"
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    after = rest.split(END)[1]
    body = "\n".join(markdown(table) for table in tables)
    page.write_text(f"{before}{BEGIN}\n\n{body}\n{END}{after}", encoding="utf-8")


def markdown(table: Table) -> str:
    rows = "\n".join(
        f"| {row.what} | {figure_text(row.thesis)} | {figure_text(row.ours)} | {row.unit} |" for row in table.rows
    )
    return f"### {table.title}\n\n{table.note}\n\n| | thesis | ours | |\n|---|---|---|---|\n{rows}\n"


if __name__ == "__main__":
    main()
