"""Stands for a stage: works for some seconds, notes when and where, then writes what a finished run has.

plan.json: {seconds, fail: {name: how many tries fail}, megabytes: {name: memory that it takes}}.
"""

import json
import os
import shutil
import sys
import time
from pathlib import Path

out = Path(sys.argv[sys.argv.index("--out") + 1])
plan = json.loads(Path("plan.json").read_text())
name = out.name if out.parts[1] == "scenes" else out.parts[-2]
before = Path("journal").read_text().splitlines() if Path("journal").exists() else []
tries = len({line.split()[2] for line in before if line.split()[0] == name})


def work() -> None:
    """Note that this process is at work."""
    with Path("journal").open("a") as journal:
        journal.write(f"{name} {os.environ.get('SLURMD_NODENAME', '-')} {os.getpid()} {time.time()}\n")


work()
memory = bytearray(plan.get("megabytes", {}).get(name, 0) * 10**6)
memory[::1024] = b"x" * len(memory[::1024])
until = time.time() + plan["seconds"]
while time.time() < until:
    work()
    time.sleep(0.2)
if tries < plan.get("fail", {}).get(name, 0):
    sys.exit(f"error: try {tries + 1} of {name} fails")
shutil.copytree("finished" / out.relative_to("results"), out, dirs_exist_ok=True, copy_function=shutil.copy)
