"""Command `policy`: a policy for people without this workflow."""

import importlib
import shutil
from pathlib import Path

from roomkin.plugins.exports.package import find_portable_form
from roomkin.stages.config.code import cover
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import write_atomically, write_json
from roomkin.stages.contracts.policy_config import has_eyes
from roomkin.stages.contracts.trained import read_config
from roomkin.stages.plugins import qualify_module
from roomkin.stages.policies import handle_points
from roomkin.stages.policies.base import ActionMode, load_network, save_weights

LAYOUT = {
    "point_cloud": "(P, 4) float32: x, y, z in metres in the robot base frame, then 1 on the fingers and 0 elsewhere",
    "proprio": "(9,) float32: end-effector position, quaternion wxyz, the two finger joints; robot base frame, metres",
    "action": "(7,) in [-1, 1]: translation, axis-angle rotation, both along the base axes, gripper (1 open, -1 shut)",
}


def run(*, policy: Path, out: Path, checkpoint: str = "best", action: ActionMode = "sharpened") -> None:
    """Write weights.safetensors, policy.json, loader.py and handle_points.py, which need torch and safetensors alone.

    A policy that sees flagged handles marks them itself, by handle_points.py.

    Args:
        policy: folder of the policy (training train).
        out: folder to write.
        checkpoint: best, last, or the name of one of `checkpoints` in config.json.
        action: by which mode of the mixture it acts, as in `evaluation.action`.
    """
    trained = read_config(policy)
    cover([qualify_module("policies", trained.config.policy)])
    module = find_portable_form(trained.config.policy)
    if module is None:
        what = f"a policy '{trained.config.policy}' has no portable form."
        raise InputError(policy, what, "write `portable.py` beside it", code="E-POLICY-PORTABLE")
    if not has_eyes(trained.config):
        what = "sees no cloud: it is a baseline for rollouts."
        raise InputError(policy, what, "export one with cloud: true", code="E-POLICY-PORTABLE")
    code = importlib.import_module(module)
    weights, about = code.portable(load_network(policy, checkpoint), action)
    options = trained.task_options
    about |= {
        "layout": LAYOUT,
        "task": trained.task,
        "control_frequency_hz": options.control_frequency,
        "translation_at_1_m": options.position_step,
        "rotation_at_1_rad": options.rotation_step,
        "training_episodes": trained.training_episodes,
        "stores": [f"{store.file}: {store.episodes} episodes of {store.asset}" for store in trained.stores],
    }
    save_weights(out / "weights.safetensors", weights)
    write_json(out / "policy.json", about)
    assert code.__file__
    assert handle_points.__file__
    for source_file in (Path(code.__file__).with_name("loader.py"), Path(handle_points.__file__)):
        with write_atomically(out / source_file.name) as temporary:
            shutil.copyfile(source_file, temporary)
