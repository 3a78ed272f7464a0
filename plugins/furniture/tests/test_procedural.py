"""Procedural models: exact sizes, right joints, graspable handles, same bytes for the same seed."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import yaml

from roomkin.plugins.furniture.cabinet import Cabinet
from roomkin.plugins.furniture.catalogue import ALL, CATEGORIES, sample
from roomkin.plugins.furniture.facts import REAL_SIZES, categories_text, counts_text, describe_category
from roomkin.plugins.furniture.finishes import finish_of
from roomkin.plugins.furniture.folder import build, generate, make_model, mass_properties
from roomkin.plugins.furniture.fronts import cells
from roomkin.plugins.furniture.model import bounds
from roomkin.plugins.furniture.shapes import bounds_of, cushion, rod, shell_pieces, slab
from roomkin.stages.articulated.asset_folder import Description, checksum
from roomkin.stages.articulated.model import link_frames, measure_closed_box
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.config import categories as counts
from roomkin.stages.config.assets import COUNTS
from roomkin.stages.contracts import categories
from roomkin.stages.contracts.category import describe_unusual
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.library import Recipe
from tests.refusals import refused
from tests.unit.demo_assets import PARAMETERS

CABINETS = ["bottom_cabinet", "wall_cabinet", "sideboard", "wardrobe"]
SIZES = [None, (0.5, 0.9, 0.7), (1.3, 0.35, 0.4), (0.21, 0.2, 1.9)]


def recipes(categories: list[str]) -> list[tuple[str, Recipe]]:
    return [(f"{c}_{k}", sample(c, k, 0)) for c in categories for k in range(COUNTS[c])]


@pytest.mark.parametrize("category", sorted(ALL))
def test_closed_box_is_exact_at_any_size(category: str) -> None:
    recipe = sample(category, 1, 7)
    for size in SIZES:
        low, high = bounds(generate(recipe, size))
        assert np.allclose(high - low, recipe.parameters["size"] if size is None else size, atol=1e-9)
        assert np.allclose((low + high)[:2], 0, atol=1e-9)
        assert abs(low[2]) < 1e-9


@pytest.mark.parametrize("category", ["microwave", "nightstand", "oven", "wardrobe", "mug"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_what_is_too_thin_for_its_boards_is_scaled(category: str, axis: int, tmp_path: Path) -> None:
    recipe = sample(category, 1, 0)
    x, y, z = (0.01 if k == axis else float(v) for k, v in enumerate(recipe.parameters["size"]))
    asset = build(recipe, (x, y, z), tmp_path / "thin", "thin", category)
    assert asset.size == pytest.approx((x, y, z), abs=1e-6)
    robot = read_urdf(tmp_path / "thin" / "model.urdf", tmp_path / "thin")  # refuses solids without a volume
    assert all(joint.upper > joint.lower for joint in robot.joints if joint.type != "fixed")


def test_a_model_hangs_or_stands_and_is_as_symmetric_as_its_recipe_says() -> None:
    about = Description("a", "a", "CC0-1.0", "test", symmetry="none", placement="floor")
    made = {name: make_model(sample(name, 0, 0), None, about).about for name in ("wall_cabinet", "mug")}
    assert (made["wall_cabinet"].placement, made["mug"].placement) == ("wall", "object")
    assert made["mug"].recipe == sample("mug", 0, 0)


def test_written_files_fill_the_promised_box(tmp_path: Path) -> None:
    asset = build(sample("bottom_cabinet", 3, 0), (0.6, 1.1, 0.8), tmp_path / "cab", "cab", "bottom_cabinet")
    robot = read_urdf(tmp_path / "cab" / "model.urdf", tmp_path / "cab")
    assert np.allclose(measure_closed_box(robot), [asset.box_min, asset.box_max], atol=2e-5)
    assert asset.size == pytest.approx((0.6, 1.1, 0.8), abs=1e-6)
    assert sum(link.mass for link in robot.links.values()) == pytest.approx(asset.mass, rel=1e-4)
    assert asset.checksum == checksum(tmp_path / "cab")
    for link in robot.links.values():
        low, high = bounds_of([visual.mesh for visual in link.visuals])
        assert (low < link.center).all() and (link.center < high).all(), f"{link.name}: its mass lies outside of it"


@pytest.mark.parametrize("overlay", [None, "study/table2", "study/table3", "paper/scenes"])
def test_libraries_are_as_large_as_promised(overlay: str | None) -> None:
    file = Path(__file__).resolve().parents[3] / f"config/{overlay}.yaml"
    counts = COUNTS | (yaml.safe_load(file.read_text())["assets"]["counts"] if overlay else {})
    given = {name: count for name, count in counts.items() if count}  # without categories that came later
    assert all(count >= (CATEGORIES[name].further or [COUNTS[name]])[0] for name, count in given.items())
    doors, drawers = fronts(counts)
    least = (600, 190, 120) if overlay else (250, 80, 50)
    assert all(found >= wanted for found, wanted in zip((sum(counts.values()), doors, drawers), least, strict=True))


def test_handles_are_of_every_kind() -> None:
    assert sum(count > 0 for count in COUNTS.values()) == len(CATEGORIES) >= 35
    models = [generate(sample(category, index, 0)) for category in CABINETS for index in range(6)]
    assert {moving.handle for model in models for moving in model.moving} == {"bar", "knob", "arch", "edge"}


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_no_template_is_left_with_few_models_of_about_as_many_doors_and_drawers(seed: int) -> None:
    for category, record in CATEGORIES.items():
        templates = record.templates
        if not record.varied:
            assert not record.fronts
            continue
        shapes = [layout_counts(sample(category, index, seed)) for index in range(COUNTS[category])]
        for doors, drawers in shapes[:templates]:
            alike = sum(abs(doors - a) + abs(drawers - b) <= 2 for a, b in shapes)
            assert alike >= 10, f"{category} with {doors} doors, {drawers} drawers: {alike}"


def test_relatives_of_plain_things_are_of_their_templates_style() -> None:
    template, relative = sample("chair", 3, 0), sample("chair", 3 + CATEGORIES["chair"].templates, 0)
    assert relative.variation_of == "chair_03"
    assert template.parameters["back"] == relative.parameters["back"]
    assert template.parameters["size"] != relative.parameters["size"]


def test_without_variations_every_model_is_a_template() -> None:
    templates = CATEGORIES["sideboard"].templates
    free = [sample("sideboard", index, 3, variations=False) for index in range(3 * templates)]
    assert free[:templates] == [sample("sideboard", index, 3) for index in range(templates)]
    assert all(recipe.variation_of is None for recipe in free)
    assert len({str(recipe.parameters["size"]) for recipe in free}) == len(free)


def layout_counts(recipe: Recipe) -> tuple[int, int]:
    cells = [cell for line in recipe.parameters["layout"] for cell in line]  # type: ignore[union-attr]
    return cells.count("door") + cells.count("flap"), cells.count("drawer")


def fronts(counts: dict[str, int]) -> tuple[int, int]:
    """How many models have doors or flaps, and how many have drawers, told from their recipes."""
    layouts = [
        {kind for line in sample(category, index, 0).parameters.get("layout", []) for kind in line}  # type: ignore[union-attr]
        for category, count in counts.items()
        for index in range(count)
    ]
    return sum(bool({"door", "flap"} & kinds) for kinds in layouts), sum("drawer" in kinds for kinds in layouts)


def test_near_relatives_keep_what_matters_and_far_ones_differ() -> None:
    """Odd generations have their template's fronts and handles in other proportions; even ones have others."""
    templates = CATEGORIES["chest_of_drawers"].templates
    same, other = 0, 0
    for index in range(3 * templates):
        recipe, template = sample("chest_of_drawers", index, 0), sample("chest_of_drawers", index % templates, 0)
        if index < templates:
            assert recipe.variation_of is None and recipe == template
            continue
        assert recipe.variation_of == f"chest_of_drawers_{index % templates:02d}"
        kept = [recipe.parameters[key] == template.parameters[key] for key in ("layout", "handle")]
        assert recipe.parameters["size"] != template.parameters["size"]
        if index < 2 * templates:
            assert all(kept)
            ratio = np.divide(recipe.parameters["size"], template.parameters["size"])  # type: ignore[arg-type]
            assert np.abs(np.log(ratio)).max() < 0.15
        else:
            same, other = same + all(kept), other + (not all(kept))
    assert other > 3 * same
    assert sample("mug", 40, 0).variation_of == "mug_00"


