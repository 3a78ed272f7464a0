"""What a run says on the terminal: a line when a job starts, one when it has ended.

Snakemake's own log file, and a dry run (-n), have all of a job's files, resources and reasons.
"""

import logging
import os
import re
import time
from collections.abc import Collection
from typing import Any

from snakemake.logging import ColorizingTextHandler, DefaultFormatter, format_percentage, format_wildcards, logger
from snakemake.settings.types import ExecMode

from stages.contracts.errors import suggest_nearest

SAYS_NOTHING = (
    "Select jobs to execute",
    "Execute ",
    "Using shell: ",
    "Rules claiming more threads",
    "Singularity cont",
)
PADDING = "Union of exclusive params before and now across all output: "
EVERY_JOB = ("Missing output files", "Input files updated by another job")  # reasons that each job of a first run has


class Brief(DefaultFormatter):
    """Snakemake's messages with a line for a job's start and one for its end; failures are shown in full."""

    def __init__(self, like: Any, dryrun: bool) -> None:
        super().__init__(like.quiet, like.show_failed_logs)
        self.dryrun = dryrun
        self.jobs: dict[int, str] = {}
        self.ended: list[str] = []

    def format_workflow_started(self, message: dict[str, Any]) -> str:
        files = ", ".join(map(str, message["configfiles"]))
        return f"Snakemake {message['snakemake_version']} in {message['cwd']}, config: {files}"

    def format_job_info(self, message: dict[str, Any]) -> str:
        if self.dryrun:
            return "\n" + super().format_job_info(message)
        name = f"{message['rule_name']} {format_wildcards(message['wildcards'])}".rstrip()
        written = os.path.commonpath(message["output"]) if message["output"] else ""
        self.jobs[message["jobid"]] = f"{name} -> {written}" if written else name
        reasons = [each for each in str(message["reason"]).split("; ") if not each.startswith(EVERY_JOB)]
        because = " ".join("; ".join(reasons).replace(PADDING, "").split())[:200] if message["output"] else ""
        log = f", log: {', '.join(message['log'])}" if message["log"] else ""
        why = f", because: {because}" if because else ""
        return f"{'    ' * bool(message.get('indent'))}{format_time()} {name}{log}{why}"

    def format_job_finished(self, message: dict[str, Any]) -> str:
        self.ended.append(self.jobs.get(message["job_id"], message["msg"]))
        return ""  # the next message says how far the run is

    def format_progress(self, message: dict[str, Any]) -> str:
        ended, self.ended = "; ".join(self.ended), []
        percent = format_percentage(message["done"], message["total"])
        return f"{format_time()} {message['done']} of {message['total']} steps ({percent}) done: {ended}"


class Lines(ColorizingTextHandler):
    """The handler of the terminal, which else puts an empty line before every job."""

    last_msg_was_job_info = property(lambda self: True, lambda self, value: None)


def format_time() -> str:
    return time.strftime("[%H:%M:%S]")


def tell_nearest(record: logging.LogRecord, targets: Collection[str]) -> bool:
    """Let Snakemake say of a target that is no rule which one may be meant; it only says that there is none."""
    unknown = re.match(r"MissingRuleException:\nNo rule to produce (\w+) ", str(record.msg))
    if unknown:
        fix = suggest_nearest(unknown[1], targets).partition("there are")[0]
        record.msg = f"error: {unknown[1]}: no such target. Fix: {fix or 'docs/running.md lists them'}"
    return True


def tell_briefly(workflow: Any) -> None:
    """Let a run that was started here say less; jobs on other machines and workflows that have ours as a module do not.

    Tried with Snakemake 9.27.
    """
    if workflow.exec_mode != ExecMode.DEFAULT or not workflow.modifier.is_main_snakefile():
        return
    logger.addFilter(lambda record: tell_nearest(record, [rule.name for rule in workflow.rules]))
    for handler in [each for each in logger.handlers if each.name == "DefaultStreamHandler"]:
        brief = Lines(
            handler.nocolor,
            handler.stream,
            Brief(handler.formatter, workflow.output_settings.dryrun),
            handler.filters[0],
        )
        brief.addFilter(lambda record: not str(record.msg).startswith(SAYS_NOTHING))
        brief.name = handler.name
        logger.removeHandler(handler)
        logger.addHandler(brief)
