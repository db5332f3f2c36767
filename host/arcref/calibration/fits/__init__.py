"""Fits: curves through the errors at the faces that say the error at every angle, behind one interface."""
