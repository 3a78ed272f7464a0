"""Training of BC-RNN-GMM policies on demonstrations (paper B.3)."""
