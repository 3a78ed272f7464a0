"""Random rooms of procedural models: the same every time, things stand on what they say, rays see them."""

import numpy as np
import pytest

from benchmarks.name_training.pictures import BACKGROUND, GROUND, NOTHING, TrainingPicture, pictures_in
from benchmarks.name_training.rooms import FLOOR, WALL, MadeRoom, Pool, furnish, make_pool
from roomkin.stages.geometry.frames import back_project, transform_points


@pytest.fixture(scope="module")
def pool() -> Pool:
    return make_pool(1, 0)


@pytest.fixture(scope="module")
def rooms(pool: Pool) -> list[MadeRoom]:
    return [furnish(pool, np.random.default_rng(seed)) for seed in range(12)]


def test_rooms_are_the_same_every_time(pool: Pool, rooms: list[MadeRoom]) -> None:
    again = furnish(pool, np.random.default_rng(3))
    assert [thing.position.tolist() for thing in again.things] == [thing.position.tolist() for thing in rooms[3].things]


def test_things_stand_on_what_carries_them(rooms: list[MadeRoom]) -> None:
    carried = 0
    for room in rooms:
        for thing in room.things:
            if thing.support == FLOOR:
                assert thing.position[2] == 0.0
            elif thing.support == WALL:
                corners = np.array(thing.plan.exterior.coords)
                edge = np.abs(np.concatenate([corners, room.size[:2] - corners])).min()
                assert edge == pytest.approx(0.0, abs=1e-6)
            else:
                base = room.things[thing.support - 2]
                carried += 1
                assert base.position[2] < thing.position[2] <= base.box.top + 1e-6
    assert carried > 20


@pytest.fixture(scope="module")
def pictures(rooms: list[MadeRoom]) -> list[TrainingPicture]:
    return [picture for seed, room in enumerate(rooms) for picture in pictures_in(room, 2, np.random.default_rng(seed))]


def test_the_ground_is_level_and_things_are_above_it(pictures: list[TrainingPicture]) -> None:
    tables = 0
    for picture in pictures:
        height = transform_points(picture.frame, back_project(picture.depth, picture.intrinsics))[..., 2]
        ground = picture.owner == GROUND
        assert np.abs(height[ground]).max(initial=0.0) < 0.021
        things = (picture.owner > BACKGROUND) & (picture.owner < NOTHING)
        assert height[things].min(initial=0.0) > -0.03
        tables += bool((height[picture.depth > 0] < -0.2).mean() > 0.02)
    assert 0 < tables < len(pictures)
