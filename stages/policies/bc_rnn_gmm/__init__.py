"""BC-RNN-GMM: PointNet, LSTM, Gaussian mixture over actions (paper B.3)."""

from stages.policies.bc_rnn_gmm.network import BcRnnGmm as Policy

__all__ = ["Policy"]
