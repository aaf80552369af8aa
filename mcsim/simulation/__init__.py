"""What cases of simulated systems share: the problem the engine runs, its kernel, its limits."""
