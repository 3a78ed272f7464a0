"""The folders of stages/: what each is for, and docs/images/rooms.svg, an arrow from each to those that it imports."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import networkx as nx

from reference.picture import draw_graph

TITLE = "The folders of stages/: each imports only what lies below it."


def imports(root: Path) -> nx.DiGraph:
    """Folders of stages/, an edge from A to B where a module of A imports one of B; `files` are the modules of A."""
    rooms = {path.parent.name for path in (root / "stages").glob("*/__init__.py")}
    graph = nx.DiGraph()
    graph.add_nodes_from(sorted(rooms))
    for room in sorted(rooms):
        for file in sorted((root / "stages" / room).rglob("*.py")):
            for other in sorted(set(_imported(file)) & rooms - {room}):
                graph.add_edge(room, other)
                graph.edges[room, other].setdefault("files", []).append(file.relative_to(root).as_posix())
    return graph


def picture(root: Path) -> str:
    """The text of docs/images/rooms.svg."""
    graph = imports(root)
    return draw_graph(graph, {room: [room] for room in graph}, TITLE)


def table(root: Path) -> str:
    """A row for every folder of the core and every package: its name, and the first line of its docstring."""
    rows = ["| folder | what it is |", "|---|---|"]
    for file in (path for home in ("stages", "plugins") for path in sorted((root / home).glob("*/__init__.py"))):
        docstring = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
        about = re.sub(r"docs/([\w-]+\.md)", r"[\1](\1)", docstring.partition("\n")[0])
        rows.append(f"| `{file.parent.relative_to(root)}` | {about} |")
    return "\n".join(rows)


def _imported(file: Path) -> Iterator[str]:
    """The folders of stages/ that a module imports, also within its functions."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        yield from (name.split(".")[2] for name in names if name.startswith("roomkin.stages."))
