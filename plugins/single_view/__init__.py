"""From one photograph without depth to an input folder: camera, boxes and walls by lines, masks and usual sizes."""
