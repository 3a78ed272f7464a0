"""What a run ends with: the pages that it made."""

from pathlib import Path

SHOWN = 3  # pages that are named
REPORT = Path("results/report")


def name_pages(folder: Path, since: float) -> str:
    """The report, or else the pages of pictures, made in a run's folder since then (seconds), in a line; "": none."""
    report, *pages = [folder / REPORT / "index.html", *sorted((folder / REPORT / "scenes").glob("*.html"))]
    made = [page for page in ([report] if _is_new(report, since) else pages) if _is_new(page, since)]
    more = f" and {len(made) - SHOWN} more beside" if len(made) > SHOWN else ""
    return f"Open {', '.join(map(str, made[:SHOWN]))}{more}" if made else ""


def _is_new(page: Path, since: float) -> bool:
    return page.is_file() and page.stat().st_mtime >= since
