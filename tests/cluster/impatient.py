"""Snakemake that asks SLURM every second: by itself the plugin waits ten seconds longer after each look in vain."""

import sys

from snakemake.cli import main
from snakemake_executor_plugin_slurm import Executor

Executor.next_seconds_between_status_checks = property(lambda self: 1, lambda self, seconds: None)
sys.exit(main())
