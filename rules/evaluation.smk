# Rollouts of the policies, one row each; nothing is aggregated here (paper B.3).
# Reads:  policies, their trials and the assets of targets.
# Writes: results/evaluation/policies/<target>/<policy>/<training set>/<run>/seed_<n>/{rollouts.csv,film.png,films.zip},
#         results/evaluation/policies/<target>/<policy>/<training set>/rollouts.csv,
#         results/evaluation/skill/<target>/rollouts.csv.


rule rollout:
    """Roll one policy out on the test roles and on unseen assets, from initial states that all policies share."""
    input:
        **LIBRARY,
        policy=rules.train.output.policy,
        last=rules.train.output.last,
        checkpoints=rules.train.output.checkpoints,
        config=rules.train.output.config,
        assets=lambda wildcards: target_assets(wildcards.target),
        trial=rules.trial.output.rollouts if CONFIG.evaluation.checkpoint == "rollouts" else [],
    output:
        **filmed(
            "evaluation",
            "rollout",
            "results/evaluation/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}",
            target="{target}",
            policy="{policy}",
            **{"training set": "{training_set}"},
            seed="{seed}",
        ),
        rollouts="results/evaluation/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv",
    log:
        "logs/evaluation/{target}_{policy}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/evaluation/{target}_{policy}_{training_set}_{run}_{seed}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(4000, 15 + tests() / 10, gpu=True),
    params:
        command=command("evaluation", "rollout"),
        code=policy_code("rollout"),
        check=check(rollouts="rollouts"),
        options=options("evaluation", "rollout"),
        seed=CONFIG.seed,
        device=CONFIG.device,
        folder=subpath(input.policy, parent=True),
        roles=lambda wildcards: EXPERIMENT.roles(wildcards.training_set, int(wildcards.seed)),
    shell:
        "({params.command} --policy {params.folder:q} --assets {input.assets:q} --library {input.library:q} "
        "--target {wildcards.target} --policy-name {wildcards.policy} --training-set {wildcards.training_set} "
        "--run-name {wildcards.run} --trained-roles {params.roles} --options {params.options:q} "
        "--trial {input.trial:q} --seed {params.seed} --device {params.device} --out {output.rollouts:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule skill:
    """Do a task by the scripted skill on what its policies are rolled out on, from the same states."""
    input:
        **LIBRARY,
        assets=lambda wildcards: target_assets(wildcards.target),
    output:
        rollouts="results/evaluation/skill/{target}/rollouts.csv",
    log:
        "logs/evaluation/skill_{target}.log",
    benchmark:
        "benchmarks/evaluation/skill_{target}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(3000, 15 + tests() / 10),
    params:
        command=command("evaluation", "skill"),
        code=lambda wildcards: code("evaluation", "skill", *tested(wildcards)),
        check=check(rollouts="rollouts"),
        options=options("evaluation", "skill"),
        skill_options=CONFIG.demonstrations.model_dump_json(include=set(MotionOptions.model_fields)),
        task_options=lambda wildcards: CONFIG.task_of(wildcards.target).model_dump_json(),
        seed=CONFIG.seed,
    shell:
        "({params.command} --assets {input.assets:q} --library {input.library:q} --target {wildcards.target} "
        "--options {params.options:q} --skill-options {params.skill_options:q} "
        "--task-options {params.task_options:q} --seed {params.seed} --out {output.rollouts:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule gather:
    """Put the rollouts of all policies of one cell into one table."""
    input:
        rollouts=lambda wildcards: policies_of(Cell(**wildcards), rules.rollout.output.rollouts),
    output:
        rollouts="results/evaluation/policies/{target}/{policy}/{training_set}/rollouts.csv",
    log:
        "logs/evaluation/gather_{target}_{policy}_{training_set}.log",
    localrule: True
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("evaluation", "gather"),
        code=code("evaluation", "gather"),
        check=check(rollouts="rollouts"),
    shell:
        "({params.command} --rollouts {input.rollouts:q} --out {output.rollouts:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule evaluation:
    """All scores and rollouts of this run."""
    input:
        files(rules.score.output.scores, variant=VARIANTS, scene=SCORED_ROOMS),
        policies(rules.rollout.output.rollouts),
        cells(rules.gather.output.rollouts),
        demonstrated(rules.skill.output.rollouts),
    localrule: True
