#!/usr/bin/env bash
# The cells of config/study/second.yaml in the order of docs/results/design-second.md; what is there is not made again.
cd "$(dirname "$0")/../.." || exit
CONFIGS=(config.yaml config/study/second.yaml)

# run FOLDER SEED: a run of all training sets, object by object, doors and drawers in turns.
run() {
    for object in $(seq -w 1 24); do for task in door drawer; do
        cells=()
        for set in random_8 cousins_8 cover_8 twin_randomised; do
            cells+=("results/evaluation/$1/${task}_$object/lite/$set/lite/seed_$2/rollouts.csv")
        done
        workflow "${cells[@]}"
    done; done
}

workflow() {
    snakemake --cores "${CORES:-2}" --keep-going --configfile "${CONFIGS[@]}" -- "$@"
}

for seed in 0 1; do
    run policies $seed
    run conditions/mujoco $seed
    run conditions/mujoco_depth_noise $seed
done
workflow results/evaluation/skill/{door,drawer}_{01..24}/rollouts.csv
python -m plugins.studies sets --configs "${CONFIGS[@]}" --forecast docs/results/second/forecast.csv --out docs/results/second
