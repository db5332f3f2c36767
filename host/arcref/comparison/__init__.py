"""Dynamic comparison: an encoder under test against the reference, at speed, strobe by strobe."""
