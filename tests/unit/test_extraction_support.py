"""What carries an object: level tops under noise, pictures above furniture, what would be squeezed flat."""

import numpy as np
import pytest

from stages.config.extraction import ExtractionConfig
from stages.contracts.objects import USUAL_ERROR, Wall
from stages.extraction.clouds import level_height
from stages.extraction.mounting import collapsed, placement
from stages.extraction.visibility import DepthView
from stages.extraction.walls import gap_to
from stages.geometry.boxes import UprightBox
from stages.geometry.minimum_box import minimum_box

LOOKING_ALONG_X = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 1.5], [0, 0, 0, 1.0]])
WALL = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=100)


def level(cloud: np.ndarray, distance: float) -> float | None:
    return level_height(cloud, cloud, minimum_box(cloud, 0.01), USUAL_ERROR.at(distance), distance, ExtractionConfig())


def _table(rng: np.random.Generator, shadows: int) -> np.ndarray:
    """A top at 0.5 m, its legs, and points that the depth camera put higher at the edges of a box on it."""
    top, legs = rng.uniform(-0.5, 0.5, (4000, 3)), rng.uniform(-0.5, 0.5, (600, 3))
    top[:, 2], legs[:, 2] = 0.5 + rng.normal(0, 0.004, 4000), rng.uniform(0, 0.5, 600)
    raised = rng.uniform(-0.1, 0.1, (shadows, 3))
    raised[:, 2] = rng.uniform(0.55, 0.6, shadows)
    return np.concatenate([top, legs, raised])


@pytest.mark.parametrize("shadows", [0, 200])
def test_a_table_is_as_high_as_most_of_its_top(shadows: int) -> None:
    cloud = _table(np.random.default_rng(0), shadows)
    assert level(cloud, 1.0) == pytest.approx(0.5, abs=0.005)
    if shadows:
        assert np.quantile(cloud[:, 2], 0.99) > 0.56  # what the quantile makes of it


def test_a_seat_under_a_back_is_no_top() -> None:
    rng = np.random.default_rng(0)
    seat, back = rng.uniform(0, 0.5, (3000, 3)), rng.uniform(0, 0.5, (1000, 3))
    seat[:, 2], back[:, 2] = 0.45, rng.uniform(0.45, 0.9, 1000)
    assert level(np.concatenate([seat, back]), 3.0) is None


def test_a_neck_above_a_shoulder_counts() -> None:
    """A bottle seen from above behind a thing that hides most of its body: nine tenths of what is seen is shoulder."""
    rng = np.random.default_rng(0)
    body, shoulder, neck = (rng.uniform(0, 0.16, (count, 3)) for count in (100, 1000, 80))
    body[:, 2], neck[:, 2] = rng.uniform(0, 0.12, 100), rng.uniform(0.12, 0.3, 80)
    shoulder[:, 2] = rng.normal(0.12, 0.003, 1000)
    seen = np.concatenate([body, shoulder])
    assert level(seen, 1.0) == pytest.approx(0.12, abs=0.005)
    assert level(np.concatenate([seen, neck]), 1.0) is None


def test_nothing_stands_on_what_is_slender() -> None:
    """The loop of a bottle, 4 cm above its lid; farther away what is above a level may be noise."""
    rng = np.random.default_rng(0)
    body, lid, loop = (rng.uniform(0, 0.08, (count, 3)) for count in (600, 300, 60))
    body[:, 2], loop[:, 2] = rng.uniform(0, 0.22, 600), rng.uniform(0.22, 0.26, 60)
    lid[:, 2] = rng.normal(0.22, 0.003, 300)
    bottle = np.concatenate([body, lid, loop])
    assert level(bottle, 1.0) is None
    assert level(bottle, 2.5) == pytest.approx(0.22, abs=0.01)
    assert level(bottle * [3, 3, 1], 1.0) == pytest.approx(0.22, abs=0.01)


def test_a_front_has_no_level() -> None:
    front = np.random.default_rng(0).uniform(0, 1, (4000, 3))
    assert level(front, 3.0) is None