def test_models_of_a_category_differ() -> None:
    for category, count in COUNTS.items():
        drawn = {sample(category, k, 0).model_dump_json() for k in range(count)}
        assert len(drawn) == count


def test_fronts_open_outwards_and_leave_gaps() -> None:
    for name, recipe in recipes(["bottom_cabinet", "sideboard", "oven", "fridge", "microwave"]):
        model = generate(recipe)
        boxes = [bounds_of([part.mesh for part in moving.parts]) for moving in model.moving]
        for k, moving in enumerate(model.moving):
            pull = boxes[k].mean(axis=0)
            if moving.part_type == "door":
                turn = trimesh.transformations.rotation_matrix(moving.upper / 2, moving.axis, moving.origin)
                opened = trimesh.transform_points([pull], turn)[0]
            else:
                opened = pull + moving.upper * np.array(moving.axis)
            assert opened[0] > pull[0] + 0.05, f"{name} {moving.name} opens inwards"
            for other in boxes[k + 1 :]:
                gap = np.maximum(boxes[k][0] - other[1], other[0] - boxes[k][1])[1:].max()
                assert gap > 0.0029, f"{name}: {moving.name} is {gap:.4f} m from its neighbour"


def test_handles_are_on_the_free_side_and_keep_their_size() -> None:
    for name, recipe in recipes(CABINETS):
        for size in (None, (0.7, 1.6, 1.4)):
            model = generate(recipe, size)
            for moving in model.moving:
                if moving.handle in (None, "edge") or moving.part_type != "door":
                    continue
                foremost = max(moving.parts, key=lambda part: part.mesh.bounds[1][0])
                box = bounds_of([part.mesh for part in moving.parts])
                half = (box[1] - box[0])[1] / 2
                away = abs(foremost.mesh.bounds[:, 1].mean() - moving.origin[1])
                assert away > 1.2 * half, f"{name} {moving.name}: handle on the hinge side"
                thickness = np.sort(foremost.mesh.extents)[:2]
                assert 0.008 < thickness[1] < 0.034, f"{name} {moving.name}: {thickness}"
                pull = finish_of(str(recipe.parameters["handle_colour"]))
                panel_front = max(part.mesh.bounds[1][0] for part in moving.parts if part.finish != pull)
                assert 0.028 < box[1][0] - panel_front < 0.055, name


