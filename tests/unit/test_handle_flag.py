"""What protrudes from a front is found in the cloud, and fronts are moved under their handles."""

import numpy as np
import pytest
import torch
from torch import Tensor

from roomkin.stages.contracts.policy_config import PolicyConfig, TaskConfig
from roomkin.stages.contracts.trained import TrainingStore
from roomkin.stages.policies.base import make_policy, make_rollout_policy
from roomkin.stages.policies.handle_points import find_handle_middles, offsets_to_handle, segment_handles
from roomkin.stages.training import augment
from roomkin.stages.training.augment import (
    Batch,
    hide_handles,
    make_batch,
    move_fronts,
    put_handle_first,
    vary_handles,
    widen_grips,
)
from roomkin.stages.training.dataset import DemonstrationSet, find_still, segment_episodes, steps_until_release
from tests.unit.clouds import cabinet


@pytest.fixture
def all_fronts(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Every front moves, handles are not stretched."""
    monkeypatch.setattr(augment, "FRONT_PROBABILITY", 1.0)
    monkeypatch.setattr(augment, "HANDLE_SCALE", (1.0, 1.0))
    return monkeypatch


@pytest.mark.parametrize("angle", [0.0, 0.4, -0.7])
@pytest.mark.parametrize("knob", [False, True])
def test_the_handle_is_marked_and_nothing_else(angle: float, knob: bool) -> None:
    cloud = cabinet(angle, knob=knob)
    marked, planes = segment_handles(cloud)
    assert (marked[0, :, 3] == -1).nonzero().squeeze(1).tolist() == list(range(340, 352))
    assert torch.equal(marked[..., :3], cloud[..., :3]) and (marked[0, -2:, 3] == 1).all()
    assert planes[0].tolist() == pytest.approx([-np.cos(angle), -np.sin(angle), -0.7 * np.cos(angle)], abs=1e-3)


def test_points_above_each_other_say_nothing_of_the_front() -> None:
    """An edge of the front is seen more often than the rest; a panel behind it stands across."""
    cloud = cabinet()
    cloud[0, :40, :2] = cloud[0, 0, :2]
    along = torch.stack([torch.linspace(0.7, 1.1, 200), torch.full((200,), 0.2), torch.full((200,), 0.4)], dim=1)
    panel = torch.cat([along, torch.zeros((200, 1))], dim=1)
    marked, planes = segment_handles(torch.cat([cloud, panel[None]], dim=1))
    assert (marked[0, :, 3] == -1).nonzero().squeeze(1).tolist() == list(range(340, 352))
    assert planes[0].tolist() == pytest.approx([-1, 0, -0.7], abs=1e-3)


def test_what_hardly_stands_out_or_is_thick_is_not_marked() -> None:
    assert (segment_handles(cabinet(out=0.005))[0][..., 3] != -1).all()
    thick = cabinet()
    thick[0, 340:352, :3] = 0.2 * torch.rand((12, 3), generator=torch.Generator().manual_seed(0)) + 0.3
    assert (segment_handles(thick)[0][..., 3] != -1).all()


def test_a_cloud_without_points_has_no_front() -> None:
    empty = torch.zeros((2, 64, 4))
    empty[1, :, 3] = 1
    marked, planes = segment_handles(empty)
    assert torch.equal(marked, empty) and (planes[1] == 0).all()


def test_a_front_moves_when_two_frames_say_so() -> None:
    def plane(angle: float, offset: float = -0.7) -> list[float]:
        return [-np.cos(angle), -np.sin(angle), offset]

    turning = torch.tensor([plane(0), plane(0.01), plane(0.2), plane(0), plane(0.2), plane(0.5)], dtype=torch.float32)
    assert find_still(turning).tolist() == [True, True, True, True, False, False]
    pulled = torch.tensor([plane(0), plane(0, -0.69), plane(0, -0.68), plane(0, -0.6)], dtype=torch.float32)
    assert find_still(pulled).tolist() == [True, True, False, False]


def sequences(count: int = 6, steps: int = 3) -> Batch:
    """Sequences of one marked cloud."""
    marked, fronts = segment_episodes(cabinet(0.3).repeat(steps, 1, 1), [steps])
    clouds, planes = (part[None].repeat(count, *[1] * part.dim()) for part in (marked, fronts))
    shape = (count, steps)
    return Batch(clouds, torch.rand((*shape, 9)), torch.rand((*shape, 7)), torch.ones(shape), planes)


@pytest.mark.usefixtures("all_fronts")
def test_fronts_move_in_their_planes_and_handles_stay_on_them() -> None:
    batch = sequences()
    moved = move_fronts(batch, torch.Generator().manual_seed(0))
    assert moved.proprio is batch.proprio and moved.actions is batch.actions
    front, rest = batch.clouds[..., 3] == 0, batch.clouds[..., 3] != 0
    assert torch.equal(moved.clouds[rest], batch.clouds[rest])
    normal = batch.fronts[0, 0, :2]  # type: ignore[index]
    assert torch.allclose(moved.clouds[front][:, :2] @ normal, batch.clouds[front][:, :2] @ normal, atol=1e-5)
    along = torch.stack([-normal[1], normal[0]])
    for before, after in zip(batch.clouds, moved.clouds, strict=True):
        handle = before[0, 340:352]
        for axis in (lambda p: p[:, :2] @ along, lambda p: p[:, 2]):
            ends = axis(after[0, :340])
            assert ends.min() <= axis(handle).min() + 1e-4 and ends.max() >= axis(handle).max() - 1e-4
            assert ends.min() != pytest.approx(axis(before[0, :340]).min().item(), abs=1e-3)


def test_handles_are_stretched_about_their_middle(all_fronts: pytest.MonkeyPatch) -> None:
    batch = sequences()
    for name, value in {"HANDLE_SCALE": (0.2, 0.3), "FRONT_SHIFT": 0.0, "FRONT_SCALE": (1.0, 1.0)}.items():
        all_fronts.setattr(augment, name, value)
    moved = move_fronts(batch, torch.Generator().manual_seed(0)).clouds
    before, after = batch.clouds[:, 0, 340:352], moved[:, 0, 340:352]
    ratio = (after[..., 2].amax(1) - after[..., 2].amin(1)) / (before[..., 2].amax(1) - before[..., 2].amin(1))
    assert 0.2 <= ratio.min() < ratio.max() <= 0.3
    assert torch.allclose(after.mean(1), before.mean(1), atol=1e-4)
    rest = [*range(340), 352, 353]
    assert torch.allclose(moved[:, :, rest], batch.clouds[:, :, rest], atol=1e-5)


def test_a_handle_is_hidden_where_the_hand_is_near() -> None:
    batch = sequences(count=300)
    middle = batch.clouds[0, 0, 340:352, :3].mean(0)
    batch.proprio[..., :3] = middle
    batch.proprio[:, 0, :3] += torch.tensor([-0.1, 0, 0])  # the first frame is from farther away
    seen = (hide_handles(batch, torch.Generator().manual_seed(0)).clouds[..., 3] == -1).sum(-1)
    assert (seen[:, 0] == 12).all() and set(seen[:, 1:].flatten().tolist()) == {0, 12}
    assert (seen[:, 1] == 0).float().mean().item() == pytest.approx(0.5, abs=0.08)


def test_grips_are_wider_where_something_is_held() -> None:
    batch = sequences(count=50)
    half = np.sqrt(0.5)
    batch.proprio[..., :3] = torch.tensor([0.3, 0.0, 0.4])  # between the fingers
    batch.proprio[..., 3:7] = torch.tensor([0.0, half, half, 0.0])  # x and y swapped: the hand's y is the base's x
    batch.proprio[..., 7:] = torch.tensor([0.04, 0.0, 0.006])[None, :, None]  # open, missed, holding
    batch.clouds[:, :, 352:354, :2] = torch.tensor([[0.28, 0.0], [0.32, 0.0]])
    wide = widen_grips(batch, torch.Generator().manual_seed(0))
    more = wide.proprio[..., 7] - batch.proprio[..., 7]
    assert (more[:, :2] == 0).all() and 0 <= more[:, 2].min() < more[:, 2].max() <= 0.012 and more[:, 2].std() > 0.001
    moved = wide.clouds[:, 2, 352:354, 0] - batch.clouds[:, 2, 352:354, 0]
    assert torch.allclose(moved, torch.stack([-more[:, 2], more[:, 2]], dim=1), atol=1e-5)
    assert torch.equal(wide.clouds[:, :2], batch.clouds[:, :2])


def test_an_episode_may_end_before_the_hand_lets_go() -> None:
    actions = np.ones((6, 7), np.float32)
    assert steps_until_release(actions) == 6  # it never closed
    actions[[1, 3], 6] = -1
    assert steps_until_release(actions) == 4
    actions[5, 6] = -1
    assert steps_until_release(actions) == 6


@pytest.mark.usefixtures("all_fronts")
def test_a_front_that_moves_and_one_without_a_handle_are_left_alone() -> None:
    batch = sequences()
    assert batch.fronts is not None
    batch.fronts[0, 2] = 0  # in its last frame this front has begun to move
    batch.clouds[1, ..., 3] = batch.clouds[1, ..., 3].clamp_min(0)
    moved = move_fronts(batch, torch.Generator().manual_seed(0))
    same = [torch.equal(a, b) for a, b in zip(batch.clouds, moved.clouds, strict=True)]
    assert same == [True, True, False, False, False, False]


def test_the_share_of_moved_fronts_is_what_is_asked() -> None:
    batch = sequences(count=400, steps=1)
    moved = move_fronts(batch, torch.Generator().manual_seed(1)).clouds
    assert (moved != batch.clouds).flatten(1).any(1).float().mean().item() == pytest.approx(0.8, abs=0.06)


def test_all_of_it_depends_on_the_seed_alone() -> None:
    batch = sequences()
    one, again, other = (vary_handles(batch, torch.Generator().manual_seed(seed)) for seed in (0, 0, 1))
    assert torch.equal(one.clouds, again.clouds) and not torch.equal(one.clouds, other.clouds)


def test_marked_points_are_never_thinned_away() -> None:
    clouds = cabinet().half()
    data = DemonstrationSet(
        clouds, torch.zeros((1, 9)), torch.zeros((1, 7)), [1], [0],
        [TrainingStore(file="a", asset="a", episodes=1, frames=1)], "door", TaskConfig(), "",
    ).segment_handles()  # fmt: skip
    index, real = np.zeros((5, 1), np.int64), np.ones((5, 1), bool)
    counts = {
        keep: (make_batch(data, index, real, 40, torch.Generator().manual_seed(0), keep).clouds[..., 3] == -1).sum(-1)
        for keep in (False, True)
    }
    assert (counts[True] == 12).all() and (counts[False] < 12).all()


def test_the_points_of_the_handle_come_first_and_none_is_lost() -> None:
    flags, order = torch.tensor([[[0.0, -1, 1, -1, 0]]]), torch.tensor([[[4, 1, 0, 3, 2]]])
    assert put_handle_first(flags, order).tolist() == [[[1, 3, 4, 0, 2]]]


def test_an_actor_sees_marked_clouds_and_a_policy_of_the_paper_does_not() -> None:
    small = {"pointnet_width": 8, "rnn_hidden": 8, "mlp": [8]}
    cloud, proprio = cabinet()[0].numpy(), np.zeros(9, np.float32)
    moved = cloud.copy()
    moved[340:352, 0] += 0.039  # the bar laid on the front: nothing protrudes
    for handle, flags in ((False, 2), (True, 3)):
        torch.manual_seed(0)
        policy = make_policy(PolicyConfig(points=400, kwargs=small, handle=handle)).eval()
        assert policy.pointnet.flag.num_embeddings == flags
        seen: list[Tensor] = []
        empty = torch.zeros((1, 17 + 7 * handle))
        read = policy.normalise
        policy.encode = lambda *given, read=read, seen=seen, empty=empty: (seen.append(read(*given)), empty)[1]  # type: ignore[method-assign]
        acting = make_rollout_policy(policy, 1, "most_likely")
        acting.start_episode(0, 0)
        acting.get_action([0], [cloud], [proprio])
        acting.get_action([0], [moved], [proprio])
        marks = [(part[..., 4:] == 1).sum().item() for part in seen]  # as the PointNet reads them
        assert marks == ([12, 0] if flags == 3 else [0, 0])


def test_the_way_to_the_handle_is_told_where_one_is_seen() -> None:
    marked, _ = segment_handles(cabinet().repeat(4, 1, 1))
    marked[0, ..., 3] = marked[0, ..., 3].clamp_min(0)  # nothing is seen yet
    marked[2, 341:352, 3] = 0  # one point is left of it,
    marked[3, ..., 3] = marked[3, ..., 3].clamp_min(0)  # then none: it is where most of it was seen
    hand = torch.tensor([[0.5, 0.1, 0.4]] * 3 + [[0.6, 0.1, 0.4]])
    way = offsets_to_handle(find_handle_middles(marked), hand)
    assert way[0].tolist() == [0, 0, 0, 0]
    assert way[1].tolist() == way[2].tolist() == pytest.approx([1.6, 0.4, 0.6, 1.0], abs=1e-4)
    assert way[3].tolist() == pytest.approx([0.6, 0.4, 0.6, 1.0], abs=1e-4)


def test_a_policy_without_eyes_acts_by_proprioception_alone() -> None:
    torch.manual_seed(0)
    policy = make_policy(PolicyConfig(points=40, kwargs={"cloud": False, "rnn_hidden": 8, "mlp": [8]}))
    clouds, proprio = torch.rand((2, 3, 40, 4)).round(), torch.rand((2, 3, 9))
    assert torch.equal(policy(clouds, proprio).means, policy(0 * clouds, proprio).means)  # type: ignore[operator]
    assert not torch.equal(policy(clouds, proprio).means, policy(clouds, 2 * proprio).means)  # type: ignore[operator]


def test_of_two_sights_of_as_much_of_the_handle_the_later_counts() -> None:
    seen = torch.tensor([[0.5, 0.0, 0.4, 3.0], [0.6, 0.1, 0.4, 3.0], [0.7, 0.2, 0.4, 2.0]])  # it moves with the door
    way = offsets_to_handle(seen, torch.zeros(3, 3))
    assert way[:, :2].tolist() == [pytest.approx(each) for each in ([5.0, 0.0], [6.0, 1.0], [6.0, 1.0])]


def test_an_actor_that_sees_few_points_sees_all_of_the_handle() -> None:
    cloud = segment_handles(cabinet())[0][0].numpy()
    counts = {}
    for handle in (False, True):
        policy = make_policy(PolicyConfig(points=40, kwargs={"rnn_hidden": 8, "mlp": [8]}, handle=handle))
        kept = policy.thin_cloud(cloud, np.random.default_rng(0))  # type: ignore[operator]
        counts[handle] = (len(kept), int((kept[:, 3] == -1).sum()))
    assert counts[True] == (40, 12) and counts[False][0] == 40 and counts[False][1] < 12
