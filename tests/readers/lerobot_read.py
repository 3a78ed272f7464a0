"""Run by lerobot's own environment: read a folder with its LeRobotDataset, in windows of frames and in part."""

import json
import sys

import lerobot
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

root, fps = sys.argv[1], float(sys.argv[2])
data = LeRobotDataset("local/demonstrations", root=root, delta_timestamps={"action": [0, 1 / fps, 2 / fps]})
last = data[len(data) - 1]
part = LeRobotDataset("local/demonstrations", root=root, episodes=[1])
batch = next(iter(torch.utils.data.DataLoader(data, batch_size=3)))
print(
    json.dumps(
        {
            "version": lerobot.__version__,
            "episodes": data.num_episodes,
            "frames": len(data),
            "task": last["task"],
            "cloud": last["observation.point_cloud"].tolist(),
            "state": last["observation.state"].tolist(),
            "padded": last["action_is_pad"].tolist(),
            "action": last["action"][0].tolist(),
            "done": bool(last["next.done"]),
            "batch": list(batch["observation.point_cloud"].shape),
            "part": [int(part[0]["episode_index"]), len(part)],
            "mean": data.meta.stats["observation.state"]["mean"].tolist(),
        }
    )
)
