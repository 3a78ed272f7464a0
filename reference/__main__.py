"""`python -m reference`: write docs/errors.md, docs/architecture.md and its pictures from the code."""

from pathlib import Path

from reference.pages import write

if __name__ == "__main__":
    write(Path.cwd())
