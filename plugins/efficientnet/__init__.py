"""The patch encoder `efficientnet`: EfficientNet-Lite0, trained on ImageNet; its first eleven blocks are shipped."""