def test_mass_properties_of_a_known_solid() -> None:
    from roomkin.plugins.furniture.model import part

    halves = [part(slab((0, y, 0.5), (2, 1, 1)), (1, 1, 1), 100.0) for y in (-0.5, 0.5)]
    mass, center, inertia = mass_properties(halves)
    assert mass == pytest.approx(400.0)
    assert np.allclose(center, [0, 0, 0.5])
    assert np.allclose(inertia, 400 / 12 * np.diag([5.0, 5.0, 8.0]), atol=1e-5)


def test_shapes_are_closed_and_have_the_right_volume() -> None:
    assert rod((0, 0, 0), (0.3, 0, 0), 0.1, segments=64).volume == pytest.approx(np.pi * 0.01 * 0.3, rel=0.01)
    soft = cushion((0, 0, 0), (1, 2, 0.5), 0.1)
    assert np.allclose(soft.bounds, [[0, 0, 0], [1, 2, 0.5]])
    assert 0.8 < soft.volume < 1.0
    wall = shell_pieces([(0.1, 0), (0.1, 0.2)], [(0.09, 0), (0.09, 0.2)], pieces=48)
    assert sum(piece.volume for piece in wall) == pytest.approx(np.pi * (0.1**2 - 0.09**2) * 0.2, rel=0.01)
    assert all(mesh.is_watertight for mesh in (soft, *wall))


