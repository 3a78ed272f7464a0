"""Names of what outlines show, with probabilities."""
