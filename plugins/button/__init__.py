"""Push a button: a third part type, a sprung button on a box, with its task, its skill and a room."""
