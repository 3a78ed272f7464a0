# Scores of the generated scenes, one row per object, and what matching does without (verbs of `evaluation`; paper B.1).
# Reads:  generated scenes and the truth of their rooms; the library.
# Writes: results/evaluation/scenes/<variant>/<scene>/scores.csv, results/evaluation/left_out/<scene>.json.


rule leave_out:
    """Name the true models of a room with all their relatives, for matching to do without."""
    input:
        **LIBRARY,
        truth=truth_of,
    output:
        assets="results/evaluation/left_out/{scene}.json",
    log:
        "logs/evaluation/left_out_{scene}.log",
    group:
        of_scene
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("evaluation", "leave_out"),
        code=code("evaluation", "leave_out"),
    shell:
        "{params.command} --truth {input.truth:q} --library {input.library:q} --out {output.assets:q} 2>&1 | tee {log:q}"


rule score:
    """Compare the generated scenes of one room with its truth."""
    input:
        **LIBRARY,
        scenes=rules.generate.output.scenes,
        cousins=rules.match.output.cousins,
        objects=rules.extract.output.objects,
        truth=truth_of,
    output:
        scores="results/evaluation/scenes/{variant}/{scene}/scores.csv",
    log:
        "logs/evaluation/{variant}_{scene}.log",
    benchmark:
        "benchmarks/evaluation/{variant}_{scene}.tsv"
    group:
        of_scene
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("evaluation", "score"),
        code=code("evaluation", "score"),
        check=check(scores="scores"),
        protocol=lambda wildcards: EXPERIMENT.meeting(wildcards.scene).name,
        draw=seed_of,
    shell:
        "({params.command} --scenes {input.scenes:q} --objects {input.objects:q} --truth {input.truth:q} "
        "--library {input.library:q} --cousins {input.cousins:q} --protocol '{params.protocol}' --draw {params.draw} "
        "--out {output.scores:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