def test_bowls_are_hollow_to_physics() -> None:
    model = generate(sample("bowl", 0, 0))
    height = bounds(model)[1][2]
    middle = np.array([0.0, 0.0, 0.6 * height])
    pieces = [piece for part in model.base for piece in part.pieces]
    assert len(pieces) > 8
    for piece in pieces:  # outside of a convex piece: before at least one of its faces
        assert ((middle - piece.triangles_center) * piece.face_normals).sum(axis=1).max() > 0


def test_cells_cover_the_front_and_pair_their_hinges() -> None:
    weights = {"door": 1.0, "drawer": 0.25}
    found = cells([["drawer"], ["door", "door"]], "rows", (0, 2), (0, 1), weights, 1)
    assert [cell.kind for cell in found] == ["drawer", "door", "door"]
    assert sum((c.y[1] - c.y[0]) * (c.z[1] - c.z[0]) for c in found) == pytest.approx(2.0)
    assert found[0].z == pytest.approx((0.8, 1.0))
    assert [cell.hinge for cell in found[1:]] == [-1, 1]
    alone = cells([["door"]], "columns", (0, 1), (0, 1), weights, 1)
    assert alone[0].hinge == 1


def test_bad_recipes_are_refused() -> None:
    for generator, size in (("spaceship", (1.0, 1.0, 1.0)), ("mug", (0.1, 0.0, 0.1))):
        with refused("E-RECIPE-PARAMETER"):
            generate(sample("mug", 0, 0).model_copy(update={"generator": generator}), size)


@pytest.mark.parametrize(
    ("category", "changes", "complaint"),
    [
        ("bottom_cabinet", {"handel": "bar"}, "recipe of a cabinet: parameter handel: Extra inputs"),
        ("bottom_cabinet", {"handle": "lever"}, "parameter handle: Input should be 'bar'"),
        ("bottom_cabinet", {"layout": [["door", "window"]]}, "parameter layout.0.1: "),
        ("bottom_cabinet", {"layout": []}, "parameter layout: "),
        ("bottom_cabinet", {"board": -0.02}, "parameter board: "),
        ("bottom_cabinet", {"reach": float("nan")}, "parameter reach: "),
        ("bottom_cabinet", {"hinge": 0}, "parameter hinge: "),
        ("bottom_cabinet", {"shelves": 10**9}, "parameter shelves: "),
        ("bottom_cabinet", {"front_colour": [128.0, 0.2, 0.1]}, "parameter front_colour: .* colors go from 0 to 1"),
        ("bottom_cabinet", {"column_weights": [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]}, "its parameters make no model"),
        ("bottom_cabinet", {"protrusion": None}, "parameter protrusion: Field required"),
        ("bottom_cabinet", {"size": [0.5, 0.5]}, "is not three numbers"),
        ("bottom_cabinet", {"size": [0.5, 0.5, float("nan")]}, "is not positive"),
        ("bottom_cabinet", {"size": [0.5, 0.5, 1e30]}, "larger than 30 m"),
        ("mug", {"colour": None}, "recipe of a mug: parameter colour: Field required"),
        ("chair", {"seat": "high"}, "recipe of a chair: parameter seat: Input should be a valid number"),
    ],
)
def test_a_wrong_parameter_is_one_clear_line(
    category: str, changes: dict[str, Any], complaint: str, tmp_path: Path
) -> None:
    recipe = sample(category, 0, 0)
    parameters = {key: value for key, value in (recipe.parameters | changes).items() if value is not None}
    broken = recipe.model_copy(update={"parameters": parameters})
    with pytest.raises(InputError, match=complaint) as caught:
        build(broken, None, tmp_path / "made", "made", category)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_opened_frames_follow_the_contract(tmp_path: Path) -> None:
    asset = build(sample("bottom_cabinet", 0, 0), None, tmp_path / "c", "c", "bottom_cabinet")
    robot = read_urdf(tmp_path / "c" / "model.urdf", tmp_path / "c")
    joint = asset.joints[0]
    closed, opened = link_frames(robot)[joint.link], link_frames(robot, 1.0)[joint.link]
    turn = closed[:3, :3].T @ opened[:3, :3]
    assert np.degrees(np.arccos((np.trace(turn) - 1) / 2)) == pytest.approx(90, abs=0.1)


