"""The workflow as functions, without Snakemake: a library, the scenes of a picture, a trained policy, a film."""
