"""The command `roomkin`: what is asked for most by a word of its own, every command of a stage or package behind it."""
