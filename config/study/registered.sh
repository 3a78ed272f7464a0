#!/usr/bin/env bash
# The cells of config/study/registered.yaml in the order of docs/results/design.md; what is there is not made again.
cd "$(dirname "$0")/../.." || exit
CELLS=results/evaluation
CONFIGS=(config.yaml config/study/registered.yaml)

# run FOLDER POLICY SETS RUN SEEDS: the rollouts of a policy on the six objects; lists are separated by blanks.
run() {
    local cells=() ending=
    [[ $2 == lite_object ]] && ending=_object
    for seed in $5; do for set in $3; do for room in door_room_{1,2,3} drawer_room_{2,3,4}; do
        cells+=("$CELLS/$1/$room$ending/$2/$set/$4/seed_$seed/rollouts.csv")
    done; done; done
    workflow "${cells[@]}"
}

workflow() {
    snakemake --cores "${CORES:-2}" --keep-going --configfile "${CONFIGS[@]}" -- "$@"
}

SEEDS="0 1 2 3 4"
PRIMARY="cousins_8 twin_randomised"
for seed in $SEEDS; do run policies lite "$PRIMARY" lite "$seed"; done
workflow "$CELLS"/skill/{door_room_{1,2,3},drawer_room_{2,3,4}}/rollouts.csv
workflow "$CELLS"/conditions/mujoco/{door_room_{1,2,3},drawer_room_{2,3,4}}/skill/rollouts.csv
run conditions/mujoco lite "$PRIMARY" lite "$SEEDS"
run policies lite twin lite "$SEEDS"
run policies lite_handle "$PRIMARY twin" lite_handle "$SEEDS"
for condition in own_size as_on_a_robot; do run conditions/$condition lite "$PRIMARY" lite "$SEEDS"; done
run policies lite_object "$PRIMARY twin" lite "0 1 2"
run policies lite_blind "cousins_8 twin" lite_blind "0 1 2"
run policies diffusion "$PRIMARY twin" diffusion "0 1 2"
for set in random_8 all cousins_4 cousins_2; do run policies lite "$set" lite "$SEEDS"; done
workflow table3
python -m roomkin.plugins.studies results --configs "${CONFIGS[@]}" --out docs/results/registered
CONFIGS+=(config/study/registered_addendum.yaml)
for seed in $SEEDS; do run policies lite_warm "twin_randomised cousins_8 cousins_8_randomised twin" lite_warm "$seed"; done
python -m roomkin.plugins.studies results --configs "${CONFIGS[@]}" --out docs/results/registered_addendum
