"""docs/images/data.svg: the rules of the default run and the files that each writes, as Snakemake plans them."""

import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

import networkx as nx

from reference.picture import draw_graph

TITLE = "The rules of the default run: each reads files of those above it."
NODE = re.compile(r"^(\d+) \[.*?<b><font[^>]*>(\w+)</font></b>(.*?)</table>>\]", re.DOTALL | re.MULTILINE)
OUTPUTS = "output &rarr;"
FILE = re.compile(r'<font face="monospace">(.*?)</font>')
ARROW = re.compile(r"(\d+) -> (\d+)")


def plan(root: Path) -> nx.DiGraph:
    """Rules, an edge from A to B where B reads a file of A; `files` are the names of what a rule writes."""
    snakefile = str(root / "Snakefile")
    command = [sys.executable, "-m", "snakemake", "--cores", "1", "--snakefile", snakefile, "--filegraph", "all"]
    with TemporaryDirectory() as folder:  # without results: what has run already changes nothing
        dot = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
    names, graph = {}, nx.DiGraph()
    for number, name, body in NODE.findall(dot):
        names[number] = name
        graph.add_node(name, files=_names(FILE.findall(body.partition(OUTPUTS)[2])))
    graph.add_edges_from((names[one], names[other]) for one, other in ARROW.findall(dot))
    return graph


def picture(root: Path) -> str:
    """The text of docs/images/data.svg."""
    graph = plan(root)
    graph.remove_nodes_from(["all", "report_page", "viewer"])  # the page reads what all others write
    return draw_graph(graph, {rule: [rule, *files] for rule, files in graph.nodes(data="files")}, TITLE)


def _names(patterns: Iterable[str]) -> list[str]:
    """Names of files below results/: ranks and numbers as `*`, and those that differ in their endings on one line."""
    endings = defaultdict(list)
    for pattern in sorted(patterns):
        name = re.sub(r"\{(\w+),(?:[^{}]|\{[^}]*\})*\}", r"{\1}", pattern).rpartition("/")[2]
        stem, _, ending = name.partition(".")
        endings[re.sub(r"_\d+$", "_*", stem)].append(ending)
    return [f"{stem}.{', '.join(dict.fromkeys(found))}" for stem, found in endings.items()]
