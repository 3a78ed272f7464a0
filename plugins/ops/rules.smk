# Runs in operation: who holds the folder, what the terminal shows, how jobs are submitted, what containers see. No rules.
import sys

from snakemake.exceptions import WorkflowError
from snakemake.settings.types import ExecMode

from plugins.ops.guard import hold_folder, asks_for_run
from plugins.ops.outside import container_environment
from plugins.ops.scheduling import collect_less_garbage, lift_rate_limit, tune
from stages.contracts.errors import InputError

collect_less_garbage()

os.environ.pop("ACDC_ONLINE", None)
os.environ.update(container_environment(CONFIG, PUBLISHED))

if workflow.exec_mode == ExecMode.DEFAULT and not workflow.output_settings.dryrun and asks_for_run(sys.argv):
    try:
        LOCKED = hold_folder()
    except InputError as error:
        raise WorkflowError(f"{error} [{error.code}]") from None


onstart:
    lift_rate_limit(workflow)


try:
    from plugins.ops.terminal import tell_briefly

    tell_briefly(workflow)
except (ImportError, AttributeError, LookupError) as error:
    print(f"note: this Snakemake is not as 9.27 ({error}): it speaks for itself", file=sys.stderr)

tune(workflow)
