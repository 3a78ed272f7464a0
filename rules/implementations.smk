# Helpers: implementations whose code counts beside that of a command, as modules. Functions of a job's wildcards. No rules.
from roomkin.stages.config.names import modules
from roomkin.stages.plugins import qualify_module


def store_modules(wildcards):
    """The encoder of a feature store."""
    return modules(STORES[wildcards.store], "encoder")


def matching_modules(*keys):
    """What these keys of `matching` name for a variant."""
    return lambda wildcards: modules(MATCHING[wildcards.variant], *keys)


def task_modules(wildcards):
    """The task of a target."""
    return [qualify_module("tasks", task(wildcards))]


def policy_modules(wildcards):
    """The kind of policy of a config."""
    return modules(CONFIG.training.configs[wildcards.run], "policy")


def skill_modules(wildcards):
    """The task of a target, and its simulator."""
    condition = wildcards.get("condition")
    simulator = (CONFIG.evaluation.under(condition) if condition else CONFIG.evaluation).simulator
    return [*task_modules(wildcards), qualify_module("simulators", simulator)]


def rollout_modules(wildcards):
    """The same, and the kind of policy."""
    return [*skill_modules(wildcards), *policy_modules(wildcards)]


def with_films(stage, of):
    """The modules that `of` gives, and those that film what a stage does."""
    return lambda wildcards: [*of(wildcards), *FILMS[stage]]
