"""Run by robomimic's own environment: read files with its SequenceDataset, train BC-RNN-GMM by one step of its own."""

import json
import sys
from typing import Any

import robomimic
import torch
from robomimic.algo import algo_factory
from robomimic.config import config_factory
from robomimic.utils.dataset import SequenceDataset
from robomimic.utils.file_utils import get_env_metadata_from_dataset, get_shape_metadata_from_dataset
from robomimic.utils.obs_utils import initialize_obs_utils_with_config

config = config_factory("bc")
with config.values_unlocked():
    config.observation.modalities.obs.low_dim = ["proprio", "point_cloud"]
    config.algo.rnn.enabled = config.algo.gmm.enabled = True
    config.algo.rnn.horizon, config.algo.rnn.hidden_dim, config.algo.actor_layer_dims = 5, 16, (16,)
initialize_obs_utils_with_config(config)


def step(path: str, key: str | None) -> dict[str, Any]:
    """What was read, and whether a step on it moved the weights."""
    shapes = get_shape_metadata_from_dataset(path, all_obs_keys=config.all_obs_keys)
    data = SequenceDataset(
        path, obs_keys=("proprio", "point_cloud"), dataset_keys=("actions", "rewards", "dones"), seq_length=5,
        pad_seq_length=True, frame_stack=1, hdf5_cache_mode=None, filter_by_attribute=key, load_next_obs=False,
    )  # fmt: skip
    model = algo_factory("bc", config, shapes["all_shapes"], shapes["ac_dim"], torch.device("cpu"))
    model.set_train()
    before = [parameter.detach().clone() for parameter in model.nets.parameters()]
    batch = next(iter(torch.utils.data.DataLoader(data, batch_size=4)))
    log = model.log_info(model.train_on_batch(model.process_batch_for_training(batch), epoch=0, validate=False))
    return {
        "version": robomimic.__version__,
        "environment": get_env_metadata_from_dataset(path)["env_name"],
        "demos": data.n_demos,
        "sequences": len(data),
        "first": {name: batch["obs"][name][0, 0].flatten()[:4].tolist() for name in ("point_cloud", "proprio")},
        "actions": list(batch["actions"].shape),
        "loss": float(log["Loss"]),
        "moved": any(not torch.equal(a, b) for a, b in zip(before, model.nets.parameters(), strict=True)),
    }


print(json.dumps([step(path, key or None) for path, _, key in (word.partition(":") for word in sys.argv[1:])]))
