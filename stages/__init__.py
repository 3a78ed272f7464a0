"""ACDC (Dai et al., CoRL 2024) as stages: from one RGB image to digital cousins to policies.

Each sub-package named after a rule file is a stage: a command line
(``roomkin <stage> <command> --flags``) that reads and writes files and knows
nothing of Snakemake. `contracts`, `config`, `geometry`, `procedural` and `simulation`
are the rooms that stages share; stages never import each other.

Conventions everywhere: SI units, radians, quaternions wxyz, z up, assets face +x,
poses named by frame (``world_from_camera`` maps camera coordinates to the world),
cameras in the OpenCV frame (x right, y down, z forward).
"""
