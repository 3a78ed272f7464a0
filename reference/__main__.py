"""`python -m reference`: write docs/commands.md, docs/errors.md, docs/architecture.md and its pictures."""

from pathlib import Path

from reference.pages import write

if __name__ == "__main__":
    write(Path.cwd())
