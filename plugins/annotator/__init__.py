"""Draw camera, room and objects into a photograph: single-view metrology behind a page (docs/corrections.md)."""
