"""A SLURM cluster of two nodes on this machine: one core each and, if wanted, a GPU that is none.

`python -m tests.cluster.slurm COMMAND ...` runs a command with such a cluster, e.g. `bash`.
"""

import os
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from roomkin.plugins.ops.guard import WORKFLOW, Holder, descendants

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch")
NODES = ("n1", "n2")
DEVICES = {"n1": "/dev/null", "n2": "/dev/zero"}  # a file that stands for each node's GPU
CONFIG = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
GresTypes=gpu
SlurmdParameters=config_overrides
SlurmdTimeout=10
KillWait=5
ReturnToService=2
PartitionName=main Nodes=ALL Default=YES State=UP
"""
NODE = "NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=14000 Gres=gpu:1\n"


def missing() -> list[str]:
    """Programs of SLURM that are not installed here."""
    return [name for name in PROGRAMS if not shutil.which(name)]


def free_ports(count: int) -> list[int]:
    """Ports that nobody listens on."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Cluster:
    """The daemons and their folder.

    Attributes:
        environment: what SLURM's commands need to find this cluster.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.environment = {"SLURM_CONF": str(folder / "slurm.conf")}
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        host, (controller, *ports) = socket.gethostname().split(".")[0], free_ports(1 + len(NODES))
        nodes = "".join(NODE.format(name=name, host=host, port=port) for name, port in zip(NODES, ports, strict=True))
        (folder / "state").mkdir()
        (folder / "slurm.conf").write_text(CONFIG.format(folder=folder, host=host, controller=controller) + nodes)
        (folder / "cgroup.conf").write_text("CgroupPlugin=autodetect\n")
        (folder / "gres.conf").write_text(
            "".join(f"NodeName={name} Name=gpu File={file}\n" for name, file in DEVICES.items())
        )
        key = folder / "munge.key"
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o600)

    def start(self) -> None:
        """Start everything; returns when both nodes are idle."""
        munge = [
            f"--{name}={self.folder}/munge.{name.partition('-')[0]}" for name in ("key-file", "log-file", "pid-file")
        ]
        munge += [f"--seed-file={self.folder}/munge.seed", f"--socket={self.folder}/munge.socket"]
        self._start("munged", "munged", "--foreground", "--force", *munge)
        wait_for(lambda: (self.folder / "munge.socket").exists(), "munged")
        self._start("slurmctld", "slurmctld", "-D")
        for name in NODES:
            self.start_node(name)
        wait_for(lambda: self.states() == dict.fromkeys(NODES, "idle"), f"the nodes: {self.states()}")

    def start_node(self, name: str, apart: bool = False) -> None:
        """Start one node; `apart`: with process ids of its own, as another machine has them."""
        (self.folder / f"spool-{name}").mkdir(exist_ok=True)
        away = ["unshare", "--pid", "--fork", "--mount-proc", "--kill-child"] if apart else []
        self._start(name, *away, "slurmd", "-D", "-N", name)

    def kill_node(self, name: str) -> None:
        """Let a node die, with all that runs on it."""
        self._kill(name)

    def states(self) -> dict[str, str]:
        """Name -> state of each node, as sinfo says it."""
        return dict(line.split() for line in self.ask("sinfo", "--noheader", "--Node", "--format=%N %T").splitlines())

    def queue(self) -> list[str]:
        """Ids of the jobs that wait, run or are about to end."""
        return self.ask("squeue", "--noheader", "--format=%i").split()

    def ask(self, *command: str) -> str:
        """What a command of SLURM prints; '' if it fails."""
        done = subprocess.run(command, env=os.environ | self.environment, text=True, capture_output=True)
        return done.stdout if done.returncode == 0 else ""

    def stop(self) -> None:
        """Kill the daemons, what they started, and workflows that a failed test left."""
        for name in [*NODES, "slurmctld", "munged"]:
            self._kill(name)
        kill(processes_with(f"SLURM_CONF={self.environment['SLURM_CONF']}"))

    def _start(self, name: str, *command: str) -> None:
        guarded = [
            sys.executable,
            "-m",
            "roomkin.plugins.ops.guard",
            *command,
        ]  # daemons end with the tests, however these end
        environment = os.environ | self.environment | {WORKFLOW: Holder.this_process().text}
        with (self.folder / f"{name}.out").open("ab") as log:
            self._running[name] = subprocess.Popen(
                guarded, env=environment, stdout=log, stderr=log, start_new_session=True
            )

    def _kill(self, name: str) -> None:
        process = self._running.pop(name, None)
        if process is None:
            return
        # a job's steps are in sessions of their own, whose parents may have ended: they are known by their node's name
        steps = processes_with(f"SLURM_CONF={self.environment['SLURM_CONF']}", f"SLURMD_NODENAME={name}")
        kill([*descendants(process.pid), *steps, process.pid])
        process.wait()


def kill(pids: list[int]) -> None:
    """SIGKILL for those that are still there."""
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def processes_with(*variables: str) -> list[int]:
    """Processes that have all these variables, `NAME=value`, in their environment; not this one."""
    pids = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            environment = (process / "environ").read_bytes().split(b"\0")
        except OSError:
            continue
        if process.name != str(os.getpid()) and all(variable.encode() in environment for variable in variables):
            pids.append(int(process.name))
    return pids


def wait_for(true: Callable[[], object], what: str, seconds: float = 60.0) -> None:
    """Wait until a function says yes.

    Raises:
        TimeoutError: it did not.
    """
    until = time.monotonic() + seconds
    while not true():
        if time.monotonic() > until:
            raise TimeoutError(f"{what} did not come within {seconds:.0f} s")
        time.sleep(0.2)


@contextmanager
def running() -> Iterator[Cluster]:
    """A cluster that is stopped at the end, and its folder removed."""
    folder = Path(tempfile.mkdtemp(prefix="slurm-"))
    cluster = Cluster(folder)
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    with running() as cluster:
        sys.exit(subprocess.call(sys.argv[1:], env=os.environ | cluster.environment))
