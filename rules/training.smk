# Policies: BC-RNN-GMM on point clouds (paper B.3).
# Reads:  the demonstrations of a training set.
# Writes: results/training/<task>/<training set>/<run>/seed_<n>/{policy,last}.safetensors,
#         .../{checkpoints.zip,config.json,metrics.jsonl}.


rule train:
    """Train one policy."""
    input:
        episodes=lambda wildcards: files(
            rules.demonstrate.output.episodes,
            task=EXPERIMENT.source(wildcards.task),
            role=EXPERIMENT.roles(wildcards.training_set, int(wildcards.seed)),
        ),
    output:
        policy="results/training/{task}/{training_set}/{run}/seed_{seed}/policy.safetensors",
        last="results/training/{task}/{training_set}/{run}/seed_{seed}/last.safetensors",
        checkpoints="results/training/{task}/{training_set}/{run}/seed_{seed}/checkpoints.zip",
        config="results/training/{task}/{training_set}/{run}/seed_{seed}/config.json",
        metrics="results/training/{task}/{training_set}/{run}/seed_{seed}/metrics.jsonl",
    log:
        "logs/training/{task}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/training/{task}_{training_set}_{run}_{seed}.tsv"
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(4000, lambda wildcards: training_minutes(wildcards.run), gpu=True),
    params:
        command=command("training", "train"),
        code=lambda wildcards: code("training", "train", *modules(CONFIG.training.runs[wildcards.run], "policy")),
        check=check(policy="config", metrics="metrics"),
        options=options("training", "train"),
        task=lambda wildcards: implementation(wildcards.task),
        share=lambda wildcards: EXPERIMENT.share(wildcards.task, wildcards.training_set),
        device=CONFIG.device,
        out=subpath(output.policy, parent=True),
    shell:
        "({params.command} --episodes {input.episodes:q} --per-store {params.share} --task {params.task} --options {params.options:q} "
        "--seed {wildcards.seed} --threads {threads} --device {params.device} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule training:
    """All policies of this run."""
    input:
        policies(rules.train.output.policy),
    localrule: True
