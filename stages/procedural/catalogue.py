"""What there is: generators by name (a recipe calls one) and, per category, how its members are drawn."""

import zlib
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from stages.contracts.library import Recipe
from stages.procedural import (
    armchairs,
    cabinet_draws,
    containers,
    decor,
    desks_and_benches,
    families,
    kitchenware,
    lamps,
    plants,
    seats,
    small_things,
    sofas,
    storage,
    tables_and_beds,
    turned,
    vessels,
)
from stages.procedural.cabinet import cabinet
from stages.procedural.model import Draw, Generator

GENERATORS: dict[str, Generator] = {
    "armchair": armchairs.armchair,
    "basket": containers.basket,
    "bed": tables_and_beds.bed,
    "bench": desks_and_benches.bench,
    "book": storage.book,
    "bookshelf": storage.bookshelf,
    "bowl": vessels.bowl,
    "cabinet": cabinet,
    "candlestick": small_things.candlestick,
    "carton": storage.carton,
    "chair": seats.chair,
    "clock": small_things.clock,
    "cooking_pot": vessels.cooking_pot,
    "desk": desks_and_benches.desk,
    "jar": kitchenware.jar,
    "kettle": kitchenware.kettle,
    "lamp": lamps.lamp,
    "laptop": small_things.laptop,
    "mirror": small_things.mirror,
    "mug": vessels.mug,
    "pan": kitchenware.pan,
    "picture": decor.picture,
    "plant_pot": plants.plant_pot,
    "plate": vessels.plate,
    "sofa": sofas.sofa,
    "stool": seats.stool,
    "table": tables_and_beds.table,
    "television": decor.television,
    "toaster": kitchenware.toaster,
    "trash_can": containers.trash_can,
    "turned_vessel": turned.turned_vessel,
    "wall_shelf": desks_and_benches.wall_shelf,
}

CATEGORIES: dict[str, Callable[[np.random.Generator, int], Draw]] = {
    "armchair": armchairs.draw_armchair,
    "basket": containers.draw_basket,
    "bed": tables_and_beds.draw_bed,
    "bench": desks_and_benches.draw_bench,
    "book": storage.draw_book,
    "bookshelf": storage.draw_bookshelf,
    "bottle": turned.draw_bottle,
    "bottom_cabinet": cabinet_draws.bottom_cabinet,
    "bowl": vessels.draw_bowl,
    "box": storage.draw_box,
    "candlestick": small_things.draw_candlestick,
    "chair": seats.draw_chair,
    "chest_of_drawers": cabinet_draws.chest_of_drawers,
    "clock": small_things.draw_clock,
    "coffee_table": tables_and_beds.draw_coffee_table,
    "cooking_pot": vessels.draw_cooking_pot,
    "desk": desks_and_benches.draw_desk,
    "dishwasher": cabinet_draws.dishwasher,
    "floor_lamp": lamps.draw_floor_lamp,
    "fridge": cabinet_draws.fridge,
    "jar": kitchenware.draw_jar,
    "kettle": kitchenware.draw_kettle,
    "laptop": small_things.draw_laptop,
    "microwave": cabinet_draws.microwave,
    "mirror": small_things.draw_mirror,
    "mug": vessels.draw_mug,
    "nightstand": cabinet_draws.nightstand,
    "oven": cabinet_draws.oven,
    "pan": kitchenware.draw_pan,
    "picture": decor.draw_picture,
    "plant_pot": plants.draw_plant_pot,
    "plate": vessels.draw_plate,
    "sideboard": cabinet_draws.sideboard,
    "sofa": sofas.draw_sofa,
    "stool": seats.draw_stool,
    "table": tables_and_beds.draw_table,
    "table_lamp": lamps.draw_table_lamp,
    "television": decor.draw_television,
    "toaster": kitchenware.draw_toaster,
    "trash_can": containers.draw_trash_can,
    "tv_stand": cabinet_draws.tv_stand,
    "vase": turned.draw_vase,
    "wall_cabinet": cabinet_draws.wall_cabinet,
    "wall_shelf": desks_and_benches.draw_wall_shelf,
    "wardrobe": cabinet_draws.wardrobe,
}


def sample(category: str, index: int, seed: int) -> Recipe:
    """The recipe of the `index`-th model of a category; it does not depend on how many others there are."""
    rng = _generator(category, index, seed)
    founders = families.FOUNDERS[category]
    if index < founders:
        draw = CATEGORIES[category](rng, index)
        return Recipe(generator=draw.generator, parameters={"size": list(draw.size), **draw.parameters})
    in_turn, founder = families.in_turn(category, index), index % founders
    if not in_turn:
        founder = families.fewest([_fronts(category, k, seed) for k in range(index)], founders)
    if category in families.CABINETS:
        first = CATEGORIES[category](_generator(category, founder, seed), founder)
        generation = index // founders if in_turn else index
        draw = families.relative(category, first, generation, rng, any_fronts=in_turn)
    else:
        draw = CATEGORIES[category](rng, founder)  # in the founder's style: styles go by number
    return Recipe(
        generator=draw.generator,
        parameters={"size": list(draw.size), **draw.parameters},
        variation_of=model_name(category, founder),
    )


@cache
def _fronts(category: str, index: int, seed: int) -> tuple[int, int]:
    """Doors (and flaps) and drawers of a cabinet."""
    layout: Any = sample(category, index, seed).parameters["layout"]
    cells = [cell for line in layout for cell in line]
    return cells.count("door") + cells.count("flap"), cells.count("drawer")


def model_name(category: str, index: int) -> str:
    """Id of the `index`-th model of a category."""
    return f"{category}_{index:02d}"


def _generator(category: str, index: int, seed: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence((seed, zlib.crc32(category.encode()), index)))
