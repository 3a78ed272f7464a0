"""Render and compare: models put in an object's place, rendered as its camera would see them, and compared.

`observation`: the object's part of the picture. `solid`: a model of the library in a unit box, and what rays see of it.
`fitting`: the box that lays a model over the object. `terms`: how well the two pictures agree.
"""
