"""Policies: what `training` trains and `evaluation` rolls out (paper B.3). No simulator."""
