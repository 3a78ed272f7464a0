"""Draw camera, room and objects into a photograph: single-view metrology behind a page in the browser."""
