"""The handle: what stands before the plane of the front."""

from plugins.handle.handle_points import find_handle_middles, mark_handle_points, offsets_to_handle
from plugins.handle.sequences import mark_episodes, vary_handles
from stages.policies.marking import Marker

MARKER = Marker(mark_handle_points, mark_episodes, vary_handles, find_handle_middles, offsets_to_handle)
