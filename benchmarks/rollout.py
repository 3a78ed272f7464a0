"""What a control step of a rollout costs, part by part, and what a change of scale or asset does, on one core.

    OMP_NUM_THREADS=1 python -m benchmarks.rollout [--steps N] [--policy FOLDER]

Process time of one thread. A procedural cabinet is made for it; without `--policy` (a folder that `training train`
wrote) the network of `lite` acts with the weights that it starts from.
"""

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

START = time.process_time()

import torch  # noqa: E402

from roomkin.plugins.furniture.library import make  # noqa: E402
from roomkin.stages.config.training import TrainingSection  # noqa: E402
from roomkin.stages.contracts.policy_config import TaskConfig  # noqa: E402
from roomkin.stages.policies.base import (  # noqa: E402
    TrainablePolicy,
    load_network,
    make_policy,
)
from roomkin.stages.tasks.api import EnvWrapper  # noqa: E402


def time_calls(what: Callable[[], object], times: int) -> float:
    """Milliseconds of process time per call."""
    start = time.process_time()
    for _ in range(times):
        what()
    return (time.process_time() - start) / times * 1e3


def roll_out(tasks: Sequence[EnvWrapper], policy: TrainablePolicy, steps: int) -> float:
    """Steps per second of process time, the policy in the loop; resets are not counted."""
    acting = policy.make_rollout_policy(len(tasks), "most_likely")
    env_ids = list(range(len(tasks)))
    observations = []
    for i, task in enumerate(tasks):
        observations.append(task.reset(i))
        acting.start_episode(i, i)
    start = time.process_time()
    for _ in range(steps):
        actions = acting.get_action(
            env_ids, [seen["point_cloud"] for seen in observations], [seen["proprio"] for seen in observations]
        )
        observations = [task.step(action).observation for task, action in zip(tasks, actions, strict=True)]
    return steps * len(tasks) / (time.process_time() - start)


def main(steps: int, folder: Path | None) -> None:
    """Print a line per figure."""
    torch.set_num_threads(1)
    print(f"imports                        {(time.process_time() - START) * 1e3:8.0f} ms")
    policy = load_network(folder, "best") if folder else make_policy(TrainingSection().configs["lite"]).eval()
    options = TaskConfig()
    with tempfile.TemporaryDirectory() as temporary:
        models = Path(temporary)
        assets = [models / make("bottom_cabinet", index, 0, models).id for index in (0, 2)]
        tasks = [EnvWrapper("door", assets[0], "door_0_joint", None, options, vary_scale=False) for _ in range(4)]
        task = tasks[0]
        print(f"first episode, first picture   {time_calls(lambda: task.reset(0), 1):8.0f} ms")
        print(f"the next environment           {time_calls(lambda: tasks[1].reset(0), 1):8.0f} ms")
        action = np.array([0.2, 0.1, -0.1, 0.0, 0.0, 0.1, 1.0], np.float32)
        env = task.env
        task.reset(1)
        pictures = env.rig.capture(env._sensors)
        print(f"act: IK, physics, success      {time_calls(lambda: task.act(action), 50):8.2f} ms")

        def look() -> None:
            env.scene.update_render(update_human_render_cameras=False)
            env.rig.capture(env._sensors)

        print(f"picture and its way back       {time_calls(look, steps):8.2f} ms")
        joints, shown = task.joints(), env.seen_ids()
        seen = time_calls(lambda: env.rig.observation(joints, pictures, shown, 0), steps)
        print(f"crop, farthest points, fingers {seen:8.2f} ms")
        for count in (1, 4):
            print(f"policy in the loop, {count} envs     {roll_out(tasks[:count], policy, steps):8.0f} steps/s")
        varied = EnvWrapper("door", assets[0], "door_0_joint", None, options)
        varied.place(0)
        seeds = iter(range(1, 1000))
        print(f"episode at another scale       {time_calls(lambda: varied.place(next(seeds)), 20):8.1f} ms")

        def exchange() -> None:
            seed = next(seeds)
            varied.turn_to(assets[seed % 2], "door_0_joint", None)
            varied.place(seed)

        exchange()
        exchange()
        print(f"episode with another asset     {time_calls(exchange, 20):8.1f} ms")
        for task in (*tasks, varied):
            task.close()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--policy", type=Path)
    given = parser.parse_args()
    main(given.steps, given.policy)