def test_thick_doors_swing_clear_of_each_other_and_a_top_leaves_room_above_edges() -> None:
    recipe = Cabinet.model_validate({name: value for name, value in PARAMETERS.items() if name != "size"})
    thick, scale = 0.05, np.array([1.25, 0.75])  # the worst scale of an episode, in depth and width
    doors = recipe.change_parameters(layout=[["door"], ["door"]], front_thickness=thick).build((0.7, 0.75, 1.7)).moving
    low, high = sorted(
        [bounds_of([piece.mesh for piece in door.parts[:1]])[:, 1] * scale[1] for door in doors], key=min
    )
    width = high[1] - high[0]
    farthest = np.hypot(width, thick * scale[0])  # of the rear free corner from the hinge at the front
    assert high[0] - low[1] > farthest - width
    flush, bare = (recipe.change_parameters(handle="edge", top=top).build((0.5, 0.75, 0.8)) for top in (0.03, 0.0))
    assert len(flush.base) == len(bare.base)


def test_further_styles_come_after_the_others_and_furnish_no_room() -> None:
    """French doors above a freezer drawer, four doors, a double oven: the models before them are as they were."""
    for name, record in CATEGORIES.items():
        assert not record.further or record.templates <= record.further[0] <= record.further[-1] < record.count, name
    styles = {name: [sample(name, k, 0) for k in CATEGORIES[name].further] for name in ("fridge", "oven")}
    assert {layout_counts(recipe) for recipe in styles["fridge"]} == {(2, 1), (2, 2), (4, 0), (1, 0), (2, 0)}
    assert {layout_counts(recipe) for recipe in styles["oven"]} == {(2, 0)}
    assert all(recipe.variation_of is not None for each in styles.values() for recipe in each)
    assert [sample("fridge", k, 0, variations=False).variation_of for k in CATEGORIES["fridge"].further] == [None] * 9


def test_what_is_sold_is_usual() -> None:
    """Our models are no measure of the world: base units are 60 cm deep, and cereal comes in boxes."""
    rows = {name: describe_category(CATEGORIES[name]) for name in [*REAL_SIZES, "fridge", "oven"]}
    sold = {
        "bottom_cabinet": (0.64, 0.8, 0.9), "box": (0.06, 0.16, 0.22), "television": (0.06, 1.2, 0.7),
        "fridge": (0.6, 0.55, 0.85),
    }  # fmt: skip
    assert all(describe_unusual(rows[name], size) == "" for name, size in sold.items())
    odd = {"bottom_cabinet": (0.64, 0.8, 1.9), "box": (1.0, 1.0, 1.0), "oven": (0.6, 0.6, 2.1)}
    assert all(describe_unusual(rows[name], size) for name, size in odd.items())
    known = rows["fridge"].measure_usual_size()
    assert known is not None and known.misfit(np.array(sold["fridge"])) > 0, "it is guessed to be high"


def test_what_others_know_of_the_categories_is_written_anew() -> None:
    for file, text in ((categories.FILE, categories_text()), (counts.FILE, counts_text())):
        assert file.read_text(encoding="utf-8") == text, f"{file.name} drifted from plugins/furniture; run: make config"
