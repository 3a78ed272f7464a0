# Policies and skills under the conditions of `evaluation.conditions`, paired with the usual rollouts. No part of `all`.
# Reads:  what rollouts read.
# Writes: results/evaluation/conditions/<condition>/<target>/{<policy>/<training set>/<run>/seed_<n>,skill}/rollouts.csv,
#         results/tables/conditions.{csv,html,tex}.


include: "helpers.smk"
include: "open_rooms.smk"


container: CONFIG.containers.simulation


use rule rollout as rollout_under with:
    output:
        **unless_replaced(
            "evaluation",
            "rollout",
            film="results/evaluation/conditions/{condition}/{target}/{policy}/{training_set}/{run}/seed_{seed}/film.png",
            films="results/evaluation/conditions/{condition}/{target}/{policy}/{training_set}/{run}/seed_{seed}/films.zip",
        ),
        rollouts="results/evaluation/conditions/{condition}/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv",
    log:
        "logs/evaluation/{condition}_{target}_{policy}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/evaluation/{condition}_{target}_{policy}_{training_set}_{run}_{seed}.tsv"


use rule skill as skill_under with:
    output:
        rollouts="results/evaluation/conditions/{condition}/{target}/skill/rollouts.csv",
    log:
        "logs/evaluation/{condition}_skill_{target}.log",
    benchmark:
        "benchmarks/evaluation/{condition}_skill_{target}.tsv"


rule conditions:
    """Success of all policies and skills under every condition, and minus that under the usual one."""
    input:
        rollouts=expand("results/evaluation/policies/{target}/{policy}/{training_set}/rollouts.csv", zip, **CELLS),
        skills=expand("results/evaluation/skill/{target}/rollouts.csv", target=TRAINED_TARGETS),
        elsewhere=under_conditions(
            skill="results/evaluation/conditions/{condition}/{target}/skill/rollouts.csv",
            policy="results/evaluation/conditions/{condition}/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv",
        ),
    output:
        csv="results/tables/conditions.csv",
        html="results/tables/conditions.html",
        tex="results/tables/conditions.tex",
    log:
        "logs/tables/conditions.log",
    localrule: True
    container:
        CONFIG.containers.report
    resources:
        **needs(1000, 10),
    params:
        **command("studies", "conditions"),
        names=list(CONFIG.evaluation.conditions),
        out=subpath(output.csv, parent=True),
    shell:
        "{params.command} --rollouts {input.rollouts:q} {input.skills:q} --elsewhere {input.elsewhere:q} --names {params.names:q} "
        "--options {params.options:q} --out {params.out:q} 2>&1 | tee {log:q}"


rule pinned:
    """Take the assets of a target from a committed file, if the library has the very same models."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        assets=lambda wildcards: PINNED[wildcards.target],
    output:
        assets="results/experiment/{variant}/{target}/assets.json",
    log:
        "logs/experiment/pinned_{variant}_{target}.log",
    benchmark:
        "benchmarks/experiment/{variant}_{target}.tsv"
    wildcard_constraints:
        target="|".join(PINNED) or "-",
    localrule: True
    container:
        CONFIG.containers.learning
    resources:
        **needs(1000, 10),
    params:
        **command("studies", "pinned", uses=task_modules, task="assets"),
        task=task,
    shell:
        "({params.command} --assets {input.assets:q} --task {params.task} --library {input.library:q} "
        "--out {output.assets:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
