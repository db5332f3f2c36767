"""Gateware of the arcref 23-bit reference angle encoder, in Amaranth."""
