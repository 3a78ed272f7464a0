"""Names that are proposed for the things that masks show, with probabilities."""
