"""Where each variant of the method fails: one file a failure mode, each with `cells`, its rows of the map."""
