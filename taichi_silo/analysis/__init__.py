"""Numbers from states and from theories: point fields, measures, closed-form theories."""
