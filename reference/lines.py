"""`make loc`: lines of Python of the core by folder, of each package, and of the tests."""

from collections import Counter
from pathlib import Path


def lines(root: Path) -> Counter[str]:
    """Lines by `stages/<folder>`, `plugins/<package>`, `tests`."""
    found: Counter[str] = Counter()
    for file in (path for home in ("stages", "plugins", "tests") for path in (root / home).rglob("*.py")):
        parts = file.relative_to(root).parts
        name = "tests" if "tests" in parts else "/".join(parts[:2] if len(parts) > 2 else parts[:1])
        found[name] += len(file.read_text(encoding="utf-8").splitlines())
    return found


if __name__ == "__main__":
    counted = lines(Path.cwd())
    for name, number in sorted(counted.items()):
        print(f"{name:24}{number:7,}")
    for home in ("stages", "plugins"):
        total = sum(number for name, number in counted.items() if name.split("/")[0] == home)
        print(f"{'all of ' + home:24}{total:7,}")
