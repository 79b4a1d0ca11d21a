"""Numbers from arrays: measures of states, and closed-form theories."""
