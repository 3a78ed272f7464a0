# The scripted skill on what policies are rolled out on: what can be reached at best.
# Reads:  the assets of targets, the library.
# Writes: results/evaluation/skill/<target>/rollouts.csv.
from roomkin.stages.config.training import MotionOptions


container: CONFIG.containers.simulation


rule skill:
    """Do a task by the scripted skill on what its policies are rolled out on, from the same states."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        assets=f"results/experiment/{POLICY_VARIANT}/{{target}}/assets.json",
    output:
        rollouts="results/evaluation/skill/{target}/rollouts.csv",
    log:
        "logs/evaluation/skill_{target}.log",
    benchmark:
        "benchmarks/evaluation/skill_{target}.tsv"
    resources:
        **needs(3000, 15 + CONFIG.evaluation.episodes() / 10),
    params:
        **command("scripted", "skill", uses=skill_modules, rollouts="rollouts"),
        skill_options=CONFIG.demonstrations.model_dump_json(include=set(MotionOptions.model_fields)),
        task_options=task_options,
        seed=CONFIG.seed,
    shell:
        "({params.command} --assets {input.assets:q} --library {input.library:q} --target {wildcards.target} "
        "--options {params.options:q} --skill-options {params.skill_options:q} "
        "--task-options {params.task_options:q} --seed {params.seed} --out {output.rollouts:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


ADDED["skills"] += expand(rules.skill.output.rollouts, target=TRAINED_TARGETS)
