# Robustness variants of the rooms (experiment.protocols): their table, and what matching does without.
# Reads:  scores of generated scenes, the truth of rooms, the library.
# Writes: results/tables/table2_robustness.{csv,html,tex}, results/evaluation/left_out/<scene>.json.


container: CONFIG.containers.learning


rule leave_out:
    """Name the true models of a room with all their relatives, for matching to do without."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        truth=expand("results/scenes/{room}/truth.json", room=known_scene),
    output:
        assets="results/evaluation/left_out/{scene}.json",
    log:
        "logs/evaluation/left_out_{scene}.log",
    group:
        scene_group
    resources:
        **needs(1000, 10),
    params:
        **command("robustness", "leave_out"),
    shell:
        "{params.command} --truth {input.truth:q} --library {input.library:q} --out {output.assets:q} 2>&1 | tee {log:q}"


rule table2_robustness:
    """The companion of Table 2: its rooms changed, and drawn anew."""
    input:
        scores=expand("results/evaluation/scenes/{variant}/{room}/scores.csv", variant=VARIANTS, room=SCORED_ROOMS),
        robustness=expand("results/evaluation/scenes/{variant}/{scene}/scores.csv", zip, **PERTURBED_SCENES),
    output:
        csv="results/tables/table2_robustness.csv",
        html="results/tables/table2_robustness.html",
        tex="results/tables/table2_robustness.tex",
    log:
        "logs/tables/table2_robustness.log",
    localrule: True
    container:
        CONFIG.containers.report
    resources:
        **needs(1000, 10),
    params:
        **command("robustness", "table"),
        out=subpath(output.csv, parent=True),
    shell:
        "{params.command} --scores {input.scores:q} {input.robustness:q} --out {params.out:q} 2>&1 | tee {log:q}"


ADDED["table2"] += rules.table2_robustness.output
