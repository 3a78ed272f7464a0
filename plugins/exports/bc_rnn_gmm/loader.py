"""A trained policy by torch and safetensors alone: policy = PortablePolicy(folder); action = policy(cloud, proprio)."""

import json
from pathlib import Path

import torch
from safetensors.torch import load_file
from torch.nn.functional import gelu, linear, relu


class PortablePolicy:
    def __init__(self, folder: str) -> None:
        self.about = json.loads(Path(folder, "policy.json").read_text(encoding="utf-8"))
        self.weights = load_file(Path(folder, "weights.safetensors"))
        self.lstm = torch.nn.LSTM(self.about["features"], self.about["memory"])
        self.lstm.load_state_dict({k[5:]: tensor for k, tensor in self.weights.items() if k.startswith("lstm.")})
        self.past: list[torch.Tensor] = []  # clear it when an episode begins
        if self.about["flags"] > 2:
            import handle_points  # lies beside this file

            self.handle_points = handle_points

    @torch.inference_mode()
    def __call__(self, cloud: torch.Tensor, proprio: torch.Tensor) -> torch.Tensor:  # (P, 4), (9,) -> action (7,)
        if (flags := self.about["flags"]) > 2:
            cloud = self.handle_points.segment_handles(cloud[None])[0][0]
        order = torch.randperm(len(cloud))
        if self.about["keep_flagged"]:
            order = order[(cloud[order, 3] != -1).int().argsort(stable=True)]
        some = cloud[order[: self.about["points"]]]
        marks = torch.stack([some[:, 3], -some[:, 3]], dim=1).clamp_min(0)[:, : flags - 1]
        x = torch.cat([some[:, :3] - proprio[:3] * self.about["gripper_frame"], marks], dim=1)
        for i in range(self.about["point_layers"]):
            x = linear(gelu(x) if i else x, self.weights[f"point.{i}.weight"], self.weights[f"point.{i}.bias"])
        own = (proprio - self.weights["proprio_mean"]) / self.weights["proprio_std"]
        seen = [proprio[:3], self.handle_points.find_handle_middles(some)] if self.about["middle"] else []
        self.past = [*self.past, torch.cat([relu(x.amax(0)), own, *seen])][-self.about["horizon"] :]
        x = torch.stack(self.past)
        if self.about["middle"]:
            x = torch.cat([x[:, :-7], self.handle_points.offsets_to_handle(x[:, -4:], x[:, -7:-4])], dim=1)
        x = self.lstm(x)[0][-1]
        for i in range(self.about["head_layers"]):
            x = linear(relu(x) if i else x, self.weights[f"head.{i}.weight"], self.weights[f"head.{i}.bias"])
        return x[(n := self.about["modes"]) :].view(-1, 7)[torch.multinomial(x[:n].softmax(0), 1)[0]].tanh()  # a mode
