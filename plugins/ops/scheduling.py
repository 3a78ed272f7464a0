"""How jobs are submitted and looked up. This reaches into Snakemake 9.27, where it has no documented way.

What a later version has no longer is left out: runs are slower then, and say so.
"""

import atexit
import gc
import inspect
import sys
from typing import Any


def tune(workflow: Any) -> None:
    """After the last rule: one submission per scene where that is possible, functions looked up once."""
    try:
        if workflow.remote_exec:
            run_in_this_process(workflow)
        elif has_shells(workflow):
            ungroup(workflow)
        look_up_once(workflow)
    except AttributeError as error:
        print(f"note: this Snakemake is not as 9.27 ({error}): groups and look-ups are as it has them", file=sys.stderr)


def collect_less_garbage() -> None:
    """The graph of jobs only grows: looking through it for garbage, the last time at the end, is a third of a plan."""
    gc.freeze()
    gc.set_threshold(100_000, 100, 100)
    atexit.register(gc.freeze)


def ungroup(workflow: Any) -> None:
    """Let every job be a submission of its own."""
    for rule in workflow.rules:
        rule.group = None


def has_shells(workflow: Any) -> bool:
    """Whether a profile gives rules shells of their own, as profiles/podman does: jobs of a group must share one."""
    return any("shell_exec" in asked for asked in workflow.resource_settings.overwrite_resources.values())


def run_in_this_process(workflow: Any) -> None:
    """Let this Snakemake, which a node runs, run the jobs of its submission itself, not one more Snakemake for each."""
    ungroup(workflow)
    workflow.localrules(*(rule.name for rule in workflow.rules))


def look_up_once(workflow: Any) -> None:
    """Look a function's parameters up once: Snakemake asks for them with every job."""
    for rule in workflow.rules:
        for function in filter(inspect.isfunction, [*rule.input, *rule.params, rule.group]):
            function.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]


def lift_rate_limit(workflow: Any) -> None:
    """Let go of the limit of jobs per time span, if all run on this machine, where cores limit them.

    With it Snakemake looks through all ready jobs once more in every span for every job that has ended: with hundreds
    of scenes that takes as long as the jobs themselves.
    """
    if workflow.local_exec and hasattr(workflow.scheduler, "job_rate_limiter"):
        workflow.scheduler.job_rate_limiter = None
