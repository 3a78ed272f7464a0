"""One RGB picture -> an input folder of the contract, by pretrained networks (paper 2.1, A.2, A.7)."""
