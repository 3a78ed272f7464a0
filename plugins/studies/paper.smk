# `make paper`: the steps of paper.yaml, which make pages of docs/results again, all by one commit. No part of the workflow:
#   snakemake -n --snakefile plugins/studies/paper.smk --directory results/paper      says what is left to do.
# Writes: results/paper/<commit>/<step>.done and <step>.log, what the step printed.
import subprocess
from pathlib import Path

import yaml
from snakemake.exceptions import WorkflowError

HERE = Path(workflow.basedir)
STEPS = yaml.safe_load((HERE / "paper.yaml").read_text(encoding="utf-8"))
# The last commit that changed more than pages; nothing where files differ from it.
CODE = ". ':!docs' ':!*.md'"
READ_COMMIT = f"git diff --quiet HEAD -- {CODE} && git log -1 --format=%h -- {CODE}"
COMMIT = subprocess.run(READ_COMMIT, shell=True, cwd=HERE.parents[1], capture_output=True, text=True).stdout.strip()


onstart:
    if not COMMIT:
        raise WorkflowError(
            "files differ from the last commit, which results would name. Fix: git commit, or git stash"
        )


rule paper:
    """Every step."""
    input:
        expand("{commit}/{step}.done", commit=COMMIT or "files-differ", step=STEPS),


rule step:
    """Run a step; it counts if no code changed meanwhile."""
    input:
        lambda wildcards: expand("{{commit}}/{step}.done", step=STEPS[wildcards.step].get("after", [])),
    output:
        touch("{commit}/{step}.done"),
    log:
        "{commit}/{step}.log",
    threads: workflow.cores
    params:
        root=HERE.parents[1],
        command=lambda wildcards: STEPS[wildcards.step]["run"],
        read_commit=READ_COMMIT,
    shell:
        "export COMMIT={wildcards.commit}; (cd {params.root:q} && {params.command} && "
        '[ "$({params.read_commit})" = $COMMIT ] || ! echo "error: {wildcards.step} failed, or code changed meanwhile") '
        "2>&1 | tee {log:q}"
