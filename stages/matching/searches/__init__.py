"""Libraries that find nearest patches; which one does not change what is found (`stages/matching/search.py`)."""
