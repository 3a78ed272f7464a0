"""What a run ends with: the pages or tables that it made, or why jobs failed."""

import re
from collections.abc import Iterable
from pathlib import Path

SHOWN = 3  # pages that are named
REPORT = Path("results/report")
TABLES = "results/tables/*.html"
FAILED_LOG = re.compile(r"^Logfile [^\n]+:\n={9,}\n(.*?)\n={9,}$", re.DOTALL | re.MULTILINE)  # as Snakemake shows one


def name_pages(folder: Path, since: float) -> str:
    """The report, else pages of pictures, else tables, made in a run's folder since then (seconds), in a line.

    "": none.
    """
    kinds = (folder / REPORT).glob("index.html"), (folder / REPORT / "scenes").glob("*.html"), folder.glob(TABLES)
    made = next(filter(None, (sorted(page for page in pages if _is_new(page, since)) for pages in kinds)), [])
    more = f" and {len(made) - SHOWN} more beside" if len(made) > SHOWN else ""
    return f"Open {', '.join(map(str, made[:SHOWN]))}{more}" if made else ""


def list_causes(logs: Iterable[str]) -> list[str]:
    """The lines in which failed jobs say why, each once, by the files of Snakemake's own log."""
    shown = [text for log in logs for text in FAILED_LOG.findall(Path(log).read_text("utf-8", errors="replace"))]
    ends = [[line for line in text.splitlines() if line.strip()] for text in shown]
    told = [next((line for line in lines[::-1] if line.startswith("error: ")), lines[-1]) for lines in ends if lines]
    return list(dict.fromkeys(told))


def _is_new(page: Path, since: float) -> bool:
    return page.is_file() and page.stat().st_mtime >= since
