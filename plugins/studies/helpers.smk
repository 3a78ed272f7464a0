# Helpers: what is rolled out under other conditions. No rules.
from snakemake.exceptions import WorkflowError


def under_conditions(skill, policy):
    """The files of both patterns for every condition and all that its simulator has."""

    def found(wildcards):
        if not CONFIG.evaluation.conditions:
            raise WorkflowError("evaluation.conditions: is empty. Fix: name some, e.g. {mujoco: {simulator: mujoco}}")
        files = []
        for name in CONFIG.evaluation.conditions:
            targets = CONFIG.targets_under(name)
            files += expand(skill, condition=name, target=[target for target in TRAINED_TARGETS if target in targets])
            for cell in (cell for cell in EXPERIMENT.cells if cell.target in targets):
                files += policies_of(cell, policy, condition=name)
        return files

    return found