@pytest.mark.parametrize(("hidden_up_to", "mounting"), [(1.425, 1), (1.6, 3)])
def test_a_picture_above_furniture_hangs(hidden_up_to: float, mounting: int) -> None:
    """A picture at the wall x = 4, 1.5 to 1.9 m high; something 2 m away hides what is below, its lower edge or not."""
    v, u = np.mgrid[:240, :320]
    rise = -(v - 120) / 200.0  # of the rays, per metre
    depth = np.where(1.5 + 2 * rise <= hidden_up_to, 2.0, 4.0).astype(np.float32)
    view = DepthView(depth, np.array([[200.0, 0, 160], [0, 200.0, 120], [0, 0, 1]]), LOOKING_ALONG_X, USUAL_ERROR)
    own = (np.abs(u - 160) < 15) & (1.5 + 4 * rise > 1.5) & (1.5 + 4 * rise < 1.9) & (depth == 4)
    picture = UprightBox([3.97, 0, 1.7], [0.05, 0.6, 0.4], 0.0)
    assert placement(picture, {}, [], [WALL], view, own, ExtractionConfig()).mounting.type == mounting


@pytest.mark.parametrize(("seen", "mounting"), [(1.5, 1), (1.45, 3)])
def test_a_picture_just_above_a_lamp_far_away_hangs(seen: float, mounting: int) -> None:
    """At 8 m, a lamp 1.42 m high before it: 8 cm are four pixels of wall between the two; 3 cm are none that counts."""
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-8.0, points=100)
    v, u = np.mgrid[:240, :320]
    height, side = 1.5 - (v - 120) / 400.0 * 8, (u - 160) / 400.0 * 8
    own = (np.abs(side) < 0.3) & (height > seen) & (height < 1.9)
    lamp = (np.abs(side) < 0.2) & (height < 1.42)
    view = DepthView(
        np.where(lamp, 7.7, 8.0).astype(np.float32),
        np.array([[400.0, 0, 160], [0, 400.0, 120], [0, 0, 1]]),
        LOOKING_ALONG_X,
        USUAL_ERROR,
    )
    picture = UprightBox([7.95, 0, (seen + 1.9) / 2], [0.3, 0.6, 1.9 - seen], 0.0)
    stand = UprightBox([7.8, 0, 0.71], [0.4, 0.4, 1.42], 0.0)
    placed = placement(picture, {"stand": stand}, [stand], [wall], view, own, ExtractionConfig())
    assert placed.mounting.type == mounting
    assert placed.box.bottom == pytest.approx(seen if mounting == 1 else 1.42)


@pytest.mark.parametrize(
    (
        "distance",
        "height",
        "left",
    ),  # of a box, a plate, a box above it all the same; nearer depth errs less: it is in it
    [(3.5, 0.09, 0.01), (3.5, 0.03, 0.01), (3.5, 0.25, 0.15), (2.0, 0.09, 0.09)],
)
def test_what_is_squeezed_flat_is_told(distance: float, height: float, left: float) -> None:
    empty = DepthView(np.full((9, 9), 9.0, np.float32), np.diag([9.0, 9.0, 1.0]), LOOKING_ALONG_X, USUAL_ERROR)
    table = UprightBox([distance, 0, 0.3], [1, 1, 0.6], 0.0)  # found 10 cm too high
    seen = UprightBox([distance, 0, 0.5 + height / 2], [0.2, 0.2, height], 0.0)
    placed = placement(seen, {"table": table}, [table], [], empty, np.zeros((9, 9), bool), ExtractionConfig())
    assert placed.box.size[2] == pytest.approx(left)
    assert collapsed(seen, placed, 0.06) == (left == 0.01 and height == 0.09)


@pytest.mark.parametrize(("bottom", "support"), [(0.62, "table"), (1.0, "unnamed")])
def test_a_told_box_above_all_that_was_named_stands_on_something_else(bottom: float, support: str) -> None:
    empty = DepthView(np.full((9, 9), 9.0, np.float32), np.diag([9.0, 9.0, 1.0]), LOOKING_ALONG_X, USUAL_ERROR)
    table = UprightBox([3, 0, 0.3], [1, 1, 0.6], 0.0)
    told = UprightBox([3, 0, bottom + 0.1], [0.2, 0.2, 0.2], 0.0)
    placed = placement(told, {"table": table}, [table], [], empty, np.zeros((9, 9), bool), ExtractionConfig(), True)
    assert placed.support == support and placed.box.bottom == pytest.approx(bottom)


def test_the_gap_behind_a_box_that_is_a_little_turned_is_as_wide_as_its_rear() -> None:
    gap = gap_to(UprightBox([3, 0, 0.5], [0.6, 0.8, 1.0], 0.2), WALL)
    assert gap.along[1] - gap.along[0] == pytest.approx(0.8 * np.cos(0.2), abs=1e-6)
