"""The network that ships cuts pictures of rooms that it never saw; labels follow the edges of the whole picture."""

import hashlib
from pathlib import Path

import numpy as np
import pytest

from plugins.segmenter.network import WEIGHTS
from plugins.segmenter.segment import cut, find_top
from plugins.segmenter.training.pictures import BACKGROUND, GROUND, NOTHING, Picture, draw_pictures, make_pool
from plugins.segmenter.upsampling import upsample_labels

DIGEST = "26737ea2fed0c9b6e36682b3a1bb875fbaa720588935fe111fa45be4690fec92"
MOST_BYTES = 8_000_000
MAX_TILT = 75.0


@pytest.fixture(scope="module")
def pictures() -> list[Picture]:
    """Rooms of other models than those that the network learnt from, exact depth."""
    pool = make_pool(1, 12345)
    pool["rug"] = pool["sheet"]  # to depth, and to this network, a rug is floor
    return draw_pictures(pool, 6, (320, 240), 2, np.random.default_rng(6))


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    """Intersection over union."""
    return float((one & other).sum() / max(1, (one | other).sum()))


def test_the_weights_are_those_that_were_measured() -> None:
    content = Path(WEIGHTS).read_bytes()
    assert hashlib.sha256(content).hexdigest() == DIGEST and len(content) < MOST_BYTES


@pytest.mark.parametrize("coloured", [True, False])
def test_rooms_come_apart_into_floor_and_things(pictures: list[Picture], coloured: bool) -> None:
    floors, large = [], []
    for picture in pictures:
        rgb = picture.rgb if coloured else np.full_like(picture.rgb, 128)
        pieces = cut(picture.depth, rgb, picture.intrinsics, MAX_TILT)
        assert pieces is not None and set(np.unique(pieces.values)) <= {0, *pieces.things, pieces.floor, *pieces.walls}
        if (picture.owner == GROUND).mean() > 0.05:
            floors.append(overlap(pieces.values == pieces.floor, picture.owner == GROUND))
        for thing in range(BACKGROUND + 1, NOTHING):
            if (picture.owner == thing).mean() > 0.05:
                large.append(max(overlap(pieces.values == value, picture.owner == thing) for value in pieces.things))
    assert len(floors) > 3 and np.median(floors) > 0.7
    assert len(large) > 3 and np.mean(np.array(large) > 0.5) > (0.6 if coloured else 0.5), large


def test_nothing_level_is_no_room() -> None:
    rows = np.arange(120)[:, None] + 0 * np.arange(160)
    depth = (2.0 + 0.5 * np.sin(rows / 3.0)).astype(np.float32)
    lens = np.array([[150.0, 0, 80], [0, 150, 60], [0, 0, 1]])
    assert cut(np.zeros_like(depth), np.zeros((120, 160, 3), np.uint8), lens, MAX_TILT) is None


def test_labels_follow_the_edges_of_the_picture() -> None:
    """An edge that runs through the small pixels comes out where depth, or colour, has it."""
    exact = np.broadcast_to(np.where(np.arange(64) < 27, 1, 2), (48, 64)).astype(np.uint16)
    small = exact[::4, 1::4]
    by_pixel = np.repeat(np.repeat(small, 4, axis=0), 4, axis=1)
    depth, grey = np.where(exact == 1, 2.0, 2.5).astype(np.float32), np.full((48, 64, 3), 90, np.uint8)
    flat, colour = np.full_like(depth, 2.0), np.repeat(np.where(exact == 1, 40, 200)[..., None], 3, 2).astype(np.uint8)
    assert (by_pixel != exact).any()
    assert (upsample_labels(small, depth, grey) == exact).all()
    assert (upsample_labels(small, flat, colour) == exact).all()
    assert (upsample_labels(small, 0 * flat, grey) > 0).all()  # no depth, no colour: still labels


def test_a_top_is_a_level_part_at_one_height() -> None:
    heights = np.where(np.arange(40)[:, None] < 20, 0.75, 0.2) + np.zeros((40, 40))
    piece = np.ones((40, 40), bool)
    assert find_top(heights, piece, heights > 0.5) == pytest.approx(0.75)
    assert find_top(heights, piece, np.zeros_like(piece)) is None
