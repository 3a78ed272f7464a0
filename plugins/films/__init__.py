"""Films of demonstrations and rollouts, for people, and the pictures of `env.render()`."""
