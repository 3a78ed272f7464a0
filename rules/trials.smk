# Trials of policies on the twin, which choose checkpoints and hyper-parameter sets (verbs of `evaluation`; paper B.3, B.4).
# If a policy has more runs than `experiment.best_runs`, each is trained with the first seed and tried on the twin;
# when `choose` has named the best, Snakemake knows which policies to train with all seeds and to roll out on all test assets.
# Reads:  policies and the assets of targets.
# Writes: results/evaluation/trials/<target>/<policy>/<training set>/{<run>/seed_<n>/rollouts.csv,chosen.json}.


rule trial:
    """Roll the checkpoints of one policy out on the twin, from states that no test uses."""
    input:
        **LIBRARY,
        policy=rules.train.output.policy,
        last=rules.train.output.last,
        checkpoints=rules.train.output.checkpoints,
        config=rules.train.output.config,
        assets=lambda wildcards: target_assets(wildcards.target),
    output:
        rollouts="results/evaluation/trials/{target}/{policy}/{training_set}/{run}/seed_{seed}/rollouts.csv",
    log:
        "logs/evaluation/trial_{target}_{policy}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/evaluation/trial_{target}_{policy}_{training_set}_{run}_{seed}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(4000, lambda wildcards: 15 + trials(wildcards.run) / 10, gpu=True),
    params:
        command=command("evaluation", "trial"),
        code=policy_code("trial"),
        check=check(rollouts="rollouts"),
        options=options("evaluation", "trial"),
        seed=CONFIG.seed,
        device=CONFIG.device,
        folder=subpath(input.policy, parent=True),
    shell:
        "({params.command} --policy {params.folder:q} --assets {input.assets:q} --library {input.library:q} "
        "--target {wildcards.target} --policy-name {wildcards.policy} --training-set {wildcards.training_set} "
        "--run-name {wildcards.run} --options {params.options:q} --seed {params.seed} --device {params.device} --out {output.rollouts:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


checkpoint choose:
    """Choose the hyper-parameter sets of one training set by their trials."""
    input:
        trials=lambda wildcards: files(
            rules.trial.output.rollouts,
            run=EXPERIMENT.plan(wildcards.policy).runs,
            seed=EXPERIMENT.plan(wildcards.policy).seeds[0],
            **wildcards,
        ),
    output:
        chosen="results/evaluation/trials/{target}/{policy}/{training_set}/chosen.json",
    log:
        "logs/evaluation/choose_{target}_{policy}_{training_set}.log",
    localrule: True
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("evaluation", "choose"),
        code=code("evaluation", "choose"),
        check=check(chosen="chosen"),
        best=EXPERIMENT.best_runs,
    shell:
        "({params.command} --trials {input.trials:q} --count {params.best} --out {output.chosen:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
