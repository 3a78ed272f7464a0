"""`python -m stages.config`: write config.yaml, config/schema.json and docs/config.md from the typed models."""

import subprocess
import sys
from pathlib import Path

if __name__ == "__main__":
    subprocess.run([sys.executable, "-m", "stages.procedural"], check=True)  # categories, which the models read
    from stages.config.reference import write

    write(Path.cwd())
