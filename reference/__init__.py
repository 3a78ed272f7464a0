"""Pages and pictures of docs/ that are read off the code: `make reference` writes them, a test compares them."""
