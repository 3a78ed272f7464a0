"""What a run made, as the page of corrections shows it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.annotator.last_run import LastRun, find_picture, hang_on, read_last_run
from roomkin.plugins.report.album import SnapshotShards
from roomkin.stages.contracts import Cousins, Library, Objects, write_json
from roomkin.stages.contracts.cousins import Candidate, Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.geometry.frames import intrinsics_from_fov, look_at

MASK, TURN = 3, Orientation(yaw=3.0, distance=1.0)
CHEST = PlacedObject(
    id="chest_1", label="chest", asset="chest_9", category="chest", position=(3.0, 0.5, 0.4), yaw=0.3,
    size=(0.4, 0.6, 0.8),
)  # fmt: skip


@pytest.fixture
def made() -> LastRun:
    objects = Objects(
        scene="t",
        width=320,
        height=240,
        intrinsics=intrinsics_from_fov(320, 240, 0.9).tolist(),
        floor_from_camera=look_at([0, 0, 1.5], [3, 0, 0.4]).tolist(),
        walls=[],
        objects=[],
    )
    return LastRun(objects, {}, {}, {MASK: CHEST}, SnapshotShards([]))


def _faces(made: LastRun, before: tuple[float, float] = (0.0, 0.0), **said: object) -> np.ndarray:
    return np.array(made.faces(Correction.model_validate({"mask": MASK} | said), before))


def test_a_box_is_shown_where_its_thing_will_stand(made: LastRun) -> None:
    stands = _faces(made)
    assert stands.shape == (6, 4, 2)
    moved = _faces(made, nudge=(0.0, 0.2))  # to the left of the picture
    assert (moved[..., 0] < stands[..., 0] - 10).all()
    # the scene was made with the nudge: it stands there already
    np.testing.assert_array_equal(_faces(made, nudge=(0.0, 0.2), before=(0.0, 0.2)), stands)
    np.testing.assert_array_equal(_faces(made, nudge=(0.0, 0.3), before=(0.0, 0.1)), moved)
    back = _faces(made, before=(0.0, 0.2))  # taken back: it will stand there again
    assert (back[..., 0] > stands[..., 0] + 10).all()


def test_a_box_is_shown_as_large_as_its_thing_will_be(made: LastRun) -> None:
    stands, lower = _faces(made), _faces(made, size=(0.6, 0.4, 0.4))
    assert lower[..., 1].max() == stands[..., 1].max()  # it stands on the same floor
    assert lower[..., 1].min() > stands[..., 1].min() + 10


def test_a_box_is_shown_on_the_wall_at_which_a_person_says_that_its_thing_hangs(made: LastRun) -> None:
    """Seen 3 m away, as in a mirror at 2 m: it is as much smaller, and covers the same pixels."""
    assert made.objects is not None
    wall, (right, upper) = Wall(id="wall_1", normal=(-1, 0, 0), offset=-2.0, points=9), _faces(made)[-1].max(axis=0)
    left, lower = right - 40, upper - 60
    hung = hang_on(made.objects, wall, ((left, lower), (right, upper)), np.array(CHEST.size))
    assert hung is not None and hung.center[0] + hung.size[0] / 2 == pytest.approx(2.0)
    assert hung.size[0] / hung.size[1] == pytest.approx(CHEST.size[0] / CHEST.size[1])
    said = Correction.model_validate({"mask": MASK, "mounting": {"type": 1, "walls": [2]}})
    shown = np.array(made.faces(said, (0.0, 0.0), (wall, ((left, lower), (right, upper)))))
    low, high = shown.min(axis=(0, 1)), shown.max(axis=(0, 1))  # it comes before the wall, and so is seen as more
    assert (low < [left + 5, lower + 5]).all() and (high > [right - 5, upper - 5]).all()
    behind = Wall(id="wall_1", normal=(1, 0, 0), offset=-2.0, points=9)  # behind the camera
    assert hang_on(made.objects, behind, ((left, lower), (right, upper)), np.array(CHEST.size)) is None
    farther = wall.model_copy(update={"offset": -4.0})
    assert made.faces(said, (0.0, 0.0), (farther, ((left, lower), (right, upper)))) == _faces(made).tolist()


def test_a_model_of_unknown_size_is_shown_without_it(made: LastRun, tmp_path: Path) -> None:
    assert made.objects is not None
    write_json(tmp_path / "extraction/t/objects.json", made.objects)
    models = [
        LibraryEntry(id=name, category="chest", archive="a.zip", doors=0, drawers=0, checksum="c", size=size)
        for name, size in {"chest_1": (0.4, 0.6, 0.8), "chest_2": None}.items()
    ]
    write_json(tmp_path / "assets/library/library.json", Library(assets=models))
    assert read_last_run(tmp_path, "t", None, (320, 240)).sizes == {"chest_1": [0.6, 0.4, 0.8]}


def test_of_several_variants_the_default_is_shown(made: LastRun, tmp_path: Path) -> None:
    assert made.objects is not None
    write_json(tmp_path / "extraction/t/objects.json", made.objects)
    for variant in ("c-local", "default"):
        write_json(tmp_path / f"matching/{variant}/t/cousins.json", Cousins(scene="t", encoder="hog", objects=[]))
        (tmp_path / f"generation/{variant}/t").mkdir(parents=True)
        (tmp_path / f"generation/{variant}/t/scene_1.png").touch()
    ours = tmp_path / "generation/default/t/scene_1.png"
    assert read_last_run(tmp_path, "t", None, (320, 240)).picture == ours
    assert find_picture(tmp_path / "generation", "t") == ours


def test_models_are_shown_as_they_stand_others_as_the_first(made: LastRun) -> None:
    """A model of rank 2 has its own turn, a cousin without a scene that of matching, any other model that of rank 1."""
    names = ["first", "second", "third", "other"]
    compared: list[Any] = [Candidate(asset=name, category="chest", distance=1.0) for name in names]
    cousins = [
        Cousin(rank=rank, **one.model_dump(), orientation=TURN, orientations=[TURN])
        for rank, one in enumerate(compared[:3], 1)
    ]
    entry = ObjectCousins(id="chest_1", label="chest", by_distance=compared, cousins=cousins)
    asked: dict[str, float] = {}
    snapshots: Any = type("Views", (), {"picture": lambda _, asset, yaw: asked.update({asset: yaw})})()
    shown = replace(made, cousins={MASK: entry}, snapshots=snapshots)
    assert len(shown.models(MASK)) == 4 and set(asked.values()) == {3.0}, "there is no scene"
    replace(shown, views={MASK: {"first": 0.1, "second": 0.2}}).models(MASK)
    assert asked == {"first": 0.1, "second": 0.2, "third": 3.0, "other": 0.1}
