# How trainings ended, before any rollout. What else this package says stands in the files of the rule `table3`.
# Reads:  config.json of the policies.
# Writes: results/tables/trainings.{csv,html,tex}.


rule trainings:
    """How every training ended, and which failed, before any rollout."""
    input:
        configs=policies("results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/config.json"),
    output:
        csv="results/tables/trainings.csv",
        html="results/tables/trainings.html",
        tex="results/tables/trainings.tex",
    log:
        "logs/tables/trainings.log",
    localrule: True
    container:
        CONFIG.containers.report
    resources:
        **needs(1000, 10),
    params:
        **command("claims", "trainings"),
        out=subpath(output.csv, parent=True),
    shell:
        "{params.command} --policies {input.configs:q} --out {params.out:q} 2>&1 | tee {log:q}"


ADDED["all"] += [rules.trainings.output]
