"""Stage `demonstrations`: scripted skills open the target joint; successes become training data (paper A.4, A.5)."""
