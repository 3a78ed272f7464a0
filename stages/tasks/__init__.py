"""The tasks, a folder each (paper B.4). After `import stages.tasks` they can be made by `gym.make`."""

import importlib

from stages.plugins import available

for module in available("tasks").values():
    importlib.import_module(module)
