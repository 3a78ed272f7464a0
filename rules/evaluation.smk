# Rollouts of the policies, one row each; nothing is aggregated here (paper B.3).
# Reads:  policies, their selection rollouts and the assets of targets.
# Writes: results/evaluation/policies/<target>/<policy>/<training set>/<run>/seed_<n>/{rollouts.csv,film.png,films.zip},
#         results/evaluation/policies/<target>/<policy>/<training set>/rollouts.csv.


container: CONFIG.containers.simulation


rule rollout:
    """Roll one policy out on the test roles and on unseen assets, from initial states that all policies share."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        policy="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/policy.safetensors",
        last="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/last.safetensors",
        checkpoints="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/checkpoints.zip",
        config="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/config.json",
        assets=f"results/experiment/{POLICY_VARIANT}/{{target}}/assets.json",
        selection=(
            "results/evaluation/selection/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv"
            if CONFIG.evaluation.checkpoint == "rollouts"
            else []
        ),
    output:
        **unless_replaced(
            "evaluation",
            "rollout",
            film="results/evaluation/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}/film.png",
            films="results/evaluation/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}/films.zip",
        ),
        rollouts="results/evaluation/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv",
    log:
        "logs/evaluation/{target}_{policy}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/evaluation/{target}_{policy}_{training_set}_{run}_{seed}.tsv"
    resources:
        **needs(3000, 15 + CONFIG.evaluation.episodes() / 10, gpu=True),
    params:
        **command("evaluation", "rollout", uses=with_films("evaluation", rollout_modules), rollouts="rollouts"),
        seed=CONFIG.seed,
        device=CONFIG.device,
        folder=subpath(input.policy, parent=True),
        roles=trained_roles,
        films=FILMS["evaluation"],
    shell:
        "({params.command} --policy {params.folder:q} --assets {input.assets:q} --library {input.library:q} "
        "--target {wildcards.target} --policy-name {wildcards.policy} --training-set {wildcards.training_set} "
        "--run-name {wildcards.run} --trained-roles {params.roles} --options {params.options:q} "
        "--selection {input.selection:q} --films {params.films:q} --seed {params.seed} --device {params.device} --out {output.rollouts:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule merge:
    """Put the rollouts of all policies of one cell into one table."""
    input:
        rollouts=lambda wildcards: policies_of(
            Cell(**wildcards),
            "results/evaluation/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv",
        ),
    output:
        rollouts="results/evaluation/policies/{target}/{policy}/{training_set}/rollouts.csv",
    log:
        "logs/evaluation/merge_{target}_{policy}_{training_set}.log",
    localrule: True
    container:
        CONFIG.containers.learning
    resources:
        **needs(1000, 10),
    params:
        **command("evaluation", "merge", rollouts="rollouts"),
    shell:
        "({params.command} --rollouts {input.rollouts:q} --out {output.rollouts:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule evaluation:
    """All scores and rollouts of this run."""
    input:
        expand("results/evaluation/scenes/{variant}/{room}/scores.csv", variant=VARIANTS, room=SCORED_ROOMS),
        policies("results/evaluation/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv"),
        expand("results/evaluation/policies/{target}/{policy}/{training_set}/rollouts.csv", zip, **CELLS),
        added("skills"),
    localrule: True
