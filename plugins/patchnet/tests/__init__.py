"""Tests of the patch encoder `patchnet`."""
