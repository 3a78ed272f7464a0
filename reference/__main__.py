"""`python -m reference`: write the pages of docs/ that are read off the code, and their pictures."""

from pathlib import Path

from reference.pages import write

if __name__ == "__main__":
    write(Path.cwd())
