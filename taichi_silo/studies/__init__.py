"""Many runs: sweeps, comparisons, element tests."""
