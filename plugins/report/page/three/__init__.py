"""three.js, as the pages use it; README.md says how three.min.js is made."""
