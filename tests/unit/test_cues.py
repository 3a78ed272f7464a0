"""`benchmarks.cues` tells a policy that goes by the handle from one that goes by the front."""

import pytest
import torch

from benchmarks.cues import SHIFT, measure_answers
from stages.contracts.training_run import TrainingRun


class Centring:
    """Answers with a sideways motion (y) to the mean of what it goes by, over all its clouds."""

    run = TrainingRun()

    def __init__(self, by_handle: bool) -> None:
        self.by_handle = by_handle

    def __call__(self, clouds: torch.Tensor, proprio: torch.Tensor) -> object:
        x, y = clouds[0, ..., 0], clouds[0, ..., 1]
        used = x < 0.68 if self.by_handle else x >= 0.68
        aim = y[used].mean() if used.any() else torch.tensor(0.0)
        means = torch.zeros(1, clouds.shape[1], 1, 7)
        means[..., 1] = aim
        return type("Mixture", (), {"logits": torch.zeros(1, clouds.shape[1], 1), "means": means})()


def drawer() -> torch.Tensor:
    """(5, 120, 4): a front of 80 x 20 cm with a bar 4 cm before it, without fingers; in another order in each cloud."""
    random = torch.Generator().manual_seed(0)
    points = torch.rand((120, 3), generator=random) * torch.tensor([0.0, 0.8, 0.2]) + torch.tensor([0.7, -0.4, 0.4])
    points[:12] = torch.rand((12, 3), generator=random) * torch.tensor([0.0, 0.3, 0.01]) + torch.tensor(
        [0.66, -0.1, 0.5]
    )
    cloud = torch.cat([points, torch.zeros(120, 1)], dim=1)
    return torch.stack([cloud[torch.randperm(120, generator=random)] for _ in range(5)])


@pytest.mark.parametrize("by_handle", [True, False])
def test_what_a_policy_goes_by_moves_it(by_handle: bool) -> None:
    shown = measure_answers(Centring(by_handle), drawer(), torch.zeros(5, 9), 0.05)
    assert shown is not None and shown["handle points"] == 12
    expected = 100 * SHIFT * 5.0 / 100
    assert abs(shown["handle moved"]) == pytest.approx(expected if by_handle else 0, abs=1e-4)
    assert abs(shown["front moved"]) == pytest.approx(0 if by_handle else expected, abs=1e-4)
    assert (shown["no handle"] > 0.1) == by_handle


def test_no_handle_no_answer() -> None:
    flat = drawer()
    flat[..., 0] = 0.7
    assert measure_answers(Centring(True), flat, torch.zeros(5, 9), 0.05) is None
