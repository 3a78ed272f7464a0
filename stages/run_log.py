"""What a run of the workflow prints: a line for each job, and what is wrong; all of Snakemake's own with VERBOSE=1.

A logger plugin of Snakemake, which `profiles/default` registers. Bars and doubts are printed by the jobs themselves.
"""

import os
import sys
from logging import LogRecord

from snakemake.logging import ColorizingTextHandler, DefaultFilter, DefaultFormatter
from snakemake.settings.enums import Quietness
from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent
from snakemake_interface_logger_plugins.registry import LoggerPluginRegistry

NAME = "roomkin"
SILENT = {LogEvent.WORKFLOW_STARTED, LogEvent.SHELLCMD, LogEvent.JOB_STARTED, LogEvent.GROUP_INFO,
          LogEvent.RESOURCES_INFO, LogEvent.DEBUG_DAG, LogEvent.RULEGRAPH}  # fmt: skip
# How lines begin that Snakemake prints in every run, or beside a failure that is told.
CHATTER = (
    "Assuming unrestricted", "At least one job did not complete", "Building DAG", "Complete log", "Conda environments",
    "Config file ", "DAG of jobs will be updated", "Exiting because a job execution failed", "Group jobs: inactive",
    "Provided ", "Removing temporary", "Rules claiming", "Select jobs", "Shutting down, this", "Singularity containers",
    "Storing output", "Updating checkpoint", "Using ", "WorkflowError:\nAt least one job did not complete",
)  # fmt: skip


def register() -> bool:
    """Make the logger known to Snakemake; False: its own words are wanted (VERBOSE=1)."""
    LoggerPluginRegistry().register_plugin(f"snakemake_logger_plugin_{NAME}", sys.modules[__name__])
    return not os.environ.get("VERBOSE")


class LogHandler(LogHandlerBase):
    """Prints a line as each job ends: how many have, what it was, of what, and how long it took."""

    writes_to_stream = True
    writes_to_file = False
    has_filter = True
    has_formatter = True
    needs_rulegraph = False

    def __post_init__(self) -> None:
        wanted, self.started, self.ended = self.common_settings, dict[int, tuple[str, float]](), list[str]()
        self.stream = sys.stdout if wanted.stdout else sys.stderr
        self.plain: ColorizingTextHandler | None = None
        if wanted.dryrun or wanted.verbose or wanted.debug_dag or wanted.printshellcmds:
            told = DefaultFilter(wanted.quiet, wanted.debug_dag, wanted.verbose, wanted.dryrun, wanted.printshellcmds)
            form = DefaultFormatter(wanted.quiet, wanted.show_failed_logs)
            self.plain = ColorizingTextHandler(wanted.nocolor, self.stream, form, told)

    def emit(self, record: LogRecord) -> None:
        """Print what a record says, if anything."""
        if self.plain:
            self.plain.handle(record)
        elif line := self._describe(record):
            over_bar = "\r\033[K" if self.stream.isatty() else ""
            print(f"{over_bar}{line}", file=self.stream, flush=True)

    def _describe(self, record: LogRecord) -> str:
        event, told, quiet = getattr(record, "event", None), vars(record), self.common_settings.quiet or ()
        if Quietness.ALL in quiet:
            return ""
        if event == LogEvent.RUN_INFO:
            return "" if quiet else f"{told['stats'].get('total', 0)} jobs, a line as each ends"
        if event == LogEvent.JOB_INFO:
            words = [told["rule_name"].replace("_", " "), *map(str, told["wildcards"].values())]
            self.started[told["jobid"]] = " ".join(words), record.created
        elif event == LogEvent.JOB_FINISHED:
            name, began = self.started.pop(told["job_id"], ("", record.created))
            self.ended.append(f"{name}  {_describe_duration(record.created - began)}")
        elif event == LogEvent.PROGRESS:  # it follows the jobs that ended, and knows how many there are by now
            ended, self.ended, total = self.ended, [], told["total"]
            first = told["done"] - len(ended) + 1
            lines = [f"[{number:{len(str(total))}}/{total}] {line}" for number, line in enumerate(ended, first)]
            return "" if quiet else "\n".join(lines)
        elif event == LogEvent.JOB_ERROR:
            name, began = self.started.pop(told["jobid"], (told["rule_name"], record.created))
            logs = f"; its log: {', '.join(told['log'])}" if told["log"] else ""
            return f"FAILED {name}  {_describe_duration(record.created - began)}{logs}"
        elif event not in SILENT and not (text := record.getMessage()).startswith(CHATTER):
            return text.strip("\n")
        return ""


def _describe_duration(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    return f"{seconds // 60:.0f} min {seconds % 60:.0f} s" if seconds < 3600 else f"{seconds / 3600:.1f} h"
