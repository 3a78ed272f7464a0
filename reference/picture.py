"""A graph without cycles as a picture: boxes in layers, arrows downward, laid out by grandalf and written as SVG."""

import html
from collections.abc import Mapping, Sequence

import networkx as nx
from grandalf.graphs import Edge, Vertex, graph_core
from grandalf.layouts import SugiyamaLayout
from grandalf.routing import EdgeViewer, route_with_lines

LETTER, LINE, MARGIN = 6.4, 15, 12  # pixels: width of a letter of 12 px, height of a line, space around the picture
APART = (14, 34)  # pixels between boxes of a layer, and between layers
SWEEPS = 12  # over the order in the layers; more change nothing
HEAD = """\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left:.0f} {top:.0f} {width:.0f} {height:.0f}" role="img">
<title>{title}</title>
<style>
rect {{ fill: #fff; stroke: #00796b }}
polyline {{ fill: none; stroke: #999; marker-end: url(#tip) }}
text {{ font: 10px sans-serif; text-anchor: middle; fill: #555 }}
.name {{ font-size: 12px; fill: #222 }}
</style>
<marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">
<path d="M0,0 L8,4 L0,8 z" fill="#999"/>
</marker>
<rect x="{left:.0f}" y="{top:.0f}" width="{width:.0f}" height="{height:.0f}" style="stroke: none"/>
"""


class TextBox:
    """Lines of text in a frame, as grandalf wants a vertex's view: its size, and the middle `xy` that it is given."""

    def __init__(self, lines: Sequence[str]) -> None:
        self.lines = lines
        self.w = LETTER * max(map(len, lines)) + 16
        self.h = LINE * len(lines) + 8
        self.xy = (0.0, 0.0)

    def svg(self) -> str:
        """The frame, the name on the first line, and smaller what follows."""
        x, y = self.xy[0], self.xy[1] - self.h / 2
        frame = f'<rect x="{x - self.w / 2:.0f}" y="{y:.0f}" width="{self.w:.0f}" height="{self.h}" rx="4"/>'
        kinds = ["name"] + ["more"] * len(self.lines)
        texts = [
            f'<text class="{kind}" x="{x:.0f}" y="{y + LINE * number:.0f}">{html.escape(line)}</text>'
            for number, (kind, line) in enumerate(zip(kinds, self.lines, strict=False), start=1)
        ]
        return "\n".join([frame, *texts])


def draw_graph(graph: nx.DiGraph, texts: Mapping[str, Sequence[str]], title: str) -> str:
    """SVG of a connected graph without cycles; an arrow that follows from others is left out.

    Args:
        graph: an arrow goes from a node to what lies below it.
        texts: the lines in the box of each node.
        title: what the picture shows, for those who cannot see it.
    """
    vertices = {node: Vertex(node) for node in sorted(graph)}
    for node, vertex in vertices.items():
        vertex.view = TextBox(texts[node])
    edges = [Edge(vertices[one], vertices[other]) for one, other in sorted(nx.transitive_reduction(graph).edges)]
    for edge in edges:
        edge.view = EdgeViewer()
    layout = SugiyamaLayout(graph_core(list(vertices.values()), edges))
    layout.xspace, layout.yspace = APART
    layout.route_edge = route_with_lines
    layout.init_all()
    layout.draw(SWEEPS)
    layout.draw_edges()
    boxes = [vertex.view for vertex in vertices.values()]
    points = [point for edge in edges for point in edge.view._pts]
    corners = [(box.xy[0] + sign * box.w / 2, box.xy[1] + sign * box.h / 2) for box in boxes for sign in (-1, 1)]
    left, top = (min(values) - MARGIN for values in zip(*points, *corners, strict=True))
    right, bottom = (max(values) + MARGIN for values in zip(*points, *corners, strict=True))
    lines = [" ".join(f"{x:.0f},{y:.0f}" for x, y in edge.view._pts) for edge in edges]
    head = HEAD.format(left=left, top=top, width=right - left, height=bottom - top, title=html.escape(title))
    return head + "\n".join([*(f'<polyline points="{line}"/>' for line in lines), *map(TextBox.svg, boxes), "</svg>\n"])
