"""The contract of the wire: registers, packets and capture records, in pure Python for gateware and host alike."""
