"""Labels on pictures: as large on small pictures as on large ones, in the picture, beside each other."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.plugins.pictures.look import draw_side_by_side
from roomkin.plugins.pictures.objects import WIDTH, _caption, draw_overview
from roomkin.plugins.pictures.snapshots import TILE, contact_sheet
from roomkin.stages.contracts.objects import Box, Mounting, Objects, SceneObject, Wall
from roomkin.stages.geometry.frames import intrinsics_from_fov, look_at

LABEL = (20, 20, 20)


def overview(width: int, *parts: tuple[float, float, float, float]) -> NDArray[Any]:
    """What is drawn of a grey picture with objects in its parts (left, top, right, bottom of 0 to 1)."""
    height = width * 3 // 4
    masks, items = np.zeros((height, width), np.uint16), []
    for mask, part in enumerate(parts, start=1):
        x0, y0, x1, y1 = (round(share * side) for share, side in zip(part, (width, height) * 2, strict=True))
        masks[y0:y1, x0:x1] = mask
        items.append(
            SceneObject(
                id=f"wall_cabinet_{mask}", label="wall cabinet", mask=mask, pixels=(x0, y0, x1, y1), doors=2,
                mounting=Mounting(type=1, walls=["wall_1"]),
                    box=Box(center=(3, 0, 1), size=(0.3, 0.3, 0.3), yaw=0),
            )
        )  # fmt: skip
    objects = Objects(
        scene="t", width=width, height=height, intrinsics=intrinsics_from_fov(width, height, 0.9).tolist(),
        floor_from_camera=look_at([0, 0, 1.5], [3, 0, 0.4]).tolist(), objects=items,
        walls=[Wall(id="wall_1", normal=(-1, 0, 0), offset=-4, points=9)],
    )  # fmt: skip
    return np.asarray(draw_overview(np.full((height, width, 3), 200, np.uint8), masks, objects)).astype(int)


def labels(drawn: NDArray[Any]) -> NDArray[Any]:
    """Left, top, width and height of every label."""
    found = cv2.connectedComponentsWithStats((drawn == LABEL).all(axis=2).astype(np.uint8), connectivity=4)[2][1:]
    return found[found[:, cv2.CC_STAT_WIDTH] > 100][:, :4]


@pytest.mark.parametrize("width", [320, 4000])
def test_what_was_found_is_as_readable_in_a_small_picture_as_in_a_large_one(width: int) -> None:
    part = (0.3, 0.4, 0.6, 0.8)
    drawn, usual = overview(width, part), overview(640, part)
    assert drawn.shape == usual.shape == (WIDTH * 3 // 4, WIDTH, 3)
    assert np.abs(drawn - usual).mean() < 1  # of 255
    ((_, _, _, height),) = labels(drawn)
    assert height * 560 / WIDTH > 22  # two lines, where a page shows it 560 pixels wide


def test_labels_lie_in_the_picture_and_cover_no_other() -> None:
    top, below = (0.5, 0.0, 0.7, 0.3), (0.52, 0.02, 0.72, 0.5)
    drawn = overview(640, top, below, (0.95, 0.5, 1.0, 0.7))
    found = labels(drawn)
    assert len(found) == 3 and len({tuple(one[2:]) for one in found}) == 1  # all are whole
    left, upper, width, _ = found.T
    assert (left >= 0).all() and (upper >= 0).all() and (left + width <= WIDTH).all()


@pytest.mark.parametrize("width", [320, 4000])
def test_titles_grow_with_the_pictures_beside_each_other(width: int) -> None:
    picture = np.full((width * 3 // 4, width, 3), 255, np.uint8)
    sheet = np.asarray(draw_side_by_side([("input", picture), ("rank 1", picture)]))
    rows = np.nonzero((sheet < 128).all(axis=2).any(axis=1))[0]
    assert 0.03 < (rows.max() - rows.min()) / width < 0.08


def test_names_of_models_can_be_read_where_a_page_shows_the_sheet() -> None:
    sheet = np.asarray(contact_sheet(np.full((1, 1, 64, 64, 3), 255, np.uint8), ["wall_cabinet_04"]))
    rows, columns = np.nonzero((sheet < 128).all(axis=2))
    assert rows.max() - rows.min() >= 12 and columns.max() < TILE


def test_a_label_says_in_words_how_a_thing_is_held() -> None:
    item = SceneObject(id="wall_cabinet_1", label="wall cabinet", mask=1, points=9, doors=1, drawers=2)
    held = [Mounting(type=1, walls=["wall_1"]), Mounting(type=2), Mounting(type=3, walls=["wall_1", "wall_2"])]
    assert [_caption(item.model_copy(update={"mounting": how})) for how in held] == [
        f"wall cabinet 1\n{words}, 1 door, 2 drawers"
        for words in ("hangs on wall 1", "stands free", "stands at wall 1 and wall 2")
    ]
