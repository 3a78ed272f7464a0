"""Stage `experiment`: which assets a policy experiment trains and tests on (paper B.3, B.4)."""
