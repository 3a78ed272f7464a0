"""What rollouts and trainings say beside Table 3: unseen assets, the claims of the paper, trainings that failed."""
