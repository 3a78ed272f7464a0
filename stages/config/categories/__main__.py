"""`python -m stages.config.categories`: write what the config knows of the library's categories."""

from stages.config import categories

if __name__ == "__main__":
    categories.FILE.write_text(categories.generated(), encoding="utf-8")
