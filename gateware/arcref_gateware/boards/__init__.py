"""Boards: from pins and clocks to sample words, and from the core to a bitstream."""
