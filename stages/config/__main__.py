"""`python -m stages.config`: write config.yaml, config/schema.json and docs/config.md from the typed models."""

from pathlib import Path

from stages.config.reference import write

if __name__ == "__main__":
    write(Path.cwd())
