"""The micro run without a shared filesystem, to its tables. It runs where `envs/engines.sh` has made its environment.

Files lie in a storage; a job takes from there what its rule declares, and nothing else is there.
"""

import json
import os
import shutil
import socket
import subprocess
import time
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
import trimesh

from stages.config.assets import COUNTS
from tests.workflow.kubernetes_api import cluster
from tests.workflow.workspace import LINKED, MICRO, ROOT, make

PYTHON = ROOT / ".venv-engines/bin/python"
BUCKET = "acdc"
KEYS = {"SNAKEMAKE_STORAGE_S3_ACCESS_KEY": "key", "SNAKEMAKE_STORAGE_S3_SECRET_KEY": "secret"}
OWN = ("--shared-fs-usage", "persistence", "source-cache", "sources", "software-deployment")
FETCH = """
import sys
from pathlib import Path
import boto3

address, bucket, folder = sys.argv[1:]
server = boto3.resource("s3", endpoint_url=address, aws_access_key_id="key", aws_secret_access_key="secret")
for item in server.Bucket(bucket).objects.all():
    path = Path(folder, item.key)
    path.parent.mkdir(parents=True, exist_ok=True)
    server.Bucket(bucket).download_file(item.key, str(path))
"""
pytestmark = pytest.mark.skipif(not PYTHON.exists(), reason="no .venv-engines: bash envs/engines.sh makes it")


def engine(folder: Path, *arguments: str, config: Sequence[str] = MICRO, **environment: str) -> str:
    """What `snakemake` with the plugins printed."""
    done = subprocess.run(
        [str(PYTHON), "-m", "snakemake", *arguments, *config],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert done.returncode == 0, done.stdout[-6000:]
    return done.stdout


def same(stored: dict[str, bytes], run: Path) -> None:
    """Whether a storage has the tables and everything that they were made of, as a run on one machine has it."""
    assert {"results/tables/table2.csv", "results/tables/table3.csv"} <= set(stored)
    results = {name: content for name, content in stored.items() if name.startswith("results/")}
    assert [name for name, content in results.items() if content != (run / name).read_bytes()] == []


@pytest.mark.skipif(not shutil.which("rsync"), reason="the plugin copies by rsync")
def test_a_folder_as_storage(run: Path, tmp_path: Path) -> None:
    storage = ("--default-storage-provider", "fs", "--default-storage-prefix", str(tmp_path / "store"))
    folder = make(tmp_path / "run")
    engine(folder, "--cores", "2", "tables", *storage, *OWN)
    assert not (folder / "results").exists()
    found = (path for path in (tmp_path / "store").rglob("*") if path.is_file())
    same({path.relative_to(tmp_path / "store").as_posix(): path.read_bytes() for path in found}, run)


@pytest.mark.skipif(not shutil.which("rsync"), reason="the plugin copies by rsync")
def test_models_of_yours_lie_in_the_storage_too(tmp_path: Path) -> None:
    folder, store = make(tmp_path / "run"), tmp_path / "store"
    for place in (folder, store):
        (place / "mine/crate/a").mkdir(parents=True)
        trimesh.creation.box((0.2, 0.3, 0.4)).export(place / "mine/crate/a/box.obj")
    (folder / "own.yaml").write_text(json.dumps({"assets": {"counts": dict.fromkeys(COUNTS, 0), "folders": ["mine"]}}))
    storage = ("--default-storage-provider", "fs", "--default-storage-prefix", str(store))
    index = "results/assets/library/library.json"
    engine(folder, "--cores", "1", index, *storage, *OWN, config=("--configfile", "own.yaml"))
    assert [entry["id"] for entry in json.loads((store / index).read_text())["assets"]] == ["crate_a"]


@contextmanager
def bucket() -> Iterator[str]:
    """The address of an S3 server with an empty bucket."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [str(PYTHON.with_name("moto_server")), "-H", "127.0.0.1", "-p", str(port)]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    address, late = f"http://127.0.0.1:{port}", time.monotonic() + 60
    try:
        while time.monotonic() < late:
            try:
                urllib.request.urlopen(urllib.request.Request(f"{address}/{BUCKET}", method="PUT")).close()
                break
            except OSError:
                time.sleep(0.5)
        yield address
    finally:
        server.kill()
        server.wait()


def contents(address: str, folder: Path) -> dict[str, bytes]:
    """Everything in the bucket below run/, by name; taken into `folder`."""
    subprocess.run([str(PYTHON), "-c", FETCH, address, BUCKET, str(folder)], check=True)
    files = (path for path in (folder / "run").rglob("*") if path.is_file())
    return {path.relative_to(folder / "run").as_posix(): path.read_bytes() for path in files}


def test_a_bucket_as_storage(run: Path, tmp_path: Path) -> None:
    """The plugin for S3 by itself, to the objects of the room; the next test has it to the tables."""
    with bucket() as address:
        storage = ("--default-storage-provider", "s3", "--default-storage-prefix", f"s3://{BUCKET}/run")
        server = ("--storage-s3-endpoint-url", address)
        engine(make(tmp_path / "run"), "--cores", "2", "extraction", *storage, *OWN, *server, **KEYS)
        stored = contents(address, tmp_path / "taken")
    assert "results/extraction/room_1/objects.json" in stored
    for name, content in stored.items():
        if name.startswith("results/"):
            assert content == (run / name).read_bytes(), name


def test_a_cluster_without_a_shared_filesystem(run: Path, tmp_path: Path) -> None:
    """Every job's command runs in an empty folder, with nothing but the image's programs and the bucket's address."""
    folder = tmp_path / "run"
    for name in LINKED:
        copied = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        (folder / name).parent.mkdir(exist_ok=True)
        copied(ROOT / name, folder / name)
    subprocess.run(["git", "init", "-q"], cwd=folder, check=True)  # what git knows travels to the jobs
    subprocess.run(["git", "add", *LINKED], cwd=folder, check=True)
    with bucket() as address, cluster(tmp_path / "cluster", PYTHON) as kubernetes:
        profile = ("--profile", "profiles/kubernetes", "--container-image", "example/acdc")
        storage = ("--default-storage-prefix", f"s3://{BUCKET}/run", "--storage-s3-endpoint-url", address)
        quick = ("--seconds-between-status-checks", "1", "--set-resources", "train:gpu=1")
        config = str(tmp_path / "cluster/kubeconfig")
        engine(folder, "tables", *profile, *storage, *quick, KUBECONFIG=config, **KEYS)
        stored = contents(address, tmp_path / "taken")
    assert not (folder / "results").exists() and set(kubernetes.exits.values()) == {0}
    same(stored, run)
    asked = {
        container["args"][1].split("--allowed-rules ")[1].split()[0]: container["resources"]["requests"]
        for job in kubernetes.jobs.values()
        for container in job["spec"]["template"]["spec"]["containers"]
    }
    assert asked["train"]["nvidia.com/gpu"] == "1" and asked["train"]["memory"] == "4000M"
    assert all(int(requests["ephemeral-storage"].removesuffix("M")) < 4000 for requests in asked.values())
