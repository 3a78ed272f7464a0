"""Command `overview`: every scene of a run as a row of one sortable page."""

from pathlib import Path

from roomkin.plugins.report.page.overview import RunFolders, count_failures, row
from roomkin.plugins.report.report import link_there_and_back, render
from roomkin.stages.contracts.files import write_text
from roomkin.stages.tables.rows import sort_key
from roomkin.stages.tables.text import NOT_RUN


def run(
    *,
    scenes: tuple[str, ...],
    variant: str,
    out: Path,
    pages: tuple[Path, ...] = (),
    results: Path = Path("results"),
    logs: Path = Path("logs"),
) -> None:
    """Write the page: pictures of input and rank 1, what failed and why, doubts. The page is one file.

    The page of an earlier run that failed (`b.failed.html` for `b.html`) is removed.

    Args:
        scenes: their names.
        variant: the variant of matching that is shown.
        out: the HTML file.
        pages: pages of scenes, <scene>.html, to which rows link.
        results: folder of the stages' results, in the fixed layout.
        logs: folder of the logs; a scene that stopped shows the last line of its log.
    """
    links = {path.stem: link_there_and_back(path, out) for path in pages}
    folders = RunFolders(results, logs, variant)
    rows = [row(scene, folders, links.get(scene, "")) for scene in sorted(scenes, key=sort_key)]
    reasons = [one.stopped.reason for one in rows if one.stopped]
    counts = {"waiting": reasons.count(NOT_RUN), "stopped": len(reasons) - reasons.count(NOT_RUN)}
    counts["made"] = len(rows) - len(reasons)
    text = render(
        "overview.html.jinja",
        ("sort.js", "back.js"),
        rows=rows,
        variant=variant,
        common=count_failures(rows),
        furnished=any((results / "scenes" / scene / "input").is_dir() for scene in scenes),
        **counts,
    )
    write_text(out, text)
    out.with_suffix(".failed.html").unlink(missing_ok=True)
    print("{}: {made} of {} scenes were made, {stopped} stopped, {waiting} not run".format(out, len(rows), **counts))
