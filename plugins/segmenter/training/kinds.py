"""Kinds of things by where they stand in random rooms; named twice: met twice as often."""

TALL = ("wardrobe", "bookshelf", "fridge", "floor_lamp", "plant_pot", "chest_of_drawers", "bookshelf", "curtain")
LOW = (
    *("sideboard", "tv_stand", "desk", "bed", "sofa", "armchair", "nightstand", "bench", "trash_can", "basket", "box"),
    *("ottoman", "radiator", "sink", "suitcase", "toilet", "bag"),
)
KITCHEN = ("bottom_cabinet", "oven", "dishwasher", "bottom_cabinet", "fridge", "washing_machine")
MIDDLE = (
    *("coffee_table", "table", "desk", "armchair", "sofa", "stool", "office_chair", "plant_pot", "basket", "heap"),
    *("ottoman", "bag", "suitcase"),
)
SEATS = ("chair", "chair", "chair", "stool", "office_chair", "bench")
SMALL = (
    *("book", "bottle", "bowl", "box", "candlestick", "clock", "cooking_pot", "jar", "kettle", "laptop", "microwave"),
    *("mug", "pan", "plant_pot", "plate", "table_lamp", "television", "toaster", "vase", "monitor", "keyboard", "heap"),
    *("heap", "heap", "sheet", "book", "mug", "basket", "cushion", "mouse", "telephone", "cell_phone", "remote", "can"),
    *("wine_glass", "cutlery"),
)
HANGING = ("picture", "picture", "picture", "mirror", "clock", "wall_cabinet", "wall_shelf", "television")
TOPS = {"curtain": 2.3, "radiator": 0.75, "sink": 0.95, "toilet": 0.45}  # metres: what hangs low ends there; chosen
