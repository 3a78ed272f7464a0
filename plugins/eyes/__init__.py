"""Networks with published weights that look at a picture: MobileSAM outlines things, an SSD finds COCO's classes."""
