# Helpers: what is rolled out under other conditions. Nothing here makes a file.


def under_conditions(wildcards):
    """The rollouts of all skills and policies under every condition whose simulator has their task."""
    if not CONFIG.evaluation.conditions:
        raise WorkflowError("evaluation.conditions: is empty. Fix: name some, e.g. {mujoco: {simulator: mujoco}}")
    found = []
    for condition in CONFIG.evaluation.conditions:
        simulator = CONFIG.evaluation.under(condition).simulator
        targets = [name for name in TARGETS if CONFIG.simulated(name, simulator)]
        found += demonstrated(rules.skill_under.output.rollouts, targets, condition=condition)
        for cell in EXPERIMENT.cells:
            if cell.target in targets:
                found += policies_of(cell, rules.rollout_under.output.rollouts, condition=condition)
    return found
