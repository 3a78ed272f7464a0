"""The third task of the paper, Putting Away Bowl (B.3): picked up, carried, put into a drawer."""
