"""The wire in gateware: UART, packets, the register file and what stands behind it."""
