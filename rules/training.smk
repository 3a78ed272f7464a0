# Policies: BC-RNN-GMM on point clouds (paper B.3).
# Reads:  the demonstrations of a training set.
# Writes: results/training/<target>/<policy>/<training set>/<run>/seed_<n>/{policy,last}.safetensors,
#         .../{checkpoints.zip,config.json,metrics.jsonl}.


container: CONFIG.containers.learning


rule train:
    """Train one policy."""
    input:
        episodes=expand("results/demonstrations/{target}/{role}/episodes.h5", role=trained_roles, allow_missing=True),
    output:
        policy="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/policy.safetensors",
        last="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/last.safetensors",
        checkpoints="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/checkpoints.zip",
        config="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/config.json",
        metrics="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/metrics.jsonl",
    log:
        "logs/training/{target}_{policy}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/training/{target}_{policy}_{training_set}_{run}_{seed}.tsv"
    resources:
        **needs(3000, training_minutes, gpu=True),
    params:
        **command("training", "train", uses=policy_modules, policy="config", metrics="metrics"),
        task=task,
        share=lambda wildcards: EXPERIMENT.share(wildcards.target, wildcards.training_set),
        device=CONFIG.device,
        out=subpath(output.policy, parent=True),
    shell:
        "({params.command} --episodes {input.episodes:q} --per-store {params.share} --task {params.task} --options {params.options:q} "
        "--seed {wildcards.seed} --threads {threads} --device {params.device} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule training:
    """All policies of this run, and what packages say of how their trainings ended."""
    input:
        policies("results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/policy.safetensors"),
        TRAININGS,
    localrule: True
