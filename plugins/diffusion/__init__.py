"""A second learner beside the workflow: a diffusion head on the same clouds and PointNet."""
