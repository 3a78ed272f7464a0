"""What a GPU buys: `python -m benchmarks.gpu results/demonstrations/door/twin/episodes.h5 [--devices cpu cuda]`.

Per device, in at most eight minutes: updates per second in training of `lite` and of the paper's network (by as many
points as the default's clouds have), actions of the paper's network for 16 environments at once, and DINOv2 of its true
size with random weights, in pictures per second (the encoder itself runs on the CPU). A device that lacks is "not run".
"""

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch

from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.config.model import read_files
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.encoders import make_encoder
from roomkin.stages.policies.base import make_policy
from roomkin.stages.training import train

ROOT = Path(__file__).resolve().parents[1]
# Of two trainings, whose difference is timed: nothing of the start counts.
UPDATES = {"lite": (100, 500), "paper": (2, 6)}
ENVIRONMENTS, POINTS, PICTURES = 16, 512, 8


def time_calls(what: Callable[[], object], times: int, device: str) -> float:
    """Seconds per call, after one that is not counted."""
    what()
    start = time.perf_counter()
    for _ in range(times):
        what()
    if device == "cuda":
        torch.cuda.synchronize()
    return (time.perf_counter() - start) / times


def time_updates(config: PolicyConfig, counts: tuple[int, int], episodes: Path, device: str) -> float:
    """Updates per second."""
    taken = []
    for steps in (counts[0], *counts):  # the first warms up
        options = json.dumps(
            config.model_dump(mode="json")
            | {"steps": steps, "log_freq": steps, "num_checkpoints": 0, "points": min(POINTS, config.points)}
        )
        with tempfile.TemporaryDirectory() as folder:
            start = time.perf_counter()
            train.run(episodes=(episodes,), per_store=40, out=Path(folder, "policy"), options=options, device=device)  # type: ignore[arg-type]
            taken.append(time.perf_counter() - start)
    return (counts[1] - counts[0]) / (taken[2] - taken[1])


def time_actions(config: PolicyConfig, device: str) -> float:
    """Milliseconds of one action for all environments."""
    policy = make_policy(config).eval().to(device)
    acting = policy.make_rollout_policy(ENVIRONMENTS, "most_likely")
    random, ids = np.random.default_rng(0), list(range(ENVIRONMENTS))
    clouds = [random.random((POINTS, 4), dtype=np.float32).round(3) for _ in ids]
    for cloud in clouds:
        cloud[:, 3] = 0
    for each in ids:
        acting.start_episode(each, each)
    return 1e3 * time_calls(lambda: acting.get_action(ids, clouds, [np.zeros(9, np.float32) for _ in ids]), 12, device)


def time_dinov2(device: str) -> tuple[float, float]:
    """Pictures per second: of the network alone on a device, and of the encoder with all around it, on the CPU."""
    from transformers import Dinov2Config, Dinov2Model

    size = Dinov2Config(hidden_size=384, num_attention_heads=6, patch_size=14, image_size=518)  # ViT-S/14
    with tempfile.TemporaryDirectory() as folder:
        Dinov2Model(size).save_pretrained(folder)
        encoder = make_encoder(EncoderOptions.model_validate({"encoder": "dinov2", "dinov2": {"path": folder}}))
        network = Dinov2Model.from_pretrained(folder).eval().to(device)
        view = ObjectView(np.full((240, 320, 3), 90, np.uint8), np.ones((240, 320), bool))
        whole = PICTURES / time_calls(lambda: encoder.encode([view] * PICTURES), 2, "cpu")
        pixels = torch.zeros(PICTURES, 3, 224, 224, device=device)
        with torch.inference_mode():
            alone = PICTURES / time_calls(lambda: network(pixels), 5, device)
    return alone, whole


def main() -> None:
    """A line per figure and device."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("episodes", type=Path)
    parser.add_argument("--devices", nargs="+", choices=["cpu", "cuda"], default=["cpu", "cuda"])
    asked = parser.parse_args()
    torch.set_num_threads(1)
    configs = read_files([ROOT / "config.yaml", ROOT / "config/paper/policies.yaml"]).training.configs
    for device in asked.devices:
        if device == "cuda" and not torch.cuda.is_available():
            print("cuda: not run, torch finds no GPU")
            continue
        print(f"{device}: {torch.cuda.get_device_name() if device == 'cuda' else 'one thread'}")
        for name, counts in UPDATES.items():
            rate = time_updates(configs[name], counts, asked.episodes, device)
            print(f"  updates of `{name}` per second  {rate:8.2f}")
        print(f"  action of `paper`, 16 environments, ms {time_actions(configs['paper'], device):8.1f}")
        alone, whole = time_dinov2(device)
        print(f"  DINOv2, pictures per second: network {alone:.1f}, encoder on the CPU {whole:.1f}")


if __name__ == "__main__":
    main()
