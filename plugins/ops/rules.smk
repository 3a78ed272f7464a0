# Runs in operation: who holds the folder, what containers see. No rules.
import sys

from snakemake.exceptions import WorkflowError
from snakemake.settings.types import ExecMode

from plugins.ops.guard import asks_for_run, hold_folder
from plugins.ops.outside import container_environment
from stages.contracts.errors import InputError

os.environ.pop("ACDC_ONLINE", None)
os.environ.update(container_environment(CONFIG, PUBLISHED))

if workflow.exec_mode == ExecMode.DEFAULT and not workflow.output_settings.dryrun and asks_for_run(sys.argv):
    try:
        LOCKED = hold_folder()
    except InputError as error:
        raise WorkflowError(f"{error} [{error.code}]") from None
