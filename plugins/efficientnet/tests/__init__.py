"""Tests of the patch encoder `efficientnet`."""
