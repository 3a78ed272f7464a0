# ACDC (Dai et al., CoRL 2024): one RGB image -> digital cousins -> demonstrations -> policies -> the paper's tables.
#   snakemake --cores 2 all        everything that config.yaml asks for, ending in results/report/index.html
#   snakemake --cores 2 tables     the tables; likewise: table2, library, scenes, scenes8, extraction, matching, generation,
#                                  demonstrations, training, evaluation, figures, report; exports: data for other tools
#   snakemake --cores 2 photo --config image=color.png depth=depth.png camera=intrinsics.json    a frame of yours;
#                                  without depth by networks, fetch: the weights that they need
from pathlib import Path

from snakemake.utils import min_version

min_version("9.27")


# That of the working directory, if there is one; without any, ours.
configfile: next(filter(Path.exists, map(Path, ["config.yaml", "config/config.yaml"])), workflow.source_path("config.yaml"))


include: "rules/common.smk"
include: "rules/resources.smk"
include: "rules/inputs.smk"
include: "rules/implementations.smk"
include: "rules/assets.smk"
include: "rules/frames.smk"
include: "rules/perception.smk"
include: "rules/extraction.smk"
include: "rules/matching.smk"
include: "rules/generation.smk"
include: "rules/experiment.smk"
include: "rules/demonstrations.smk"
include: "rules/training.smk"
include: "rules/selection.smk"
include: "rules/scores.smk"
include: "rules/evaluation.smk"
include: "rules/tables.smk"


for file in rule_files(CONFIG.packages):

    include: file


rule all:
    """Everything: scenes, policies, tables, figures and the report page."""
    default_target: True
    input:
        # What lies between, too: where only that is missing, as after a failed job, Snakemake finds nothing to do.
        rules.extraction.input + rules.matching.input + rules.generation.input,
        rules.experiment.input + rules.demonstrations.input + rules.training.input + rules.evaluation.input,
        rules.tables.input,
        ADDED["all"],
    localrule: True


# On a node of a cluster this Snakemake runs the jobs of its submission itself, not one more Snakemake for each by srun.
if workflow.remote_exec:
    for each in workflow.rules:
        each.group = None
    workflow.localrules(*(each.name for each in workflow.rules))
