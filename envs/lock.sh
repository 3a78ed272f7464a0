#!/usr/bin/env bash
# Write the hash-pinned requirements: one file for everything, one per environment family with the same versions.
set -euo pipefail
cd "$(dirname "$0")/.."
uv=${BIN:-.venv/bin}/uv
flags=(--universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-header --no-annotate -q)
"$uv" pip compile pyproject.toml --all-extras "${flags[@]}" "${@:---upgrade}" -o envs/requirements.txt
"$uv" pip compile pyproject.toml -c envs/requirements.txt "${flags[@]}" -o envs/simulation.txt
for family in learning report; do
    "$uv" pip compile "envs/$family.in" -c envs/requirements.txt "${flags[@]}" -o "envs/$family.txt"
done
# The executor plugin of profiles/slurm; what it shares with the rest has the same versions.
echo snakemake-executor-plugin-slurm |
    "$uv" pip compile - -c envs/requirements.txt "${flags[@]}" -o envs/slurm.txt
# Readers of other people (envs/readers.sh): the project's torch, and nothing that reading a data set does not need.
torch=$(sed -n 's/^\(torch==[^ ]*\).*/\1/p' envs/requirements.txt)
left_out=(cloudpickle cmake deepdiff diffusers egl-probe evdev farama-notifications gitdb gitpython gymnasium
    hf-transfer imageio imageio-ffmpeg importlib-metadata inquirerpy opencv-python-headless orderly-set pfzy
    prompt-toolkit pynput pyserial python-xlib regex rerun-sdk sentry-sdk smmap torchcodec wandb wcwidth zipp)
printf '%s\n' "$torch" robomimic==0.3.0 six lerobot==0.4.4 |
    "$uv" pip compile - --override <(printf '%s\n' "$torch" torchvision) --python-version 3.11 \
        --python-platform x86_64-manylinux_2_28 --generate-hashes --no-emit-index-url --no-header --no-annotate -q \
        "${left_out[@]/#/--no-emit-package=}" -o envs/readers.txt
