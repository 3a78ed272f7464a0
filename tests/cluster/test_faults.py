"""What goes wrong on a cluster: a killed or second workflow, a dead node, failing jobs, too little memory; and GPUs."""

import os
import signal
from collections.abc import Iterator
from itertools import combinations, pairwise
from pathlib import Path

import pytest

from tests.cluster.slurm import NODES, Cluster, wait_for
from tests.cluster.workflow import POLICIES, ROOM, at_once, journal, said, start, with_sleepers

pytestmark = pytest.mark.cluster


@pytest.fixture
def apart(cluster: Cluster) -> Iterator[Cluster]:
    """The cluster with nodes whose processes the workflow cannot see, as on other machines."""
    for name in NODES:
        cluster.kill_node(name)
        cluster.start_node(name, apart=True)
    yield cluster
    for name in NODES:
        cluster.kill_node(name)
        cluster.start_node(name)


def made(folder: Path, *paths: str) -> list[str]:
    return [path for path in paths if (folder / path).exists()]


def test_ctrl_c_leaves_nothing_in_the_queue(cluster: Cluster, run: Path, tmp_path: Path) -> None:
    arguments = with_sleepers(run, folder := tmp_path / "run", seconds=60)
    workflow = start(cluster, folder, *arguments, *POLICIES)
    wait_for(lambda: len(journal(folder)) == 2, "two jobs")
    os.killpg(workflow.pid, signal.SIGINT)
    assert workflow.wait(60) != 0
    wait_for(lambda: cluster.queue() == [], "an empty queue", 30)
    assert made(folder, *POLICIES) == []


def test_what_a_killed_workflow_left_running_is_ended_before_it_runs_again(
    apart: Cluster, run: Path, tmp_path: Path
) -> None:
    arguments = with_sleepers(run, folder := tmp_path / "run", seconds=12)
    workflow = start(apart, folder, *arguments, *POLICIES)
    wait_for(lambda: len(journal(folder)) == 2, "two jobs")
    workflow.kill()
    workflow.wait()
    assert start(apart, folder, *arguments, *POLICIES).wait() == 0, said(folder)[-5000:]
    assert "cancelling SLURM jobs that a killed run left here" in said(folder)
    tries = journal(folder)
    assert sorted(map(len, tries.values())) == [1, 2, 2]
    for beats in tries.values():
        assert not any(at_once(first, second) for first, second in pairwise(beats.values()))
    assert made(folder, *POLICIES) == POLICIES and apart.queue() == []


def test_a_second_start_in_the_same_folder_is_refused_in_one_line(cluster: Cluster, run: Path, tmp_path: Path) -> None:
    arguments = with_sleepers(run, folder := tmp_path / "run", seconds=8)
    workflow = start(cluster, folder, *arguments, *POLICIES)
    wait_for(lambda: journal(folder), "a job")
    assert start(cluster, folder, *arguments, *POLICIES).wait(60) == 1
    assert f"another workflow is running here (process {workflow.pid} on " in said(folder)
    assert workflow.wait() == 0, said(folder)[-5000:]
    assert all(len(tries) == 1 for tries in journal(folder).values())


def test_jobs_of_a_node_that_dies_run_on_another(cluster: Cluster, run: Path, tmp_path: Path) -> None:
    arguments = with_sleepers(run, folder := tmp_path / "run", seconds=15)
    workflow = start(cluster, folder, *arguments, *POLICIES)
    wait_for(lambda: len(journal(folder)) == 2, "two jobs")
    cluster.kill_node("n1")
    assert workflow.wait(400) == 0, said(folder)[-5000:]
    cluster.start_node("n1")
    nodes = {name: [process.split()[0] for process in tries] for name, tries in journal(folder).items()}
    assert sorted(nodes.values()) == [["n1", "n2"], ["n2"], ["n2"]]
    wait_for(lambda: cluster.states()["n1"] == "idle", "n1 again", 90)


def test_a_job_that_fails_once_is_tried_again_and_one_that_always_fails_is_told(
    cluster: Cluster, run: Path, tmp_path: Path
) -> None:
    fail = {"micro": 1, "micro_small": 99}
    arguments = with_sleepers(run, folder := tmp_path / "run", seconds=1, fail=fail)
    assert start(cluster, folder, "--keep-going", *arguments, *POLICIES).wait() == 1
    assert {name: len(tries) for name, tries in journal(folder).items()} == {
        "micro": 2, "micro_small": 3, "micro_handle": 1,
    }  # fmt: skip
    assert made(folder, *POLICIES) == [POLICIES[0], POLICIES[2]]
    assert "error: try 3 of micro_small fails" in said(folder)


def test_a_job_that_needs_more_memory_gets_more_when_tried_again(cluster: Cluster, run: Path, tmp_path: Path) -> None:
    arguments = with_sleepers(run, folder := tmp_path / "run", seconds=8, megabytes={"room_1": 2600})
    assert start(cluster, folder, *arguments, ROOM).wait() == 0, said(folder)[-5000:]
    first, second = journal(folder)["room_1"].values()
    assert first[-1] - first[0] < 6 < second[-1] - second[0], "the first was killed, the second not"


def test_two_policies_train_at_once_on_two_nodes_with_a_gpu_each(cluster: Cluster, run: Path, tmp_path: Path) -> None:
    arguments = with_sleepers(run, folder := tmp_path / "run", "device: cuda", seconds=12)
    workflow = start(cluster, folder, *arguments, *POLICIES)
    wait_for(lambda: len(journal(folder)) == 2, "two jobs")
    assert cluster.ask("scontrol", "show", "jobs").count("TresPerJob=gres:gpu:1") == len(POLICIES)
    assert workflow.wait() == 0, said(folder)[-5000:]
    beats = [times for tries in journal(folder).values() for times in tries.values()]
    assert sum(at_once(first, second) for first, second in combinations(beats, 2)) >= 1
