"""The policy `bc_rnn_gmm` for people without this workflow."""
