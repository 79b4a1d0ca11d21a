"""The paper's silo flows against our runs: its cases, its statements, what the runs say, and a verdict on each."""
