"""What a run ends with: the pages that it made, or why jobs failed."""

import re
from collections.abc import Iterable
from pathlib import Path

SHOWN = 3  # pages that are named
REPORT = Path("results/report")
FAILED_LOG = re.compile(r"^Logfile [^\n]+:\n={9,}\n(.*?)\n={9,}$", re.DOTALL | re.MULTILINE)  # as Snakemake shows one


def name_pages(folder: Path, since: float) -> str:
    """The report, or else the pages of pictures, made in a run's folder since then (seconds), in a line; "": none."""
    report, *pages = [folder / REPORT / "index.html", *sorted((folder / REPORT / "scenes").glob("*.html"))]
    made = [page for page in ([report] if _is_new(report, since) else pages) if _is_new(page, since)]
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
