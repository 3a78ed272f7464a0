"""Models of the user: found, read, examined, repaired, made assets; a page shows what they were taken for."""
