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


# Sections of the paper that a file follows.
include: "rules/common.smk"
include: "rules/resources.smk"
include: "rules/inputs.smk"
include: "rules/implementations.smk"
include: "rules/assets.smk"  # A.1: models and their snapshots
include: "rules/frames.smk"  # A.2: pictures with depth
include: "rules/perception.smk"  # A.2: what a picture shows
include: "rules/extraction.smk"  # A.2, A.7: objects in space
include: "rules/matching.smk"  # A.6, A.7: digital cousins
include: "rules/generation.smk"  # A.3, A.7: scenes
include: "rules/experiment.smk"  # B.3, B.4: twin, cousins, test assets
include: "rules/demonstrations.smk"  # A.4, A.5
include: "rules/training.smk"  # B.3: policies
include: "rules/selection.smk"  # B.3, B.4: by rollouts on the twin
include: "rules/scores.smk"  # B.1: scenes, Table 2
include: "rules/evaluation.smk"  # B.3, B.4: rollouts, Table 3
include: "rules/tables.smk"  # tables and figures beside the paper's


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
