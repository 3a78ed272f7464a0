"""`python -m stages.procedural`: write what others know of the categories here."""

from stages.procedural.facts import write

if __name__ == "__main__":
    write()
