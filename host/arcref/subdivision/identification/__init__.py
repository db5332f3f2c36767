"""Ways to find the parameters of the signals from their samples, behind one interface."""
