"""The patch encoder `efficientnet`: EfficientNet-Lite0, trained on ImageNet."""
