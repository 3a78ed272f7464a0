"""What names CLIP's embeddings: rooms of things of every kind, and the layer that learns from them."""

import numpy as np
import pytest
import torch

from benchmarks.name_training.looks import share_out_of_fold, train_head
from benchmarks.name_training.outlines import NONE, OWN, TrainingOutlines, join, vary
from benchmarks.name_training.rooms import make_pool
from benchmarks.name_training.solids import JUNK
from benchmarks.open_rooms import crowd, packs, rooms, views
from roomkin.plugins.furniture.catalogue import CATEGORIES

NAMES = ["mug", "sofa", NONE]


def draw(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Embeddings around one of three directions, and which (N, 3) it is."""
    rng = np.random.default_rng(seed)
    number = rng.integers(3, size=count)
    looks = np.eye(512)[number] + rng.normal(0, 0.02, (count, 512))
    return (looks / np.linalg.norm(looks, axis=1, keepdims=True)).astype(np.float32), np.eye(3, dtype=bool)[number]


def test_the_layer_learns_names_and_any_of_several_right_ones_will_do() -> None:
    looks, right = draw(90, 0)
    right[:20] |= right[:20][:, [1, 2, 0]]  # two names are right
    others, truth = draw(60, 1)
    share = train_head(looks, right)(torch.from_numpy(others)).softmax(dim=1).detach().numpy()
    assert (share.argmax(axis=1) == truth.argmax(axis=1)).all()


def test_a_model_is_named_by_heads_that_have_not_seen_it() -> None:
    looks, right = draw(80, 2)
    seen = TrainingOutlines(
        np.array([f"model_{k}" for k in range(80)]), np.array(["mug"] * 80), np.full(80, OWN), right, looks
    )
    lied = right.copy()
    lied[0] = np.roll(right[0], 1)  # the only outline of its model: nobody can have learnt the lie
    share = share_out_of_fold(seen, lied)
    assert share.sum(axis=1) == pytest.approx(1) and share[0].argmax() == right[0].argmax()


def test_what_is_right_is_told_by_kinds() -> None:
    looks, said = np.zeros((2, 512), np.float32), np.zeros((2, 3, 3), np.float32)
    one = TrainingOutlines(np.array(["a", ""]), np.array(["sofa", NONE]), np.array([0, 1]), said, looks)
    pipes = one._replace(kind=np.array(["pipes", "mug"]))
    found = [NAMES[each.argmax()] for each in join([one, pipes]).right(NAMES)]
    assert found == ["sofa", NONE, NONE, "mug"]


def test_a_picture_of_another_camera_is_much_the_same() -> None:
    rgb = np.random.default_rng(0).integers(60, 200, (40, 50, 3), np.uint8)
    varied = [vary(rgb, np.random.default_rng(seed)) for seed in range(4)]
    assert all(each.shape == rgb.shape and each.dtype == np.uint8 for each in varied)
    assert len({each.tobytes() for each in varied}) == 4


@pytest.mark.parametrize("seed", range(3))
def test_a_crowded_room_holds_things_of_ours_and_others(seed: int) -> None:
    rng = np.random.default_rng(seed)
    models = [model for model in crowd.own_models() if model.name in "01"]
    room = rooms.furnish(rooms.CROWD, models, views.top_of, rng, crowd.plan_crowd(rng))
    assert len(room.things) > 5
    assert {thing.model.kind for thing in room.things} <= {*CATEGORIES, *JUNK}
    assert all(thing.box.top <= rooms.HEIGHT for thing in room.things)


def test_own_models_are_in_their_colors_and_the_same_each_time() -> None:
    sofa, again = (next(one for one in crowd.own_models() if one.kind == "sofa") for _ in range(2))
    assert sofa.id == "ours_sofa_0" and sofa.size == again.size and sofa.size[1] > 0.8
    assert all(0 <= value <= 1 for part in sofa.parts for value in part.color)
    pipes = next(one for one in crowd.own_models() if one.kind == "pipes")
    assert min(pipes.size) > 0 and packs.kinds()["pipes"].sensible == []


def test_kinds_of_all_places_are_known() -> None:
    places = crowd.kinds_by_place()
    assert {"a_door", "picture"} <= set(places["wall"]) and "sofa" in places["floor"] and "mug" in places["top"]
    assert set(CATEGORIES) <= {name for some in places.values() for name in some}


def test_rooms_to_learn_from_are_crowds_too_and_others_are_not() -> None:
    assert sum("crowd" in name for name in rooms.names("work", 1)) == rooms.CROWDS
    assert not any("crowd" in name for name in rooms.names("work"))


def test_without_packs_the_pool_is_our_own() -> None:
    assert {len(some) for some in make_pool(1, 0).values()} == {1}
