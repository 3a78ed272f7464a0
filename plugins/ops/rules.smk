# Runs in operation: who holds the folder, what is no longer as it was written, what containers see. No rules.
import atexit
import sys

from snakemake.settings.types import ExecMode

from roomkin.plugins.ops.verify import list_for_run, warn_of_changed
from roomkin.plugins.ops.guard import asks_for_run, hold_folder
from roomkin.plugins.ops.outside import container_environment
from roomkin.stages.contracts.errors import InputError

os.environ.pop("ACDC_ONLINE", None)
os.environ.update(container_environment(CONFIG, PUBLISHED))

if workflow.exec_mode == ExecMode.DEFAULT and not workflow.output_settings.dryrun and asks_for_run(sys.argv):
    try:
        LOCKED = hold_folder()
    except InputError as error:
        print(f"error: {error} [{error.code}]", file=sys.stderr)  # one line: Snakemake would add this file and its line
        sys.exit(1)
    RESULTS = Path("results").absolute()  # at the end Snakemake leaves the folder
    CHANGED = warn_of_changed(list_for_run(RESULTS), RESULTS)
    atexit.register(warn_of_changed, CHANGED, RESULTS)  # again beneath "Nothing to be done"
