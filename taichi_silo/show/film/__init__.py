"""Films and pictures of a run, drawn afterwards."""
