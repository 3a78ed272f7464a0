"""What renders tasks for people."""
