"""Figure 6: as large as its panels, a room that was not run is a line."""

from pathlib import Path

import pytest
from PIL import Image

from roomkin.stages.tables.figures import figure6


@pytest.mark.parametrize(
    ("rooms", "variants", "size"),
    [
        (["room_1", "room_2"], ["b"], (6.7, 6 * 0.5 + 0.18 + 0.3)),
        (["room_1"], ["a", "b"], (9.1, 4.2 * 0.25 + 0.09 + 0.3)),
        ([], ["b"], (6.7, 6 * 0.05 + 0.09 + 0.3)),
    ],
)
def test_a_figure_is_as_large_as_its_panels(
    rooms: list[str], variants: list[str], size: tuple[float, float], tmp_path: Path
) -> None:
    Image.new("RGB", (80, 20)).save(tmp_path / "wide.png")
    figure = figure6({(room, name): tmp_path / "wide.png" for room in rooms for name in variants}, rooms or ["r"], 80)
    assert figure.get_size_inches().tolist() == pytest.approx(size)
