"""What the core must know of this package."""

import shlex
from collections.abc import Iterator
from typing import Any

from pydantic import Field

from plugins.eyes.weights import ALL, is_there
from plugins.single_view.config import DrawOptions, SingleViewSection
from stages.config.mistakes import Mistake
from stages.config.packages import Package


def find_mistakes(config: Any) -> Iterator[Mistake]:
    """Weights that lack for pictures without depth, and heights that are none."""
    for name, height in config.single_view.heights.items():
        if not 0.01 <= height <= 100:
            yield Mistake(f"single_view.heights.{name}", f"is {height} m", "metres, from 0.01 to 100", "E-CONFIG-VALUE")
    if not config.packages["inputs"]:
        return
    pictures = config.experiment.pictures
    lacking = [weights.name for weights in ALL if not is_there(weights)]
    if pictures and lacking and not config.photo.asks_networks() and "single_view" not in config.stages:
        key = "image" if config.image else "experiment.inputs"
        mend = "make weights, or without weights draw it: python -m plugins.annotator annotate"
        what = f"is a picture without depth, and there are no weights ({', '.join(lacking)})"
        yield Mistake(key, what, f"{mend} {shlex.quote(pictures[0])}", "E-CONFIG-FILE")


PACKAGE = Package(
    section="single_view",
    sections={
        "single_view": (
            SingleViewSection,
            Field(SingleViewSection(), description="From one photograph without depth to a drawing (2.1)."),
        )
    },
    commands={"draw": DrawOptions},
    mistakes=find_mistakes,
)
