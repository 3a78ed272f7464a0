"""What `roomkin ops cluster` says of a cluster that lacks something."""

import errno
import fcntl
import re
from pathlib import Path

import pytest

from roomkin.plugins.ops import cluster as checked
from roomkin.plugins.ops import doctor

CLUSTER = """\
AccountingStorageType   = accounting_storage/none
ClusterName             = small
MinJobAge               = 300 sec
SLURM_VERSION           = 22.05.8
"""


def cluster(monkeypatch: pytest.MonkeyPatch, **said: str) -> list[doctor.Check]:
    """The checks of a cluster whose commands say this."""

    def answer(*command: str, seconds: float = 0) -> str:
        if command[0] == "srun" and "srun" in said:
            return "".join(Path(name).read_text() for name in re.findall(r"'(.*)'", command[-1]))
        return said.get(command[0], "")

    monkeypatch.setattr(checked, "answer", answer)
    return checked.checks()


def test_a_cluster_that_lacks_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(checked, "PLUGIN", "snakemake")
    found = cluster(monkeypatch, scontrol=CLUSTER, srun="yes", sinfo="main* gpu:1")
    assert [check.name for check in found if check.good] == ["slurm", "plugin", "flock", "accounting", "shared", "gpu"]
    assert not list(tmp_path.iterdir())


def test_what_a_cluster_lacks_is_named_with_what_mends_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSYS, "Function not implemented")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(fcntl, "flock", refuse)
    monkeypatch.setattr(checked, "PLUGIN", "no-such-plugin")
    found = {check.name: check for check in cluster(monkeypatch, scontrol=CLUSTER.replace("300", "5"))}
    assert not any(check.good for name, check in found.items() if name != "slurm")
    assert {name for name, check in found.items() if check.needed} == {"slurm", "plugin", "accounting", "shared"}
    fixes = {"plugin": "make slurm", "flock": "--unlock", "accounting": "MinJobAge=300", "gpu": "device: cpu"}
    assert all(words in found[name].fix for name, words in fixes.items())
    assert "srun --ntasks=1 --time=2 ls" in found["shared"].fix and "Function not implemented" in found["flock"].found


def test_accounts_are_told_where_there_are_any(monkeypatch: pytest.MonkeyPatch) -> None:
    said = {"scontrol": CLUSTER.replace("storage/none", "storage/slurmdbd"), "sacctmgr": "lab\nlab\nmine"}
    found = {check.name: check for check in cluster(monkeypatch, **said)}
    assert found["accounting"].good and "lab, mine" in found["accounting"].found


def test_without_a_controller_nothing_else_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    found = cluster(monkeypatch)
    assert [check.name for check in found] == ["slurm", "plugin", "flock"] and "login node" in found[0].fix
