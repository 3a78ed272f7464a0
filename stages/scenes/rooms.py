"""The eight rooms of Table 2: 5, 6, 6, 5, 6, 8, 12, 15 objects, and the published scales.

The first `cabinet` of room_1 is what the door task opens, the chest of room_2 what the drawer task opens.
"""

from stages.scenes.recipe import Against, Beside, Floor, Hung, Item, On, Room, Shot, Want

GRASPABLE = ("bar", "square_bar", "knob", "arch")
DOOR_CABINET = Want(
    doors=(1, 3), drawers=(0, 0), height=(0.6, 0.92), width=(0.45, 1.35), door_width=(0.3, 0.5), handles=GRASPABLE
)
DRAWERS = Want(drawers=(2, 6), height=(0.5, 1.0), handles=GRASPABLE)
NARROW = Want(width=(0.0, 1.1))

ROOMS = (
    Room(
        "room_1",
        3.68,
        (
            Item("cabinet", "bottom_cabinet", "cabinet", Against("back", 1.1), DOOR_CABINET),
            Item("hanging", "wall_cabinet", "wall cabinet", Hung("back", 1.1, 1.75), NARROW),
            Item("fridge", "fridge", "fridge", Against("back", -1.85)),
            Item("table", "table", "dining table", Floor(1.35, -0.45, 6), Want(width=(0.0, 1.3))),
            Item("bowl", "bowl", "bowl", On("table", 0.3, 0.3)),
        ),
        walls=("back", "left"),
        half_width=2.5,
        shot=Shot(azimuth=14, height=1.75),
        wall_colour=(0.80, 0.84, 0.82),
        floor_colour=(0.62, 0.45, 0.30),
    ),
    Room(
        "room_2",
        3.42,
        (
            Item("sideboard", "sideboard", "sideboard", Against("back", -0.55)),
            Item("tv", "television", "tv", On("sideboard", -0.2, 0.0)),
            Item("chest", "chest_of_drawers", "chest of drawers", Beside("sideboard", 1, 0.35), DRAWERS),
            Item("coffee_table", "coffee_table", "coffee table", Floor(1.75, -0.45, 4)),
            Item("bottle", "bottle", "bottle", On("coffee_table", 0.0, 0.3)),
            Item("pot", "plant_pot", "flower pot", Floor(0.4, -1.9)),
        ),
        walls=("back",),
        shot=Shot(azimuth=-12, height=1.35),
        wall_colour=(0.87, 0.82, 0.73),
        floor_colour=(0.50, 0.36, 0.25),
    ),
    Room(
        "room_3",
        2.91,
        (
            Item("cabinet", "bottom_cabinet", "kitchen cabinet", Against("back", -0.35), Want(drawers=(1, 6))),
            Item("microwave", "microwave", "microwave", On("cabinet", -0.5, 0.0)),
            Item("oven", "oven", "oven", Beside("cabinet", 1, 0.03)),
            Item("hanging", "wall_cabinet", "hanging cabinet", Hung("back", 0.95, 1.7), NARROW),
            Item("stool", "stool", "stool", Floor(1.6, -1.1, 20)),
            Item("bottle", "bottle", "bottle", On("stool", 0.0, 0.0)),
        ),
        walls=("back", "right"),
        half_width=1.9,
        shot=Shot(azimuth=-15, height=1.7),
        wall_colour=(0.78, 0.82, 0.86),
        floor_colour=(0.66, 0.62, 0.56),
    ),
    Room(
        "room_4",
        3.54,
        (
            Item("bed", "bed", "bed", Against("back", -0.1)),
            Item("nightstand", "chest_of_drawers", "chest of drawers", Beside("bed", 1, 0.12), Want(width=(0, 1.0))),
            Item("lamp", "table_lamp", "bedside lamp", On("nightstand", 0.0, 0.2)),
            Item("wardrobe", "wardrobe", "wardrobe", Against("back", -2.1)),
            Item("painting", "picture", "painting", Hung("back", -0.1, 1.6)),
        ),
        walls=("back",),
        shot=Shot(azimuth=10, height=1.75),
        wall_colour=(0.76, 0.80, 0.85),
        floor_colour=(0.70, 0.55, 0.38),
    ),
    Room(
        "room_5",
        3.24,
        (
            Item("desk", "table", "table", Against("back", 0.45), Want(width=(0.0, 1.6))),
            Item("lamp", "table_lamp", "desk lamp", On("desk", -0.4, -0.5)),
            Item("box", "box", "box", On("desk", -0.1, 0.5, 15)),
            Item("shelf", "bookshelf", "bookshelf", Against("back", -1.25)),
            Item("chair", "chair", "chair", Floor(1.65, 0.75, 165)),
            Item("pot", "plant_pot", "plant pot", Floor(0.45, 1.9)),
        ),
        walls=("back", "left"),
        half_width=2.0,
        shot=Shot(azimuth=12, height=1.5),
        wall_colour=(0.86, 0.85, 0.80),
        floor_colour=(0.55, 0.40, 0.28),
    ),
    Room(
        "room_6",
        4.17,
        (
            Item("cabinet", "bottom_cabinet", "cabinet", Against("back", -1.5), NARROW),
            Item("oven", "oven", "oven", Beside("cabinet", 1), Want(height=(0.5, 1.0))),
            Item("counter", "bottom_cabinet", "cabinet", Beside("oven", 1), Want(width=(0.55, 2.0))),
            Item("hanging", "wall_cabinet", "wall cabinet", Hung("back", -1.5, 1.7), NARROW),
            Item("microwave", "microwave", "microwave", On("counter", -0.4, 0.2)),
            Item("table", "table", "dining table", Floor(2.3, 0.85, 8)),
            Item("chair", "chair", "chair", Floor(2.1, 2.05, -80)),
            Item("plate", "plate", "plate", On("table", 0.3, 0.2)),
        ),
        walls=("back",),
        half_width=2.4,
        shot=Shot(azimuth=-8, height=1.85),
        wall_colour=(0.84, 0.80, 0.74),
        floor_colour=(0.60, 0.58, 0.55),
    ),
    Room(
        "room_7",
        6.89,
        (
            Item("sofa", "sofa", "couch", Against("left", 2.7)),
            Item("coffee_table", "coffee_table", "coffee table", Floor(2.7, -1.45, 90)),
            Item("bowl", "bowl", "bowl", On("coffee_table", 0.0, 0.1)),
            Item("sideboard", "sideboard", "sideboard", Against("back", -0.5)),
            Item("tv", "television", "television", On("sideboard", -0.2, 0.0)),
            Item("shelf", "bookshelf", "bookshelf", Against("back", 1.5)),
            Item("lamp", "floor_lamp", "floor lamp", Floor(0.5, -2.7)),
            Item("pot", "plant_pot", "plant pot", Floor(0.5, 2.6)),
            Item("painting", "picture", "painting", Hung("back", -1.9, 1.6)),
            Item("table", "table", "dining table", Floor(4.3, 1.35, 5)),
            Item("vase", "vase", "vase", On("table", 0.0, -0.1)),
            Item("chair", "chair", "chair", Floor(4.2, 0.0, 80)),
        ),
        walls=("back", "left"),
        half_width=3.2,
        shot=Shot(azimuth=12, height=2.0, fov=62),
        wall_colour=(0.83, 0.80, 0.76),
        floor_colour=(0.58, 0.42, 0.29),
    ),
    Room(
        "room_8",
        10.23,
        (
            Item("fridge", "fridge", "refrigerator", Against("back", -3.9)),
            Item("cabinet", "bottom_cabinet", "cabinet", Against("back", -2.7)),
            Item("dishwasher", "dishwasher", "dishwasher", Beside("cabinet", 1)),
            Item("hanging", "wall_cabinet", "wall cabinet", Hung("back", -2.6, 1.75)),
            Item("cooking_pot", "cooking_pot", "pot", On("cabinet", 0.3, 0.3)),
            Item("table", "table", "dining table", Floor(4.3, -2.4, 8)),
            Item("chair", "chair", "chair", Floor(4.1, -1.1, -85)),
            Item("box", "box", "box", On("table", 0.0, -0.2, 20)),
            Item("sofa", "sofa", "sofa", Floor(2.9, 3.1, -95)),
            Item("coffee_table", "coffee_table", "coffee table", Floor(2.9, 1.6, 85)),
            Item("table_lamp", "table_lamp", "table lamp", On("coffee_table", -0.1, -0.3)),
            Item("sideboard", "sideboard", "sideboard", Against("back", 0.5)),
            Item("tv", "television", "tv", On("sideboard", -0.2, 0.0)),
            Item("lamp", "floor_lamp", "floor lamp", Floor(5.0, 3.6)),
            Item("wardrobe", "wardrobe", "wardrobe", Against("back", 3.6)),
        ),
        walls=("back",),
        half_width=5.5,
        shot=Shot(azimuth=-4, height=2.0, fov=68),
        wall_colour=(0.86, 0.84, 0.80),
        floor_colour=(0.64, 0.50, 0.36),
    ),
)
BY_NAME = {room.name: room for room in ROOMS}
