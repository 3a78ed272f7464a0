"""The tasks, a folder each (paper B.4). After `import roomkin.stages.tasks` they can be made by `gym.make`."""

import importlib

from roomkin.stages.plugins import list_available

for module in list_available("tasks").values():
    importlib.import_module(module)
