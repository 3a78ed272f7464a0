"""Command `scenes`: Table 2 and Figure 6, from the scores and pictures of generated scenes."""

from pathlib import Path

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_options
from roomkin.stages.contracts.policies import SceneScore
from roomkin.stages.tables import table2
from roomkin.stages.tables.figures import figure6, save, style
from roomkin.stages.tables.rows import ONE_SCENE, published_scenes, read_rows
from roomkin.stages.tables.table2 import scenes_table
from roomkin.stages.tables.text import write


def parse_comparisons(items: tuple[str, ...], flag: str = "--comparisons") -> dict[tuple[str, str], Path]:
    """'room_1/b=picture.png' -> {('room_1', 'b'): picture.png}; the part after the slash may be left out."""
    pictures = {}
    for item in items:
        name, sign, path = item.partition("=")
        if not (name and sign and path):
            what, fix = f"'{item}' is not room=picture.", "write e.g. room_1=picture.png"
            raise InputError(flag, what, fix, code="E-PICTURE-NAME")
        room, _, variant = name.partition("/")
        pictures[room, variant] = Path(path)
    return pictures


def run(
    *,
    out: Path,
    figures: Path | None = None,
    scores: tuple[Path, ...] = (),
    comparisons: tuple[str, ...] = (),
    published: Path = Path("report/published"),
    options: str = "",
) -> None:
    """Write table2 (.csv, .html, .tex) into `out`, and figure6 (.svg, .png) into `figures`.

    Args:
        out: folder to write the tables into.
        figures: folder to write the figure into; that of the tables if left out.
        scores: scores.csv files of generated scenes.
        comparisons: pictures of Figure 6, as room=picture or room/variant=picture.
        published: folder with the paper's values, table2.csv.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    pictures = parse_comparisons(comparisons)
    rows = read_rows(SceneScore, scores, ONE_SCENE)
    scenes = table2.build(rows, published_scenes(published), settings)
    write(out, "table2", scenes, [scenes_table(scenes, settings)])
    with style():
        save(figure6(pictures, list(settings.scenes), settings.picture_width), figures or out, "figure6")
