# Rollouts on the twin that select checkpoints and policy configs (commands of `evaluation`; paper B.3, B.4).
# If a policy has more configs than `experiment.best_configs`, each is trained with the first seed and rolled out on the twin;
# when `choose` has named the best, Snakemake knows which policies to train with all seeds and to roll out on all test assets.
# Reads:  policies and the assets of targets.
# Writes: results/evaluation/selection/<target>/<policy>/<training set>/{<run>/seed_<n>/rollouts.csv,chosen.json}.


container: CONFIG.containers.learning


rule selection_rollout:
    """Roll the checkpoints of one policy out on the twin, from states that no test uses."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        policy="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/policy.safetensors",
        last="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/last.safetensors",
        checkpoints="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/checkpoints.zip",
        config="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/config.json",
        assets=f"results/experiment/{POLICY_VARIANT}/{{target}}/assets.json",
    output:
        rollouts="results/evaluation/selection/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv",
    log:
        "logs/evaluation/selection_{target}_{policy}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/evaluation/selection_{target}_{policy}_{training_set}_{run}_{seed}.tsv"
    container:
        CONFIG.containers.simulation
    resources:
        **needs(3000, lambda wildcards: 15 + selection_episodes(wildcards) / 10, gpu=True),
    params:
        **command("evaluation", "selection-rollout", uses=rollout_modules, rollouts="rollouts"),
        seed=CONFIG.seed,
        device=CONFIG.device,
        folder=subpath(input.policy, parent=True),
    shell:
        "({params.command} --policy {params.folder:q} --assets {input.assets:q} --library {input.library:q} "
        "--target {wildcards.target} --policy-name {wildcards.policy} --training-set {wildcards.training_set} "
        "--run-name {wildcards.run} --options {params.options:q} --seed {params.seed} --device {params.device} --out {output.rollouts:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


checkpoint choose:
    """Choose the configs of one training set by their selection rollouts."""
    input:
        rollouts=expand(
            "results/evaluation/selection/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv",
            run=lambda wildcards: EXPERIMENT.plan(wildcards.policy).configs,
            seed=lambda wildcards: EXPERIMENT.plan(wildcards.policy).seeds[0],
            allow_missing=True,
        ),
    output:
        chosen="results/evaluation/selection/{target}/{policy}/{training_set}/chosen.json",
    log:
        "logs/evaluation/choose_{target}_{policy}_{training_set}.log",
    localrule: True
    resources:
        **needs(1000, 10),
    params:
        **command("evaluation", "choose", chosen="chosen"),
        best=EXPERIMENT.best_configs,
    shell:
        "({params.command} --rollouts {input.rollouts:q} --count {params.best} --out {output.chosen:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
